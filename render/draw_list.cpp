#include "render/draw_list.h"

#include "render/draw_order.h"
#include "render/shaders/shared/detail.h"
#include "render/shaders/shared/splat.h"
#include "render/shaders/shared/z_key.h"
#include "scene/footprint.h"

#include <glm/geometric.hpp>
#include <tbb/blocked_range.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace render {

namespace {

constexpr std::size_t kDrawsPerTask = 512;

static_assert(kRowPlaceBits == scene::kPlaceBits);

constexpr double kRounding = 1 + 1e-4; ///< what single precision may make of a measure

/// What draws a tile: for the adaptive mesh its squares where it has no facets; scraps are points while those are
/// small.
Warp warpOf(const ResidentTile& tile, Warp wanted) {
    if (wanted != Warp::adaptive || tile.facetCount > 0) return wanted;
    return tile.placeBits == scene::kScrapPlaceBits ? Warp::points : Warp::mesh;
}

std::uint32_t itemsOf(const ResidentTile& tile, Warp warp) {
    switch (warp) {
    case Warp::mesh:
        return tile.quadCount;
    case Warp::adaptive:
        return tile.facetCount;
    default:
        return tile.pointCount;
    }
}

uint classOf(const ResidentTile& tile, const ChunkPlace& place) {
    if (place.isDamaged) return kClassUnseen;
    return scene::isMeasured(tile.middle.tier) ? kClassSeen : kClassFilled;
}

scene::SampleBox boxOf(const TileBounds& bounds, std::uint32_t i) {
    return {{bounds.xMin[i], bounds.yMin[i], bounds.dMin[i]}, {bounds.xMax[i], bounds.yMax[i], bounds.dMax[i]}};
}

/// Stand-ins are drawn as wide as it takes: what is coarse must not open holes.
std::uint32_t footprintOf(const scene::BoxInEye& seen, const Quality& quality, bool isStandIn) {
    constexpr double kStandInScale = 1.5; // closes what slopes open
    const double scale = isStandIn ? std::max(quality.footprintScale, kStandInScale) : quality.footprintScale;
    const int most = isStandIn ? std::max(quality.maxFootprint, kWidestStandIn) : quality.maxFootprint;
    return static_cast<std::uint32_t>(scene::footprintOf(seen.sampleWidth, scale, most));
}

/// Pixels that neighbouring samples stand farther apart than they are wide, by a tile's steepness. What does not slope
/// has none, be it behind the eye.
double stepOf(const scene::BoxInEye& seen, double steepness) {
    return steepness > 0 ? steepness * seen.slopeStep : 0;
}

/// Pixels. Points that are one pixel wide though samples are farther apart than kLatticeWidth (one, and what rounding
/// may make of it), on a surface that slopes by more than kLeastLatticeStep, leave a lattice of cracks, which the hole
/// filler cannot tell from a fence. Two pixels wide they leave none.
constexpr double kLeastLatticeStep = 1, kLatticeWidth = 1.02;

std::uint32_t widthOfPoints(const scene::BoxInEye& seen, double steepness, const Quality& quality, bool isStandIn) {
    const std::uint32_t width = footprintOf(seen, quality, isStandIn);
    const bool leavesLattice = width == 1 && quality.drawsSquaresNear && quality.maxFootprint > 1 &&
                               stepOf(seen, steepness) > kLeastLatticeStep && seen.sampleWidth > kLatticeWidth;
    return leavesLattice ? 2 : width;
}

/// Pixels. Where a surface slopes, points stand farther apart than they are wide; wider gaps than so leave cracks that
/// are not closed afterwards.
constexpr int kWidestSlopeStep = 3;

/// Whether points or splats as wide as they may be leave gaps between samples that squares would close.
bool isTooWideFor(Warp warp, const glm::dmat4& c, const scene::SampleBox& box, const scene::BoxInEye& seen,
                  double steepness, const Quality& quality) {
    const double step = stepOf(seen, steepness);
    if (warp == Warp::points)
        return step > std::min(quality.maxFootprint, kWidestSlopeStep) ||
               scene::footprintOf(seen.sampleWidth, quality.footprintScale, quality.maxFootprint + 1) >
                   quality.maxFootprint;
    return warp == Warp::splats &&
           (step > 2 * quality.maxSplat || scene::splatRadiusOf(c, box, quality.splatScale, quality.maxSplat + 1) >
                                               static_cast<float>(quality.maxSplat));
}

/// What draws samples of a tile besides its surfaces: all of a stand-in's, else those that no surface reaches.
std::optional<Warp> warpBesides(const DrawList::Chosen& chosen, const ResidentTile& tile, const Quality& quality) {
    if (chosen.warp == Warp::points || chosen.warp == Warp::splats) return std::nullopt;
    if (chosen.isStandIn) return Warp::points;
    if (tile.loneCount == 0) return std::nullopt;
    if (quality.warp == Warp::points || quality.warp == Warp::splats) return quality.warp;
    return quality.drawsLone ? std::optional(Warp::points) : std::nullopt;
}

/// Pixels.
constexpr std::uint32_t kSmallStandIn = 4;

/// Pixels. As squares of up to so many, scraps and lone samples look much as their mesh would, and are drawn in less
/// time; wider squares stand out of their surface's rim, and show one colour where the mesh has a transition.
constexpr std::uint32_t kWidestScrapPoint = 2;

/// Order levels that stand-ins are pushed back by: where some of the finer samples are there, those are seen.
constexpr int kStandInLevels = 2;

/// The same for lone samples, which may be wider than what they are of: where a surface is, that is seen.
constexpr int kLoneLevels = 2;

/// detail of a TileDraw (shared/detail.h); nothing if no sample of the tile can be drawn. isFinest: of all that are
/// there.
std::optional<vec4> detailOf(const SourceView& source, const scene::SampleBox& box, double samplePixels,
                             bool isFinest) {
    const glm::dmat4& c = source.eyeImageFromSource;
    // w is affine in (x, y, d): its extremes stand in corners of the box.
    const auto along = [](double slope, double low, double high) -> std::pair<double, double> {
        const double a = slope * low, b = slope * high;
        return {std::min(a, b), std::max(a, b)};
    };
    const auto x = along(c[0].z, box.least.x, box.most.x), y = along(c[1].z, box.least.y, box.most.y),
               d = along(c[3].z, box.least.z, box.most.z);
    const double perW = samplePixels / source.pixelsPerSample;
    const double least = perW * (x.first + y.first + c[2].z + d.first),
                 most = perW * (x.second + y.second + c[2].z + d.second);
    const double overlap = static_cast<double>(kDetailOverlap), whole = 1 + static_cast<double>(kDetailBand);
    if (!isFinest && most * (1 + overlap) * kRounding <= 1) return std::nullopt;
    if (source.hasCoarser && least * (0.5 - 0.5 * overlap) >= whole * kRounding) return std::nullopt;
    const bool isWanted = isFinest || least * (1 + overlap) >= whole * kRounding;
    const bool isReplaced = source.hasCoarser && most * (0.5 - 0.5 * overlap) * kRounding > 1;
    if (isWanted && !isReplaced) return vec4(0);
    return vec4(static_cast<float>(perW), isFinest ? 0.0f : 1.0f, source.hasCoarser ? 1.0f : 0.0f, 0.0f);
}

void placeInView(const SourceView& source, const ResidentTile& tile, const scene::SampleBox& box,
                 DrawList::Chosen& chosen) {
    const glm::dmat4& c = source.eyeImageFromSource;
    const glm::dvec3 middle = 0.5 * (box.least + box.most);
    const glm::dvec4 seen = c * glm::dvec4(middle.x, middle.y, 1, middle.z);
    const double w = seen.z;
    if (w > 0) chosen.band = bandOf(seen.y / w);
    constexpr double kWidest = 4; // pixels: a sample nearby covers many, but not as many as one would think
    const double width = w > 0 ? std::min(source.pixelsPerSample / w, kWidest) : kWidest;
    chosen.area = static_cast<float>(tile.pointCount * width * width);
    const double scale = static_cast<double>(scene::orderScale(static_cast<int>(chosen.orderLevel)));
    chosen.orderDisparity = w > 0 ? static_cast<float>(middle.z / (w * scale)) : std::numeric_limits<float>::infinity();
}

/// Whether no sample of a box can be anywhere but before the eye (isBeforeEye in shared/tile_draw.h), whatever single
/// precision makes of it.
bool isAllBefore(const glm::dmat4& c, const scene::SampleBox& box) {
    constexpr double kMost = static_cast<double>(kMaxEyeDisparity), kMargin = 1e-4;
    double least = 0, magnitude = 0; // of kMost * w - d: affine, so that it is least in a corner
    const auto add = [&](int column, double low, double high) {
        const double slope = kMost * c[column].z - c[column].w;
        least += std::min(slope * low, slope * high);
        magnitude += std::max(std::abs(slope * low), std::abs(slope * high));
    };
    add(0, box.least.x, box.most.x), add(1, box.least.y, box.most.y), add(2, 1, 1), add(3, box.least.z, box.most.z);
    return least > kMargin * magnitude;
}

/// Pixels. Squares of tiles whose samples are wider may be shared among a subgroup's lanes (warp_mesh.comp).
constexpr int kWidestPlainSquare = 8;

/// Pixels. An invocation on a processor draws a quarter or an eighth of a tile's samples: of wider ones that is more
/// than lavapipe lets it (shaders/shared/large_part.h).
constexpr std::uint32_t kWidestShared = 6;

/// Square pixels. The pieces of a tile may lie over one another a few times, and their boxes twice as often.
constexpr double kLargestShared = 32768;

Reach plainIf(bool isPlain) {
    return isPlain ? Reach::plain : Reach::any;
}

/// How far a sample reaches in the eye, and what the tile needs. Plain: points of one pixel; splats of two at most; a
/// mesh before the eye, of small squares; and of meshes and facets, which ask it square by square or pixel by pixel,
/// all is of this level. Small: points of two pixels, and such a mesh where some is of another level.
void findReach(const SourceView& source, const scene::SampleBox& box, const scene::BoxInEye& seen,
               std::uint32_t placeBits, double steepness, const Quality& quality, DrawList::Chosen& chosen) {
    const glm::dmat4& c = source.eyeImageFromSource;
    const bool isWhole = chosen.detail.x == 0.0f && source.share == 1;
    // Of scraps, too, what none of them may pass.
    const auto whole = [&] { return placeBits == scene::kScrapPlaceBits ? scene::boxInEye(c, box) : seen; };
    switch (chosen.warp) {
    case Warp::points:
        chosen.width = widthOfPoints(seen, steepness, quality, chosen.isStandIn);
        if (chosen.isOfLone && quality.warp != Warp::points) chosen.width = std::min(chosen.width, kWidestScrapPoint);
        chosen.reach = chosen.width == 1               ? Reach::plain
                       : chosen.width == 2             ? Reach::small
                       : chosen.width <= kWidestShared ? Reach::any
                                                       : Reach::wide;
        break;
    case Warp::splats: {
        const float radius =
            scene::splatRadiusOf(c, scene::typicalOf(box, placeBits), quality.splatScale, quality.maxSplat);
        chosen.width = glm::floatBitsToUint(radius);
        chosen.reach = plainIf(coversTwoAtMost(radius));
        break;
    }
    case Warp::mesh: {
        const scene::BoxInEye most = whole();
        const bool isSmall = isAllBefore(c, box) &&
                             scene::footprintOf(most.sampleWidth, 1, kWidestPlainSquare + 1) <= kWidestPlainSquare;
        chosen.reach = most.area > kLargestShared ? Reach::wide
                       : !isSmall                 ? Reach::any
                       : isWhole                  ? Reach::plain
                                                  : Reach::small;
        break;
    }
    case Warp::adaptive:
        chosen.reach = whole().area > kLargestShared ? Reach::wide : plainIf(isWhole);
        break;
    }
}

double samplePixelsOf(const SourceView& source, bool isBase, const Quality& quality) {
    const bool isFar = isBase && !source.isNear;
    return isFar ? std::max(quality.samplePixels, quality.farSamplePixels) : quality.samplePixels;
}

/// Whether all of a coarse tile is of the level that is asked for, or of a coarser one: then it stands for nothing.
bool isWhollyWanted(const SourceView& source, const scene::SampleBox& box, double samplePixels) {
    const std::optional<vec4> detail = detailOf(source, box, samplePixels, false);
    return detail && detail->x == 0.0f;
}

} // namespace

