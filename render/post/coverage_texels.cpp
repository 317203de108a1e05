#include "render/post/coverage_texels.h"

#include "render/post/coverage_bricks.h"
#include "render/post/coverage_rings.h"
#include "scene/coverage_levels.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <utility>

#include <tbb/parallel_for.h>

namespace render {

namespace {

using Place = VoxelPlace;

/// A cube of voxels: its first one, and how many along its edge.
struct Cube {
    Place first{0, 0, 0};
    std::size_t edge = 0;

    Cube cell(int bit) const {
        const auto b = static_cast<std::size_t>(bit);
        const std::size_t part = edge / scene::kCoverageBranching;
        return {{first[0] + b % 4 * part, first[1] + b / 4 % 4 * part, first[2] + b / 16 * part}, part};
    }
};

/// A box of the cube's voxels, of which there are `across` along its edge.
struct Box {
    std::size_t across = 0;
    Place first{}, count{};

    std::size_t voxels() const { return count[0] * count[1] * count[2]; }
    bool isSmallEnough() const {
        return voxels() <= kMostVoxels && count[0] + count[1] + count[2] <= kMostVoxelsOnARay;
    }
    Place placeOf(std::size_t index) const { ///< counted from the first
        return {index % count[0], index / count[0] % count[1], index / count[0] / count[1]};
    }
    std::size_t indexOf(const Place& at) const {
        return ((at[2] - first[2]) * count[1] + at[1] - first[1]) * count[0] + at[0] - first[0];
    }
};

std::size_t acrossAt(int level) {
    return std::size_t{1} << (2 * level);
}
int levelOf(const Box& box) {
    return std::countr_zero(box.across) / 2;
}

/// From the least to the greatest cell of the finest level that voxels may have in which anything was observed.
struct ObservedBounds {
    Place least{acrossAt(kMostVoxelLevel), acrossAt(kMostVoxelLevel), acrossAt(kMostVoxelLevel)}, end{};

    /// Cells of the last level that are divided further count as observed.
    explicit ObservedBounds(const UnseenTree& tree, int levels = kMostVoxelLevel)
        : smallest_(acrossAt(kMostVoxelLevel - std::min(levels, kMostVoxelLevel))) {
        add(tree.nodes(), 0, {{0, 0, 0}, acrossAt(kMostVoxelLevel)});
    }
    bool isNothing() const { return end[0] == 0; }

  private:
    void add(const std::vector<scene::CoverageNode>& nodes, std::size_t index, const Cube& cube) {
        const scene::CoverageNode& node = nodes[index];
        for (std::uint64_t left = ~node.unseen; left != 0; left &= left - 1) {
            const int bit = std::countr_zero(left);
            const Cube cell = cube.cell(bit);
            const auto isKnown = [&](std::size_t axis) {
                return cell.first[axis] >= least[axis] && cell.first[axis] + cell.edge <= end[axis];
            };
            if (isKnown(0) && isKnown(1) && isKnown(2)) continue;
            if ((node.children & scene::coverageMask(bit)) != 0 && cell.edge > smallest_) {
                add(nodes, node.firstChild + scene::childRank(node.children, bit), cell);
                continue;
            }
            for (std::size_t axis = 0; axis < 3; ++axis) {
                least[axis] = std::min(least[axis], cell.first[axis]);
                end[axis] = std::max(end[axis], cell.first[axis] + cell.edge);
            }
        }
    }

    std::size_t smallest_;
};

/// The box at a level of the tree, with a voxel more on each side where there is one, and rows of whole vectors.
Box boxAt(const ObservedBounds& observed, int level) {
    Box box{acrossAt(level), {}, {}};
    const std::size_t unit = acrossAt(kMostVoxelLevel - level);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t least = observed.least[axis] / unit, end = (observed.end[axis] + unit - 1) / unit;
        box.first[axis] = least - std::min<std::size_t>(least, 1);
        box.count[axis] = std::min(end + 1, box.across) - box.first[axis];
    }
    box.count[0] = (box.count[0] + kVoxelLines - 1) / kVoxelLines * kVoxelLines;
    box.first[0] = std::min(box.first[0], box.across - box.count[0]);
    return box;
}

/// The finest level that voxels may be of: no finer than the tree, nor than is of use.
int finestVoxelLevel(const scene::Coverage& coverage, int levels) {
    int level = std::clamp(levels, kLeastVoxelLevel, kMostVoxelLevel);
    while (level > kLeastVoxelLevel && scene::cellOfLevels(coverage, level) < kFineEnoughVoxelMetres)
        --level;
    return level;
}

/// As fine as the most voxels allow.
Box boxOf(const scene::Coverage& coverage, int levels, const ObservedBounds& observed) {
    if (observed.isNothing()) return {acrossAt(kLeastVoxelLevel), {0, 0, 0}, {kVoxelLines, 1, 1}};
    Box box = boxAt(observed, kLeastVoxelLevel);
    for (int level = kLeastVoxelLevel + 1; level <= finestVoxelLevel(coverage, levels); ++level)
        if (const Box finer = boxAt(observed, level); finer.isSmallEnough()) box = finer;
    return box;
}

UnseenGrid gridOf(const Box& box) {
    const auto placed = [](const Place& place) { return vec3(glm::dvec3(place[0], place[1], place[2])); };
    return {placed(box.first), static_cast<float>(box.across), placed(box.count)};
}

/// What the tree says of each voxel.
class Voxels {
  public:
    Voxels(const UnseenTree& tree, const Box& box) : rings(box.voxels(), kMostRings), tree_(tree), box_(box) {
        put(0, {{0, 0, 0}, box.across});
        std::sort(divided.begin(), divided.end());
        countRings(rings, box.count);
    }

