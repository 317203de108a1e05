#include "render/post/coverage_texels.h"

#include "scene/coverage_levels.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <iterator>
#include <utility>

#include <tbb/parallel_for.h>

namespace render {

namespace {

constexpr std::uint8_t kOpen = 254;       ///< before rings are counted: nothing unseen in it; and the most rings
constexpr std::size_t kVoxelsPerWord = 4; ///< of rings, and of bases
constexpr std::size_t kLines = 32;        ///< that lie side by side, as one vector instruction or two take them

using Rings = std::vector<std::uint8_t>;

/// Whether there is any unseen space in a node or below; children come after their parents.
std::vector<std::uint8_t> findUnseen(const std::vector<scene::CoverageNode>& nodes) {
    std::vector<std::uint8_t> hasUnseen(nodes.size());
    for (std::size_t i = nodes.size(); i-- > 0;) {
        hasUnseen[i] = nodes[i].unseen != 0;
        for (int child = 0; child < std::popcount(nodes[i].children); ++child)
            hasUnseen[i] |= hasUnseen[nodes[i].firstChild + static_cast<std::size_t>(child)];
    }
    return hasUnseen;
}

/// The tree, without children that hold nothing unseen.
struct Tree {
    const std::vector<scene::CoverageNode>& nodes;
    std::vector<std::uint8_t> hasUnseen;

    explicit Tree(const scene::Coverage& coverage) : nodes(coverage.nodes), hasUnseen(findUnseen(coverage.nodes)) {}

    /// Calls with the bit and the node of each child that is left.
    template <class Visit>
    void forChildren(std::size_t node, const Visit& visit) const {
        for (std::uint64_t left = nodes[node].children; left != 0; left &= left - 1) {
            const int bit = std::countr_zero(left);
            const std::size_t child = nodes[node].firstChild + scene::childRank(nodes[node].children, bit);
            if (hasUnseen[child] != 0) visit(bit, child);
        }
    }
};

using Place = std::array<std::size_t, 3>;

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
    explicit ObservedBounds(const Tree& tree, int levels = kMostVoxelLevel)
        : smallest_(acrossAt(kMostVoxelLevel - std::min(levels, kMostVoxelLevel))) {
        add(tree.nodes, 0, {{0, 0, 0}, acrossAt(kMostVoxelLevel)});
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
    box.count[0] = (box.count[0] + kLines - 1) / kLines * kLines;
    box.first[0] = std::min(box.first[0], box.across - box.count[0]);
    return box;
}

/// As fine as the most voxels allow, and no finer than the tree.
Box boxOf(int levels, const ObservedBounds& observed) {
    if (observed.isNothing()) return {acrossAt(kLeastVoxelLevel), {0, 0, 0}, {kLines, 1, 1}};
    Box box = boxAt(observed, kLeastVoxelLevel);
    for (int level = kLeastVoxelLevel + 1; level <= std::min(levels, kMostVoxelLevel); ++level)
        if (const Box finer = boxAt(observed, level); finer.isSmallEnough()) box = finer;
    return box;
}

UnseenGrid gridOf(const Box& box) {
    const auto placed = [](const Place& place) { return vec3(glm::dvec3(place[0], place[1], place[2])); };
    return {placed(box.first), static_cast<float>(box.across), placed(box.count),
            static_cast<std::uint32_t>(box.voxels() / kVoxelsPerWord)};
}

/// What the tree says of each voxel.
class Voxels {
  public:
    Voxels(const Tree& tree, const Box& box) : rings(box.voxels(), kOpen), tree_(tree), box_(box) {
        put(0, {{0, 0, 0}, box.across});
        std::sort(divided.begin(), divided.end());
    }

    Rings rings;
    std::vector<std::pair<std::size_t, std::size_t>> divided; ///< voxels, in order, and the nodes that they are

  private:
    void put(std::size_t node, const Cube& cube) {
        for (std::uint64_t left = tree_.nodes[node].unseen; left != 0; left &= left - 1)
            fill(cube.cell(std::countr_zero(left)), 0);
        tree_.forChildren(node, [&](int bit, std::size_t child) {
            const Cube cell = cube.cell(bit);
            if (cell.edge > 1) return put(child, cell);
            // Where nothing was observed there may be no voxels, and the tree may be divided for nothing.
            if (!isInBox(cell.first)) return;
            divided.emplace_back(box_.indexOf(cell.first), child);
            fill(cell, kDividedVoxel);
        });
    }

