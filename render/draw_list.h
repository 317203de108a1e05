#pragma once
// The visible tiles of one eye, each with its own warp, in the order in which they lie in memory, page by page: the
// z-buffer makes no difference between orders.

#include "render/quality.h"
#include "render/scene_index.h"
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
    float share = 1; ///< of its samples, that are drawn
    bool hasCoarser = false;
    bool isOut = false; ///< nothing of it can be seen; then the rest is not known
    bool isNear = true; ///< the camera stands near the eye, by what it mostly sees: all levels of an image alike
};

/// spheres: of the captured images, to pass over those that lie beside the eye's picture or behind it (as far outside
/// as marginPixels counts as within); or none. shares: of the captured images' samples, as many as are drawn; or none:
/// all.
/// Into views, whose memory is used again: of a large site it is megabytes.
void findSourceViews(std::span<const ResidentImage> images, const scene::View& eye, const Quality& quality,
                     std::span<const ImageSphere> spheres, double marginPixels, std::span<const float> shares,
                     std::vector<SourceView>& views);
inline std::vector<SourceView> sourceViewsOf(std::span<const ResidentImage> images, const scene::View& eye,
                                             const Quality& quality) {
    std::vector<SourceView> views;
    findSourceViews(images, eye, quality, {}, 0, {}, views);
    return views;
}

/// Consecutive draws from one page by one shader.
struct DrawRun {
    std::uint32_t page = 0, first = 0, count = 0; ///< count: kMaxWorkgroups at most
    Warp warp = Warp::points;
    std::uint32_t batch = 0; ///< ascending: nearer ones come before
    bool isPlain = false;    ///< its tiles need no more of their warp than most do (findReach in draw_list.cpp)
};

/// Whether draws of both can be put together.
inline bool areOfOneRun(const DrawRun& a, const DrawRun& b) {
    return a.page == b.page && a.warp == b.warp && a.batch == b.batch && a.isPlain == b.isPlain;
}

struct DrawList {
    std::vector<DrawRun> runs;
    std::uint32_t tiles = 0;
    std::uint64_t items = 0; ///< samples (points), mesh squares or facets
    /// Scratch, kept from frame to frame: the tiles to draw, by piece; how many of each; and in which order.
    struct Chosen {
        std::uint32_t tile = 0, orderLevel = 0;
        bool isStandIn = false;
        Warp warp = Warp::points;
        bool isPlain = false;
        std::uint32_t reach = 0; ///< of a sample in the eye: points' footprint, or the bits of splats' radius
        vec4 detail{0};
        float orderDisparity = 0; ///< of the tile's middle; infinite if that is not before the eye
        float area = 0;           ///< square pixels that its samples cover, about
        std::uint32_t bucket = 0; ///< of draws that are put together
        std::uint32_t batch = 0;
        std::uint32_t run = 0; ///< of its batch
    };
    std::vector<Chosen> chosen;
    std::vector<std::uint32_t> counts, order, firsts;
};

/// Stand-ins are drawn as surfaces, which stay whole however near one comes, and as points, which close what is left
/// between surfaces: at coarse silhouettes that is wide.
inline constexpr std::size_t kDrawsPerTile = 2;

/// Coarse samples that stand in for finer ones are drawn as squares of so many pixels at most.
inline constexpr int kWidestStandIn = 64;

/// What the warp of this tile needs, at an order level (scene/preference.h), as if its chunk stood at the start of its
/// page. C is multiplied out in double precision and only then rounded.
TileDraw tileDrawOf(const glm::dmat4& eyeImageFromSource, const ResidentTile& tile, int orderLevel = 0);

/// Chooses all tiles that have items for this warp and are there, and puts them in order. Coarser tiles stand in for
/// finer ones that are not there. sources: one for each of the scene's images. picturePixels: of the eye's image, to
/// divide the list into batches of which each is likely to hide much of the next; 0: one batch.
void chooseDraws(const SceneIndex& scene, std::span<const ChunkPlace> places, std::span<const SourceView> sources,
                 const VisibleTiles& visible, const Quality& quality, DrawList& list, double picturePixels = 0);

/// Writes the draws of what was chosen, list.tiles in all. The same bytes on any number of threads.
void writeDraws(const SceneIndex& scene, std::span<const ChunkPlace> places, std::span<const SourceView> sources,
                const DrawList& list, std::span<TileDraw> draws);

} // namespace render