    std::vector<std::uint8_t> rings;                            ///< 0 where nodes are, too
    std::vector<std::pair<std::size_t, std::uint32_t>> divided; ///< in order, and the nodes that they are

    /// Open ones right beside what is not, if any is divided.
    std::vector<std::size_t> besideClosed() const {
        std::vector<std::size_t> voxels;
        for (std::size_t i = 0; i < rings.size() && !divided.empty(); ++i)
            if (rings[i] == 1) voxels.push_back(i);
        return voxels;
    }

  private:
    void put(std::size_t node, const Cube& cube) {
        for (std::uint64_t left = tree_.nodes()[node].unseen; left != 0; left &= left - 1)
            close(cube.cell(std::countr_zero(left)));
        for (std::uint64_t left = tree_.divided(node); left != 0; left &= left - 1) {
            const Cube cell = cube.cell(std::countr_zero(left));
            const std::size_t child = tree_.child(node, std::countr_zero(left));
            if (cell.edge > 1) {
                put(child, cell);
                continue;
            }
            // Where nothing was observed there may be no voxels, and the tree may be divided for nothing.
            if (!isInBox(cell.first)) continue;
            divided.emplace_back(box_.indexOf(cell.first), static_cast<std::uint32_t>(child));
            close(cell);
        }
    }

    bool isInBox(const Place& at) const {
        const auto isIn = [&](std::size_t axis) {
            return at[axis] >= box_.first[axis] && at[axis] < box_.first[axis] + box_.count[axis];
        };
        return isIn(0) && isIn(1) && isIn(2);
    }

    /// As much of it as is in the box.
    void close(const Cube& cube) {
        Place low{}, high{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            low[axis] = std::max(cube.first[axis], box_.first[axis]);
            high[axis] = std::min(cube.first[axis] + cube.edge, box_.first[axis] + box_.count[axis]);
            if (low[axis] >= high[axis]) return;
        }
        for (std::size_t z = low[2]; z < high[2]; ++z)
            for (std::size_t y = low[1]; y < high[1]; ++y)
                std::fill_n(&rings[box_.indexOf({low[0], y, z})], high[0] - low[0], std::uint8_t{0});
    }

    const UnseenTree& tree_;
    const Box& box_;
};

} // namespace

CoverageTexels coverageTexels(const scene::Coverage& coverage) {
    const UnseenTree tree(coverage);
    const Box box = boxOf(coverage, scene::levelsOf(coverage), ObservedBounds(tree));
    const Voxels voxels(tree, box);
    std::vector<std::uint32_t> words(voxels.rings.begin(), voxels.rings.end()), nodes;
    for (const auto& [voxel, node] : voxels.divided) {
        words[voxel] = kBrick | static_cast<std::uint32_t>(nodes.size());
        nodes.push_back(node);
    }
    BrickOrder order = orderBricks(tree, std::move(nodes));
    const std::vector<std::size_t> open = voxels.besideClosed();
    const std::size_t bricks = order.nodes.size() + open.size();
    CoverageTexels all{gridOf(box), {}, std::vector<std::uint32_t>(kWordsPerBrick * bricks), {}};
    if (bricks > 0) all.brickLevels = order.nodes.size() > voxels.divided.size() ? 2 : 1;
    const BrickedGrid grid(tree, order, box.count, words);
    tbb::parallel_for(std::size_t{0}, voxels.divided.size(),
                      [&](std::size_t i) { grid.writeDivided(box.placeOf(voxels.divided[i].first), all.bricks); });
    tbb::parallel_for(std::size_t{0}, open.size(),
                      [&](std::size_t i) { grid.writeOpen(box.placeOf(open[i]), order.nodes.size() + i, all.bricks); });
    // Not before: to others they were open.
    for (std::size_t i = 0; i < open.size(); ++i)
        words[open[i]] = kBrick | static_cast<std::uint32_t>(order.nodes.size() + i);
    all.words = std::move(words);
    all.bases = std::move(order.bases);
    all.bases.resize(bricks); // of open ones nothing is below
    return all;
}

std::vector<CoverageSize> coverageSizesByLevels(const scene::Coverage& coverage) {
    const UnseenTree tree(coverage);
    const std::vector<std::size_t> firsts = scene::firstNodesOf(coverage);
    std::vector<std::size_t> nodes; // of each level, with something unseen
    for (std::size_t level = 0; level + 1 < firsts.size(); ++level) {
        nodes.push_back(0);
        for (std::size_t i = firsts[level]; i < firsts[level + 1]; ++i)
            nodes.back() += tree.hasUnseen(i) ? 1 : 0;
    }
    const int all = static_cast<int>(nodes.size());
    const Box exact = boxOf(coverage, all, ObservedBounds(tree));
    const std::size_t beside = Voxels(tree, exact).besideClosed().size();
    const int voxelLevel = levelOf(exact);
    std::vector<CoverageSize> sizes(1);
    for (int levels = 1; levels <= all; ++levels) {
        // A tree is coarsened below what the box of voxels is found by, if it keeps more levels than that. If not, it
        // is within this one, perhaps of finer voxels: those of the tree's last level, without bricks.
        const Box whole = boxOf(coverage, levels, ObservedBounds(tree, levels));
        const bool isThis = levelOf(whole) == finestVoxelLevel(coverage, levels);
        CoverageSize size{isThis ? whole.voxels() : kMostVoxels, 0};
        if (levels == all || levels > kMostVoxelLevel) size.words = exact.voxels();
        // What is coarsened is open where it was, or where it was divided.
        if (levels > voxelLevel) size.bricks = beside;
        for (int level = voxelLevel; level < levels; ++level)
            size.bricks += nodes[static_cast<std::size_t>(level)];
        sizes.push_back(size);
    }
    return sizes;
}

} // namespace render
