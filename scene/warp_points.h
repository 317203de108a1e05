#pragma once
// The points of one tile, projected and scattered by vectors; for scene/warp_points.cpp.

#include "scene/tile_warp.h"
#include "scene/warp_target.h"

#include <span>

namespace scene {

/// Draws each vertex as a square of footprint x footprint pixels. Does what projectVertex and keyOf say, bit by bit.
/// zBuffer has fewer than 2^31 pixels and neither side longer than 2^24.
RowRange drawPoints(const TileWarp& warp, std::span<const TileVertex> vertices, int footprint,
                    ImageView<std::uint64_t> zBuffer);

/// into = max(into, from), value by value.
void mergeKeys(std::span<const std::uint64_t> from, std::span<std::uint64_t> into);

} // namespace scene