TileDraw tileDrawOf(const glm::dmat4& c, const ResidentTile& tile, int orderLevel) {
    const double perScale = 1.0 / static_cast<double>(scene::orderScale(orderLevel));
    const auto pushedBack = [&](const glm::dvec4& h) { return vec4(glm::dvec4(h.x, h.y, h.z, h.w * perScale)); };
    const double step =
        (static_cast<double>(tile.maxDisparity) - tile.minDisparity) / scene::maxQuantisedOf(tile.placeBits);
    TileDraw draw;
    draw.base = pushedBack(c * glm::dvec4(tile.x0 + 0.5, tile.y0 + 0.5, 1.0, tile.minDisparity));
    draw.perX = pushedBack(c[0]);
    draw.perY = pushedBack(c[1]);
    draw.perQ = pushedBack(step * c[3]);
    draw.span = {tile.firstVertex, 0, 0, packMark(static_cast<uint>(orderLevel), classOf(tile, {}), tile.placeBits, 1)};
    draw.source = {static_cast<uint>(tile.x0), static_cast<uint>(tile.y0), (tile.width + 1) << 8 | tile.height << 20,
                   0};
    draw.detail = vec4(0);
    return draw;
}

bool hasGaps(std::span<const ChunkPlace> places) {
    return std::any_of(places.begin(), places.end(), [](const ChunkPlace& place) { return !place.isThere(); });
}

