#include "render/post/coverage_texels.h"

#include "render/shaders/shared/unseen.h"
#include "scene/coverage_levels.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <iterator>
#include <utility>

#include <tbb/parallel_for.h>

namespace render {

namespace {

constexpr std::size_t kAcross = kVoxelsAcross, kVoxels = kAcross * kAcross * kAcross;
constexpr std::uint8_t kOpen = 254; ///< before rings are counted: nothing unseen in it

using Texels = std::vector<CoverageTexel>;
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

/// A cube of voxels: its first one, and how many along its edge.
struct Cube {
    std::array<std::size_t, 3> first{0, 0, 0};
    std::size_t edge = 0;
};

std::size_t indexOf(const std::array<std::size_t, 3>& at) {
    return (at[2] * kAcross + at[1]) * kAcross + at[0];
}

/// What the tree says of each voxel.
class Voxels {
  public:
    explicit Voxels(const Tree& tree) : rings(kVoxels, kOpen), tree_(tree) {
        put(0, {{0, 0, 0}, kAcross});
        std::sort(divided.begin(), divided.end());
    }

    Rings rings;
    std::vector<std::pair<std::size_t, std::size_t>> divided; ///< voxels, in order, and the nodes that they are

  private:
    void put(std::size_t node, const Cube& cube) {
        const std::size_t edge = cube.edge / scene::kCoverageBranching;
        const auto cellOf = [&](int bit) {
            const auto b = static_cast<std::size_t>(bit);
            return Cube{{cube.first[0] + b % 4 * edge, cube.first[1] + b / 4 % 4 * edge, cube.first[2] + b / 16 * edge},
                        edge};
        };
        for (std::uint64_t left = tree_.nodes[node].unseen; left != 0; left &= left - 1)
            fill(cellOf(std::countr_zero(left)), 0);
        tree_.forChildren(node, [&](int bit, std::size_t child) {
            if (edge > 1) return put(child, cellOf(bit));
            divided.emplace_back(indexOf(cellOf(bit).first), child);
            fill(cellOf(bit), kDividedVoxel);
        });
    }

    void fill(const Cube& cube, std::uint8_t value) {
        for (std::size_t z = cube.first[2]; z < cube.first[2] + cube.edge; ++z)
            for (std::size_t y = cube.first[1]; y < cube.first[1] + cube.edge; ++y)
                std::fill_n(&rings[indexOf({cube.first[0], y, z})], cube.edge, value);
    }

