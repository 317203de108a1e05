#pragma once
// The visible tiles of one eye, each with its own warp.

#include "render/quality.h"
#include "render/scene_index.h"
#include "render/shaders/shared/tile_draw.h"
#include "render/source_views.h"

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace render {

/// How much of their warp tiles need (findReach in draw_list.cpp): no more than most do, little more (points and meshes
/// alone), anything, or so many pixels that a processor must deal them out (shaders/shared/large_part.h).
enum class Reach : std::uint8_t { plain, small, any, wide };

/// Consecutive draws from one page by one shader.
struct DrawRun {
    std::uint32_t page = 0, first = 0, count = 0; ///< count: kMaxWorkgroups at most
    Warp warp = Warp::points;
    std::uint32_t batch = 0;  ///< ascending: nearer ones come before
    std::uint32_t number = 0; ///< of its batch
    Reach reach = Reach::any;
};

/// Whether draws of both can be put together.
inline bool areOfOneRun(const DrawRun& a, const DrawRun& b) {
    return a.page == b.page && a.warp == b.warp && a.batch == b.batch && a.reach == b.reach;
}

struct DrawList {
    std::vector<DrawRun> runs;
    std::uint32_t tiles = 0;
    std::uint64_t items = 0; ///< samples (points), mesh squares or facets
    /// Scratch, kept from frame to frame: the tiles to draw, by piece; how many of each piece that may be seen, and
    /// where those of each begin; and in which order all are drawn (render/draw_order.h). Of what is visible alone: a
    /// large site has a hundred times the tiles.
    struct Chosen {
        std::uint32_t tile = 0, page = 0, items = 0, orderLevel = 0;
        bool isStandIn = false;
        bool isOfLone = false; ///< only samples that are in no square are drawn
        Warp warp = Warp::points;
        Reach reach = Reach::any;
        std::uint32_t width = 0; ///< of a sample in the eye: points' footprint, or the bits of splats' radius
        vec4 detail{0};
        float orderDisparity = 0; ///< of the tile's middle; infinite if that is not before the eye
        float area = 0;           ///< square pixels that its samples cover, about
        std::uint32_t band = 0;   ///< of rows of the picture (render/draw_order.h), where the tile's middle is seen
        std::uint32_t kind = 0;   ///< of draws that are put together: batch, shader and so on (render/draw_order.h)
        std::uint32_t batch = 0;
    };
    std::vector<Chosen> chosen;
    std::vector<std::uint32_t> counts, firstOfPiece, order, firsts;
    /// All by its place in chosen, before kinds are told apart; byBand: where those are sorted.
    std::vector<std::uint32_t> inTurn, byBand;
};

/// Stand-ins are drawn as surfaces, which stay whole however near one comes, and as points, which close what is left
/// between surfaces: at coarse silhouettes that is wide. Other tiles with surfaces are drawn so and as those of their
/// samples that are in none (Quality::drawsSquaresNear, drawsLone).
inline constexpr std::uint32_t kDrawsPerTile = 2;

/// Fewer items of one eye are drawn sooner than looked at for what is hidden (docs/performance.md).
inline constexpr std::uint64_t kLeastItemsToLook = 800'000, kNeverLook = std::numeric_limits<std::uint64_t>::max();

/// Coarse samples that stand in for finer ones are drawn as squares of so many pixels at most.
inline constexpr int kWidestStandIn = 64;

/// What the warp of this tile needs, at an order level (scene/preference.h), as if its chunk stood at the start of its
/// page. C is multiplied out in double precision and only then rounded.
TileDraw tileDrawOf(const glm::dmat4& eyeImageFromSource, const ResidentTile& tile, int orderLevel = 0);

/// Whether any tile of a piece may be chosen. mayStandIn: some chunk of the scene is not there.
bool mayBeChosen(const TilePiece& piece, const SourceView& source, const Quality& quality, bool mayStandIn);

/// Whether some chunk is not there.
bool hasGaps(std::span<const ChunkPlace> places);

/// Chooses all tiles that have items for this warp and are there, and puts them in order. Coarser tiles stand in for
/// finer ones that are not there. sources: by image, of those whose tiles are visible. picturePixels: of the eye's
/// image, to draw tiles by where they are seen, and to divide the list into batches of which each is likely to hide
/// much of the next; 0: neither. Fewer than leastItems to draw are one batch.
void chooseDraws(const SceneIndex& scene, std::span<const ChunkPlace> places, std::span<const SourceView> sources,
                 const VisibleTiles& visible, const Quality& quality, DrawList& list, double picturePixels = 0,
                 std::uint64_t leastItems = kLeastItemsToLook);

/// Writes the draws of what was chosen, list.tiles in all. The same bytes on any number of threads.
void writeDraws(const SceneIndex& scene, std::span<const ChunkPlace> places, std::span<const SourceView> sources,
                const DrawList& list, std::span<TileDraw> draws);

} // namespace render
