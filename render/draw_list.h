#pragma once
// The visible tiles of one eye, each with its own warp, in the order in which they lie in memory, page by page: the
// z-buffer makes no difference between orders.

#include "render/gpu_scene.h"
#include "render/quality.h"
#include "render/shaders/shared/tile_draw.h"

#include <cstdint>
#include <span>
#include <vector>

namespace render {

/// Consecutive draws from one page.
struct DrawRun {
    std::uint32_t page = 0, first = 0, count = 0;
};

struct DrawList {
    std::vector<DrawRun> runs;
    std::uint32_t tiles = 0;
    std::uint64_t items = 0; ///< samples (points) or mesh squares
    /// Scratch, kept from frame to frame: the tiles to draw, their order levels, how many of each piece.
    std::vector<std::uint32_t> numbers;
    std::vector<std::uint8_t> levels;
    std::vector<std::uint32_t> counts;
};

/// What the warp of this tile needs, at an order level (scene/preference.h). C is multiplied out in double precision
/// and only then rounded.
TileDraw tileDrawOf(const glm::dmat4& eyeImageFromSource, const ResidentTile& tile, int orderLevel = 0);

/// Builds the list of all tiles that have items for this warp, and writes draws (room for all tiles of the
/// scene). eyeImagesFromSources: one C per image; eyeFromCameras: how far
/// the eye stands from the image's camera, metres in the world. The same bytes on any number of threads.
void buildDrawList(std::span<const ResidentTile> tiles, const TileBounds& bounds, std::span<const TilePiece> pieces,
                   std::span<const glm::dmat4> eyeImagesFromSources, std::span<const glm::dvec3> eyeFromCameras,
                   const VisibleTiles& visible, const Quality& quality, std::span<TileDraw> draws, DrawList& list);

} // namespace render
