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

/// How an eye stands to an image of the scene, or to a coarser level of one.
struct SourceView {
    glm::dmat4 eyeImageFromSource{1.0}; ///< C
    glm::dvec3 eyeFromCamera{0};        ///< how far the eye stands from the camera, metres in the world
    double pixelsPerSample = 1;         ///< how wide the eye sees a sample from where it was taken
    std::uint32_t captured = 0, level = 0;
    bool hasCoarser = false;
    bool isNear = true; ///< the camera stands near the eye, by what it mostly sees: all levels of an image alike
};

std::vector<SourceView> sourceViewsOf(std::span<const ResidentImage> images, const scene::View& eye,
                                      const Quality& quality);

/// Consecutive draws from one page by one shader.
struct DrawRun {
    std::uint32_t page = 0, first = 0, count = 0;
    Warp warp = Warp::points;
};

struct DrawList {
    std::vector<DrawRun> runs;
    std::uint32_t tiles = 0;
    std::uint64_t items = 0; ///< samples (points), mesh squares or facets
    /// Scratch, kept from frame to frame: the tiles to draw, by piece; how many of each; and in which order.
    struct Chosen {
        std::uint32_t tile = 0, orderLevel = 0;
        Warp warp = Warp::points;
        vec4 detail{0};
    };
    std::vector<Chosen> chosen;
    std::vector<std::uint32_t> counts, order;
};

/// What the warp of this tile needs, at an order level (scene/preference.h). C is multiplied out in double precision
/// and only then rounded.
TileDraw tileDrawOf(const glm::dmat4& eyeImageFromSource, const ResidentTile& tile, int orderLevel = 0);

/// Builds the list of all tiles that have items for this warp, and writes draws (room for all tiles of the
/// scene). sources: one for each of the scene's images. The same bytes on any number of threads.
void buildDrawList(std::span<const ResidentTile> tiles, const TileBounds& bounds, std::span<const TilePiece> pieces,
                   std::span<const SourceView> sources, const VisibleTiles& visible, const Quality& quality,
                   std::span<TileDraw> draws, DrawList& list);

} // namespace render