bool mayBeChosen(const TilePiece& piece, const SourceView& source, const Quality& quality, bool mayStandIn) {
    const bool isDetailed = detailPixelsOf(quality) > 0;
    if (!isDetailed && !mayStandIn && source.level > 0) return false;
    if (!piece.isBase && !scene::mayBeNear(glm::length(source.eyeFromCamera), piece.reachMetres, quality.preference))
        return false;
    // All of a piece may be too fine, or too coarse. A piece's tiles are alike in what samplePixelsOf asks.
    return !isDetailed ||
           detailOf(source, piece.box, samplePixelsOf(source, piece.isBase, quality), source.level == 0 || mayStandIn);
}

void chooseDraws(const SceneIndex& scene, std::span<const ChunkPlace> places, std::span<const SourceView> sources,
                 const VisibleTiles& visible, const Quality& quality, DrawList& list, double picturePixels,
                 std::uint64_t leastItems) {
    const bool isDetailed = detailPixelsOf(quality) > 0;
    const bool mayStandIn = hasGaps(places);
    const auto standsIn = [&](std::uint32_t number) {
        const auto finer = scene.finerThan(number);
        return std::any_of(finer.begin(), finer.end(), [&](std::uint32_t chunk) { return !places[chunk].isThere(); });
    };
    /// How a visible tile is drawn, if it is, and how it looks from the eye.
    const auto choose = [&](std::uint32_t number, scene::BoxInEye& seen) -> std::optional<DrawList::Chosen> {
        const ResidentTile& tile = scene.tiles[number];
        const SourceView& source = sources[tile.image];
        const bool isBase = scene::isForAllEyes(tile.middle.tier);
        if (!places[tile.chunk].isThere()) return std::nullopt;
        const bool isStandIn = mayStandIn && source.level > 0 && standsIn(number) &&
                               !(isDetailed && isWhollyWanted(source, boxOf(scene.bounds, number),
                                                              samplePixelsOf(source, isBase, quality)));
        if (source.level > 0 && !isDetailed && !isStandIn) return std::nullopt;
        const scene::SampleBox box = boxOf(scene.bounds, number);
        std::optional<vec4> detail = vec4(0);
        if (isDetailed)
            detail = detailOf(source, box, samplePixelsOf(source, isBase, quality), source.level == 0 || isStandIn);
        if (!detail) return std::nullopt;
        const auto level = scene::orderLevelOf(tile.middle, source.eyeFromCamera, quality.preference);
        if (!level) return std::nullopt;
        seen = scene::typicalInEye(source.eyeImageFromSource, box, tile.placeBits);
        // Where its samples are seen small, squares alone leave no gaps that would be seen.
        const bool isSmall = isStandIn && footprintOf(seen, quality, true) <= kSmallStandIn;
        const auto warpOfTile = [&] {
            if (isSmall) return Warp::points;
            if (isStandIn) return warpOf(tile, Warp::adaptive);
            const Warp warp = warpOf(tile, quality.warp);
            if (quality.drawsSquaresNear && tile.quadCount + tile.facetCount > 0 &&
                isTooWideFor(quality.warp, source.eyeImageFromSource, scene::typicalOf(box, tile.placeBits), seen,
                             tile.steepness, quality))
                return tile.quadCount > 0 ? Warp::mesh : Warp::adaptive; // coarse tiles have one of both
            const bool isWideScrap = quality.warp == Warp::adaptive && warp == Warp::points &&
                                     footprintOf(seen, quality, false) > kWidestScrapPoint;
            return isWideScrap ? Warp::mesh : warp;
        };
        Warp warp = warpOfTile();
        std::uint32_t items = itemsOf(tile, warp);
        const bool isAllLone = items == 0 && quality.drawsLone && !isStandIn;
        if (isAllLone) warp = Warp::points, items = tile.loneCount;
        if (items == 0) return std::nullopt;
        const bool isByArea = quality.preference.areaLevels > 0;
        const double area = isByArea ? scene::sampleAreaInEye(source.eyeImageFromSource, box) : 0;
        const int behind = isStandIn ? kStandInLevels : isAllLone ? kLoneLevels : 0;
        const int orderLevel =
            std::min(scene::withArea(*level, area, quality.preference) + behind, scene::kMaxOrderLevel);
        DrawList::Chosen chosen{.tile = number,
                                .page = places[tile.chunk].page,
                                .items = items,
                                .orderLevel = static_cast<std::uint32_t>(orderLevel),
                                .isStandIn = isStandIn,
                                .isOfLone = isAllLone,
                                .warp = warp,
                                .detail = *detail};
        if (picturePixels > 0) placeInView(source, tile, box, chosen);
        findReach(source, box, seen, tile.placeBits, tile.steepness, quality, chosen);
        return chosen;
    };

    // Every piece chooses in its own part of the scratch arrays; then the parts are put together in order.
    list.counts.assign(visible.pieces.size(), 0);
    list.firstOfPiece.resize(visible.pieces.size());
    std::uint32_t room = 0;
    for (std::size_t p = 0; p < visible.pieces.size(); ++p) {
        list.firstOfPiece[p] = room;
        room += kDrawsPerTile * visible.counts[p];
    }
    list.chosen.resize(room);
    tbb::parallel_for(std::size_t{0}, visible.pieces.size(), [&](std::size_t p) {
        if (visible.counts[p] == 0) return;
        const TilePiece& piece = scene.pieces[visible.pieces[p]];
        const auto add = [&](const DrawList::Chosen& chosen) {
            list.chosen[list.firstOfPiece[p] + list.counts[p]++] = chosen;
        };
        for (std::uint32_t i = 0; i < visible.counts[p]; ++i) {
            scene::BoxInEye seen;
            std::optional<DrawList::Chosen> chosen = choose(visible.slots[piece.first + i], seen);
            if (!chosen) continue;
            add(*chosen);
            const std::optional<Warp> ofSamples = warpBesides(*chosen, scene.tiles[chosen->tile], quality);
            if (!ofSamples) continue;
            chosen->isOfLone = !chosen->isStandIn;
            chosen->warp = *ofSamples;
            const ResidentTile& tile = scene.tiles[chosen->tile];
            chosen->items = chosen->isOfLone ? tile.loneCount : tile.pointCount;
            if (chosen->isOfLone) {
                chosen->orderLevel = std::min<std::uint32_t>(chosen->orderLevel + kLoneLevels, scene::kMaxOrderLevel);
                chosen->area *= static_cast<float>(tile.loneCount) / static_cast<float>(tile.pointCount);
            }
            // Of what stands by itself nothing is to be closed, and stand-ins are wide enough.
            findReach(sources[piece.image], boxOf(scene.bounds, chosen->tile), seen, tile.placeBits, 0, quality,
                      *chosen);
            add(*chosen);
        }
    });

    orderDraws(picturePixels, leastItems, list);
}

