#pragma once
// Drawing many tiles into one z-buffer on several threads; for the warps on the processor.

#include "scene/tile_warp.h"

#include <functional>
#include <span>

namespace scene {

/// Rows of an image from first up to, not including, end; none if end <= first.
struct RowRange {
    int first = 0, end = 0;
};

/// Draws one tile and says which rows it may have changed.
using DrawTile =
    std::function<RowRange(const TileBlock& block, const Tile& tile, const glm::dmat4& eyeImageFromSourceImage,
                           const TileWarp& warp, ImageView<std::uint64_t> zBuffer)>;

/// How many vertices of a tile are worked on: what the number of threads is chosen by.
using CountVertices = std::uint32_t Tile::*;

/// Draws every tile that the eye's preference admits; the greatest key of all wins, and of what zBuffer held. Each
/// thread draws into a z-buffer of its own (the first into zBuffer itself), and there are no more of them than the work
/// repays.
void drawTiles(std::span<const TileBlock> blocks, const View& eye, const PreferenceOptions& preference,
               CountVertices vertexCount, const DrawTile& drawTile, ZBuffer& zBuffer);

} // namespace scene
