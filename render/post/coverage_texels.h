#pragma once
// What was observed (scene/coverage.h) as shaders read it (shaders/shared/unseen.h): the tree, and beside it a grid of
// voxels and bricks, each of which knows how far about it nothing is unseen, so that rays cross open space in few
// steps.

#include "render/shaders/shared/unseen.h"
#include "scene/coverage.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace render {

inline constexpr int kLeastVoxelLevel = 3; ///< of the tree, whose cells voxels are at least as small as
inline constexpr int kMostVoxelLevel = 5;  ///< single precision tells those of bricks apart
inline constexpr std::size_t kMostVoxels = 1u << 24;
/// A ray takes unseen ones one by one, and no more steps than kMostUnseenSteps.
inline constexpr std::size_t kMostVoxelsOnARay = 1536;
/// Of the tree that is worth bringing to a device: with fewer, walls of half a cell's thickness stop counting as
/// unseen.
inline constexpr int kFewestLevels = 4;
/// Above the least level voxels are no finer than this, metres: bricks divide them further where that is of use.
inline constexpr double kFineEnoughVoxelMetres = 0.05;

/// Words of the grid and of bricks (shaders/shared/unseen.h), each in a buffer of its own, since there is a limit to
/// what shaders can read of one:
///
///     words    of the voxels, x first, then y, then z: 0 if all of it is unseen, how many rings of open voxels are
///              about it (coverage_rings.h), or kBrick and which brick it is
///     bricks   eight for each, one for each eight of its voxels
///     bases    one for each: the first of the bricks that its own voxels are
///
/// Voxels in which there is both are bricks, and, if there are any, those that have one ring.
/// A cell without unseen space in it counts as seen whole, however it is divided. The voxels are a box about all that
/// was observed, a voxel more on each side where there is more of the cube: as small as the most of them allow, since
/// sites are wide and flat.
struct CoverageTexels {
    UnseenGrid grid;
    std::vector<std::uint32_t> words, bricks, bases;
    std::uint32_t brickLevels = 0; ///< 1: there are bricks, 2: also within bricks
};

/// The same on any number of threads.
CoverageTexels coverageTexels(const scene::Coverage& coverage);

/// How much the words of the grid and of bricks take.
struct CoverageSize {
    std::size_t words = 0, bricks = 0;
    std::size_t bytes() const { return sizeof(std::uint32_t) * (words + (kWordsPerBrick + 1) * bricks); }
    /// Of the largest of the buffers.
    std::size_t mostTexels() const { return std::max(words, kWordsPerBrick * bricks); }
};

/// That at most, of the coverage coarsened to so many levels (scene/coverage_levels.h), by levels: from 0, of which
/// there is none, to all it has, of which it is exact.
std::vector<CoverageSize> coverageSizesByLevels(const scene::Coverage& coverage);

} // namespace render