void writeDraws(const SceneIndex& scene, std::span<const ChunkPlace> places, std::span<const SourceView> sources,
                const DrawList& list, std::span<TileDraw> draws) {
    assert(draws.size() >= list.tiles);
    const tbb::blocked_range<std::size_t> all(0, list.tiles, kDrawsPerTask);
    tbb::parallel_for(all, [&](const tbb::blocked_range<std::size_t>& range) {
        auto run = std::upper_bound(list.runs.begin(), list.runs.end(), range.begin(),
                                    [](std::size_t i, const DrawRun& of) { return i < of.first; }) -
                   1;
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            if (i == run->first + run->count) ++run;
            const DrawList::Chosen& chosen = list.chosen[list.order[i]];
            const ResidentTile& tile = scene.tiles[chosen.tile];
            const ChunkPlace& place = places[tile.chunk];
            const SourceView& source = sources[tile.image];
            TileDraw draw = tileDrawOf(source.eyeImageFromSource, tile, static_cast<int>(chosen.orderLevel));
            draw.span.x += place.firstTexel;
            draw.span.z = chosen.items;
            const std::uint32_t firstSample = place.firstTexel + (chosen.isOfLone ? tile.firstLone : tile.firstVertex);
            std::uint32_t footprint = 1;
            if (chosen.warp == Warp::points) {
                draw.span.y = firstSample;
                footprint = chosen.width;
            } else if (chosen.warp == Warp::splats) {
                draw.span.y = firstSample;
                draw.span.x = chosen.width;
            } else if (chosen.warp == Warp::mesh) {
                draw.span.y = place.firstTexel + tile.firstQuad;
            } else {
                draw.span.x = place.firstTexel + tile.firstTexel, draw.span.y = place.firstTexel / 2 + tile.firstFacet;
            }
            draw.span.w = packMark(chosen.orderLevel, classOf(tile, place), tile.placeBits, footprint);
            draw.source.z |= source.level;
            draw.source.w = packSource(source.captured, source.share);
            draw.detail = vec4(chosen.detail.x, chosen.detail.y, chosen.detail.z, static_cast<float>(run->number));
            draws[i] = draw;
        }
    });
}

} // namespace render