    const Tree& tree_;
};

/// Those of divided voxels in the voxels' order, then all below them.
Texels nodesOf(const Tree& tree, const Voxels& voxels) {
    std::vector<std::size_t> kept;
    for (const auto& [voxel, node] : voxels.divided)
        kept.push_back(node);
    Texels texels;
    for (std::size_t i = 0; i < kept.size(); ++i) {
        const auto firstChild = static_cast<std::uint32_t>(kept.size());
        std::uint64_t children = 0;
        tree.forChildren(kept[i], [&](int bit, std::size_t child) {
            children |= scene::coverageMask(bit);
            kept.push_back(child);
        });
        const std::uint64_t unseen = tree.nodes[kept[i]].unseen;
        const auto low = [](std::uint64_t mask) { return static_cast<std::uint32_t>(mask); };
        texels.push_back({low(unseen), low(unseen >> 32), low(children), low(children >> 32)});
        texels.push_back({firstChild, 0, 0, 0});
    }
    return texels;
}

/// Along a line of voxels that are open or not: how far each is from what is not open. Outside nothing was observed.
void countAlongFirst(std::uint8_t* line) {
    std::uint8_t far = 0;
    const auto visit = [&](std::uint8_t& voxel) {
        far = std::min(voxel, static_cast<std::uint8_t>(far + 1));
        voxel = far;
    };
    std::for_each(line, line + kAcross, visit);
    far = 0;
    std::for_each(std::reverse_iterator(line + kAcross), std::reverse_iterator(line), visit);
}

// By value: what std::min and std::max do through references g++ 12 makes no vectors of.
constexpr std::uint8_t lesser(std::uint8_t a, std::uint8_t b) {
    return a < b ? a : b;
}
constexpr std::uint8_t greater(std::uint8_t a, std::uint8_t b) {
    return a > b ? a : b;
}

constexpr std::size_t kLines = 32; ///< that lie side by side, as one vector instruction or two take them
using Side = std::array<std::uint8_t, kLines>;

/// Along such lines, the voxels of each `step` apart: the least over all voxels of a line of how far that one is from
/// what is not open, along the axes before, or on this line itself, whichever is more.
void countAlong(std::uint8_t* lines, std::size_t step) {
    std::array<Side, kAcross> from;
    for (std::size_t i = 0; i < kAcross; ++i)
        std::copy_n(lines + i * step, kLines, from[i].begin());
    for (std::size_t i = 0; i < kAcross; ++i) {
        Side best;
        const auto toOutside = static_cast<std::uint8_t>(std::min(i + 1, kAcross - i));
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
void countRings(Rings& rings) {
    std::vector<std::uint8_t> isDivided(rings.size());
    std::transform(rings.begin(), rings.end(), isDivided.begin(),
                   [](std::uint8_t ring) { return std::uint8_t{ring == kDividedVoxel}; });
    std::replace(rings.begin(), rings.end(), std::uint8_t{kDividedVoxel}, std::uint8_t{0});
    constexpr std::size_t kPlane = kAcross * kAcross;
    tbb::parallel_for(std::size_t{0}, kPlane, [&](std::size_t line) { countAlongFirst(&rings[line * kAcross]); });
    const auto alongAll = [&](std::size_t step, std::size_t perOther) {
        tbb::parallel_for(std::size_t{0}, kAcross, [&](std::size_t other) {
            for (std::size_t x = 0; x < kAcross; x += kLines)
                countAlong(&rings[other * perOther + x], step);
        });
    };
    alongAll(kAcross, kPlane);
    alongAll(kPlane, kAcross);
    for (std::size_t i = 0; i < rings.size(); ++i)
        if (isDivided[i] != 0) rings[i] = kDividedVoxel;
}

} // namespace

Texels coverageTexels(const scene::Coverage& coverage) {
    const Tree tree(coverage);
    Voxels voxels(tree);
    countRings(voxels.rings);
    Texels texels(kFirstCoverageNode);
    for (std::size_t i = 0; i < kVoxels; ++i)
        texels[i / 16][i / 4 % 4] |= std::uint32_t{voxels.rings[i]} << 8 * (i % 4);
    std::uint32_t before = 0;
    for (std::size_t i = 0; i < kVoxels / 16; ++i) {
        texels[kFirstBase + i / 4][i % 4] = before;
        while (before < voxels.divided.size() && voxels.divided[before].first / 16 == i)
            ++before;
    }
    const Texels nodes = nodesOf(tree, voxels);
    texels.insert(texels.end(), nodes.begin(), nodes.end());
    return texels;
}

std::vector<std::size_t> coverageTexelsByLevels(const scene::Coverage& coverage) {
    const std::vector<std::uint8_t> hasUnseen = findUnseen(coverage.nodes);
    const std::vector<std::size_t> firsts = scene::firstNodesOf(coverage);
    std::vector<std::size_t> texels{kFirstCoverageNode};
    for (std::size_t level = 0; level + 1 < firsts.size(); ++level) {
        // Above those that voxels are divided into, the grid stands for the tree.
        std::size_t nodes = 0;
        if (level >= kVoxelLevels)
            for (std::size_t i = firsts[level]; i < firsts[level + 1]; ++i)
                nodes += hasUnseen[i];
        texels.push_back(texels.back() + kTexelsPerCoverageNode * nodes);
    }
    return texels;
}

} // namespace render