    bool isInBox(const Place& at) const {
        const auto isIn = [&](std::size_t axis) {
            return at[axis] >= box_.first[axis] && at[axis] < box_.first[axis] + box_.count[axis];
        };
        return isIn(0) && isIn(1) && isIn(2);
    }

    /// As much of it as is in the box.
    void fill(const Cube& cube, std::uint8_t value) {
        Place low{}, high{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            low[axis] = std::max(cube.first[axis], box_.first[axis]);
            high[axis] = std::min(cube.first[axis] + cube.edge, box_.first[axis] + box_.count[axis]);
            if (low[axis] >= high[axis]) return;
        }
        for (std::size_t z = low[2]; z < high[2]; ++z)
            for (std::size_t y = low[1]; y < high[1]; ++y)
                std::fill_n(&rings[box_.indexOf({low[0], y, z})], high[0] - low[0], value);
    }

    const Tree& tree_;
    const Box& box_;
};

/// Those of divided voxels in the voxels' order, then all below them.
void addNodes(const Tree& tree, const Voxels& voxels, CoverageTexels& texels) {
    std::vector<std::size_t> kept;
    for (const auto& [voxel, node] : voxels.divided)
        kept.push_back(node);
    for (std::size_t i = 0; i < kept.size(); ++i) {
        const auto firstChild = static_cast<std::uint32_t>(kept.size());
        std::uint64_t children = 0;
        tree.forChildren(kept[i], [&](int bit, std::size_t child) {
            children |= scene::coverageMask(bit);
            kept.push_back(child);
        });
        const std::uint64_t unseen = tree.nodes[kept[i]].unseen;
        const auto low = [](std::uint64_t mask) { return static_cast<std::uint32_t>(mask); };
        texels.masks.push_back({low(unseen), low(children)});
        texels.masks.push_back({low(unseen >> 32), low(children >> 32)});
        texels.links.push_back({firstChild, static_cast<std::uint32_t>(std::popcount(low(children)))});
    }
}

/// Along a line of voxels that are open or not: how far each is from what is not open. Outside nothing was observed.
void countAlongFirst(std::uint8_t* line, std::size_t count) {
    std::uint8_t far = 0;
    const auto visit = [&](std::uint8_t& voxel) {
        far = std::min(voxel, static_cast<std::uint8_t>(far + 1));
        voxel = far;
    };
    std::for_each(line, line + count, visit);
    far = 0;
    std::for_each(std::reverse_iterator(line + count), std::reverse_iterator(line), visit);
}

// By value: what std::min and std::max do through references g++ 12 makes no vectors of.
constexpr std::uint8_t lesser(std::uint8_t a, std::uint8_t b) {
    return a < b ? a : b;
}
constexpr std::uint8_t greater(std::uint8_t a, std::uint8_t b) {
    return a > b ? a : b;
}

using Side = std::array<std::uint8_t, kLines>;

/// Along such lines, the `count` voxels of each `step` apart: the least over all voxels of a line of how far that one
/// is from what is not open, along the axes before, or on this line itself, whichever is more.
void countAlong(std::uint8_t* lines, std::size_t count, std::size_t step) {
    std::vector<Side> from(count);
    for (std::size_t i = 0; i < count; ++i)
        std::copy_n(lines + i * step, kLines, from[i].begin());
    for (std::size_t i = 0; i < count; ++i) {
        Side best;
        const auto toOutside = static_cast<std::uint8_t>(std::min({i + 1, count - i, std::size_t{kOpen}}));
        std::uint8_t most = 0; // of the lines; what lies farther off than that is no nearer to any
        for (std::size_t l = 0; l < kLines; ++l) {
            best[l] = lesser(from[i][l], toOutside);
            most = greater(most, best[l]);
        }
        for (std::uint8_t k = 1; k < most; ++k) {
            const Side &before = from[i - k], &after = from[i + k];
            most = 0;
            for (std::size_t l = 0; l < kLines; ++l) {
                best[l] = lesser(best[l], greater(k, lesser(before[l], after[l])));
                most = greater(most, best[l]);
            }
        }
        std::copy(best.begin(), best.end(), lines + i * step);
    }
}

/// Counts the rings of open voxels about each open one, itself the first: the chessboard distance (Rosenfeld and
/// Pfaltz, "Distance functions on digital pictures", 1968) to the nearest that is not, which one axis after the other
/// finds.
void countRings(Rings& rings, const Box& box) {
    std::vector<std::uint8_t> isDivided(rings.size());
    std::transform(rings.begin(), rings.end(), isDivided.begin(),
                   [](std::uint8_t ring) { return std::uint8_t{ring == kDividedVoxel}; });
    std::replace(rings.begin(), rings.end(), std::uint8_t{kDividedVoxel}, std::uint8_t{0});
    const auto [x, y, z] = box.count;
    const std::size_t plane = x * y;
    tbb::parallel_for(std::size_t{0}, y * z, [&, x = x](std::size_t line) { countAlongFirst(&rings[line * x], x); });
    const auto alongAll = [&, x = x](std::size_t count, std::size_t step, std::size_t others, std::size_t perOther) {
        tbb::parallel_for(std::size_t{0}, others, [&](std::size_t other) {
            for (std::size_t line = 0; line < x; line += kLines)
                countAlong(&rings[other * perOther + line], count, step);
        });
    };
    alongAll(y, x, z, plane);
    alongAll(z, plane, y, x);
    for (std::size_t i = 0; i < rings.size(); ++i)
        if (isDivided[i] != 0) rings[i] = kDividedVoxel;
}

} // namespace

CoverageTexels coverageTexels(const scene::Coverage& coverage) {
    const Tree tree(coverage);
    const Box box = boxOf(scene::levelsOf(coverage), ObservedBounds(tree));
    Voxels voxels(tree, box);
    countRings(voxels.rings, box);
    CoverageTexels all{gridOf(box), {}, {}, {}};
    addNodes(tree, voxels, all);
    const std::size_t bases = all.grid.firstBase;
    all.words.resize(2 * bases);
    for (std::size_t i = 0; i < voxels.rings.size(); ++i)
        all.words[i / kVoxelsPerWord] |= std::uint32_t{voxels.rings[i]} << 8 * (i % kVoxelsPerWord);
    std::uint32_t before = 0;
    for (std::size_t i = 0; i < bases; ++i) {
        all.words[bases + i] = before;
        while (before < voxels.divided.size() && voxels.divided[before].first / kVoxelsPerWord == i)
            ++before;
    }
    return all;
}

std::vector<CoverageSize> coverageSizesByLevels(const scene::Coverage& coverage) {
    const Tree tree(coverage);
    const std::vector<std::size_t> firsts = scene::firstNodesOf(coverage);
    const int all = static_cast<int>(firsts.size()) - 1;
    const Box exact = boxOf(all, ObservedBounds(tree));
    std::vector<CoverageSize> sizes(1);
    for (int levels = 1; levels <= all; ++levels) {
        // Which box it is once it is coarsened is not known: within this one, perhaps of finer voxels.
        const Box whole = boxOf(levels, ObservedBounds(tree, levels));
        const bool isFinest = whole.across == acrossAt(std::clamp(levels, kLeastVoxelLevel, kMostVoxelLevel));
        const std::size_t voxels = levels == all ? exact.voxels() : isFinest ? whole.voxels() : kMostVoxels;
        const int below = levels == all ? levelOf(exact) : kLeastVoxelLevel;
        std::size_t nodes = 0; // above those that voxels are divided into, the grid stands for the tree
        for (int level = below; level < levels; ++level)
            for (std::size_t i = firsts[static_cast<std::size_t>(level)];
                 i < firsts[static_cast<std::size_t>(level) + 1]; ++i)
                nodes += tree.hasUnseen[i];
        sizes.push_back({2 * (voxels / kVoxelsPerWord), nodes});
    }
    return sizes;
}

} // namespace render
