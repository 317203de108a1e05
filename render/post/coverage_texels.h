#pragma once
// What was observed (scene/coverage.h) as shaders read it (shaders/shared/unseen.h): the tree, and beside it a grid of
// voxels, each of which knows how far about it nothing is unseen, so that rays cross open space in few steps.

#include "scene/coverage.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace render {

using CoverageTexel = std::array<std::uint32_t, 4>;

/// Texels, one after another:
///
///     rings    of the voxels, a byte each, x first, then y, then z
///     bases    a word for sixteen voxels: how many divided ones come before them
///     nodes    two texels each: masks of unseen and of divided cells, low words first; (first child, 0, 0, 0)
///
/// Nodes of divided voxels come first, in the voxels' order, then all below. A cell without unseen space in it counts
/// as seen whole, however it is divided. The same on any number of threads.
std::vector<CoverageTexel> coverageTexels(const scene::Coverage& coverage);

/// How many texels at most there are of it coarsened to so many levels (scene/coverage_levels.h), by levels: from 0, of
/// which there is none, to all it has.
std::vector<std::size_t> coverageTexelsByLevels(const scene::Coverage& coverage);

} // namespace render
