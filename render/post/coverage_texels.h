#pragma once
// What was observed (scene/coverage.h) as shaders read it (shaders/shared/unseen.h): the tree, and beside it a grid of
// voxels, each of which knows how far about it nothing is unseen, so that rays cross open space in few steps.

#include "render/shaders/shared/unseen.h"
#include "scene/coverage.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace render {

inline constexpr int kLeastVoxelLevel = 4;           ///< of the tree, whose cells voxels are at least as small as
inline constexpr int kMostVoxelLevel = 6;            ///< single precision tells them apart
inline constexpr std::size_t kMostVoxels = 1u << 24; ///< as many as there are of the least level in the whole cube
/// A ray takes unseen ones one by one, and no more steps than kMostUnseenSteps.
inline constexpr std::size_t kMostVoxelsOnARay = 1536;

using CoveragePair = std::array<std::uint32_t, 2>;

/// Words of the grid, and pairs of words of the tree below it, each in a buffer of its own, since there is a limit to
/// what shaders can read of one:
///
///     words    rings of the voxels, a byte each, x first, then y, then z;
///              bases: for each four voxels how many divided ones come before them
///     masks    two for each node, of the lower half of its cells and of the upper: of unseen and of divided cells
///     links    one for each node: first child, and how many children are in the lower half
///
/// Nodes of divided voxels come first, in the voxels' order, then all below. A cell without unseen space in it counts
/// as seen whole, however it is divided. The voxels are a box about all that was observed, a voxel more on each side
/// where there is more of the cube: as small as the most of them allow, since sites are wide and flat.
struct CoverageTexels {
    UnseenGrid grid;
    std::vector<std::uint32_t> words;
    std::vector<CoveragePair> masks, links; ///< none if no voxel is divided
};

/// The same on any number of threads.
CoverageTexels coverageTexels(const scene::Coverage& coverage);

/// How much the words and the tree below them take.
struct CoverageSize {
    std::size_t words = 0, nodes = 0;
    std::size_t bytes() const { return sizeof(std::uint32_t) * words + 3 * sizeof(CoveragePair) * nodes; }
    /// Of the largest of the buffers.
    std::size_t mostTexels() const { return std::max(words, 2 * nodes); }
};

/// That at most, of the coverage coarsened to so many levels (scene/coverage_levels.h), by levels: from 0, of which
/// there is none, to all it has, of which it is exact.
std::vector<CoverageSize> coverageSizesByLevels(const scene::Coverage& coverage);

} // namespace render
