#include "render/draw_list.h"

#include "render/shaders/shared/detail.h"
#include "render/shaders/shared/z_key.h"
#include "scene/footprint.h"

#include <glm/geometric.hpp>
#include <tbb/blocked_range.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace render {

namespace {

constexpr std::size_t kDrawsPerTask = 512;

constexpr double kRounding = 1 + 1e-4; ///< what single precision may make of a measure

constexpr double kAnywhere = std::numeric_limits<double>::infinity();

/// What draws a tile: for the adaptive mesh its squares where it has no facets; scraps are points, since hardly any of
/// their squares has a neighbour.
Warp warpOf(const ResidentTile& tile, Warp wanted) {
    if (wanted != Warp::adaptive || tile.facetCount > 0) return wanted;
    return tile.placeBits == scene::kScrapPlaceBits ? Warp::points : Warp::mesh;
}

bool hasGaps(std::span<const ChunkPlace> places) {
    return std::any_of(places.begin(), places.end(), [](const ChunkPlace& place) { return !place.isThere(); });
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
    return tile.middle.tier == scene::Tier::guess ? kClassFilled : kClassSeen;
}

scene::SampleBox boxOf(const TileBounds& bounds, std::uint32_t i) {
    return {{bounds.xMin[i], bounds.yMin[i], bounds.dMin[i]}, {bounds.xMax[i], bounds.yMax[i], bounds.dMax[i]}};
}

/// Stand-ins are drawn as wide as it takes: what is coarse must not open holes.
std::uint32_t footprintOf(const glm::dmat4& c, const scene::SampleBox& box, const Quality& quality, bool isStandIn) {
    constexpr double kStandInScale = 1.5; // closes what slopes open
    const double scale = isStandIn ? std::max(quality.footprintScale, kStandInScale) : quality.footprintScale;
    const int most = isStandIn ? std::max(quality.maxFootprint, kWidestStandIn) : quality.maxFootprint;
    return static_cast<std::uint32_t>(scene::footprintOf(c, box, scale, most));
}

/// Order levels that stand-ins are pushed back by: where some of the finer samples are there, those are seen.
constexpr int kStandInLevels = 2;

/// Whether coarser levels are asked for. The mesh is all of what was sampled.
bool hasDetail(const Quality& quality) {
    return quality.samplePixels > 0 && quality.warp != Warp::mesh;
}

/// detail of a TileDraw (shared/detail.h); nothing if no sample of the tile can be drawn. isFinest: of all that are
/// there.
std::optional<vec4> detailOf(const glm::dmat4& c, const SourceView& source, const TileBounds& bounds, std::uint32_t i,
                             double samplePixels, bool isFinest) {
    // w is affine in (x, y, d): its extremes stand in corners of the box.
    const auto along = [](double slope, float low, float high) -> std::pair<double, double> {
        const double a = slope * static_cast<double>(low), b = slope * static_cast<double>(high);
        return {std::min(a, b), std::max(a, b)};
    };
    const auto x = along(c[0].z, bounds.xMin[i], bounds.xMax[i]), y = along(c[1].z, bounds.yMin[i], bounds.yMax[i]),
               d = along(c[3].z, bounds.dMin[i], bounds.dMax[i]);
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

} // namespace

TileDraw tileDrawOf(const glm::dmat4& c, const ResidentTile& tile, int orderLevel) {
    const double perScale = 1.0 / static_cast<double>(scene::orderScale(orderLevel));
    const auto hOf = [&](const glm::dvec4& sample) {
        const glm::dvec4 h = c * sample;
        return glm::dvec4(h.x, h.y, h.z, h.w * perScale);
    };
    const double step =
        (static_cast<double>(tile.maxDisparity) - tile.minDisparity) / scene::maxQuantisedOf(tile.placeBits);
    TileDraw draw;
    draw.base = glm::vec4(hOf({tile.x0 + 0.5, tile.y0 + 0.5, 1.0, tile.minDisparity}));
    draw.perX = glm::vec4(hOf({1, 0, 0, 0}));
    draw.perY = glm::vec4(hOf({0, 1, 0, 0}));
    draw.perQ = glm::vec4(hOf({0, 0, 0, step}));
    draw.span = {tile.firstVertex, 0, 0, packMark(static_cast<uint>(orderLevel), classOf(tile, {}), tile.placeBits, 1)};
    draw.source = {static_cast<uint>(tile.x0), static_cast<uint>(tile.y0), tile.texelsInRow << 8, 0};
    draw.detail = vec4(0);
    return draw;
}

std::vector<SourceView> sourceViewsOf(std::span<const ResidentImage> images, const scene::View& eye,
                                      const Quality& quality) {
    std::vector<SourceView> views;
    for (const ResidentImage& image : images) {
        SourceView view;
        view.eyeImageFromSource = scene::eyeImageFromSourceImage(eye, image.camera, image.worldFromCamera);
        view.eyeFromCamera = eye.worldFromEye.translation - image.worldFromCamera.translation;
        view.pixelsPerSample = std::sqrt(eye.camera.fx * eye.camera.fy / (image.camera.fx * image.camera.fy));
        view.captured = image.captured, view.level = image.level, view.hasCoarser = image.hasCoarser;
        view.isNear = glm::length(view.eyeFromCamera) <=
                      2 * static_cast<double>(quality.preference.nearBaseline) * image.middleReach;
        views.push_back(view);
    }
    return views;
}

void buildDrawList(const SceneIndex& scene, std::span<const ChunkPlace> places, std::span<const SourceView> sources,
                   const VisibleTiles& visible, const Quality& quality, std::span<TileDraw> draws, DrawList& list) {
    const bool isDetailed = hasDetail(quality);
    const bool mayStandIn = hasGaps(places);
    const auto standsIn = [&](std::uint32_t number) {
        const auto finer = scene.finerThan(number);
        return std::any_of(finer.begin(), finer.end(), [&](std::uint32_t chunk) { return !places[chunk].isThere(); });
    };
    const auto samplePixelsOf = [&](const SourceView& source, const ResidentTile& tile) {
        const bool isFar = tile.middle.tier == scene::Tier::base && !source.isNear;
        return isFar ? std::max(quality.samplePixels, quality.farSamplePixels) : quality.samplePixels;
    };
    /// How a visible tile is drawn, if it is.
    const auto choose = [&](std::uint32_t number) -> std::optional<DrawList::Chosen> {
        const ResidentTile& tile = scene.tiles[number];
        const SourceView& source = sources[tile.image];
        if (!places[tile.chunk].isThere()) return std::nullopt;
        const bool isStandIn = mayStandIn && source.level > 0 && standsIn(number);
        if (source.level > 0 && !isDetailed && !isStandIn) return std::nullopt;
        const Warp warp = warpOf(tile, isStandIn ? Warp::adaptive : quality.warp);
        if (itemsOf(tile, warp) == 0) return std::nullopt;
        const auto level = scene::orderLevelOf(tile.middle, source.eyeFromCamera, quality.preference);
        if (!level) return std::nullopt;
        std::optional<vec4> detail = vec4(0);
        if (isDetailed)
            detail = detailOf(source.eyeImageFromSource, source, scene.bounds, number, samplePixelsOf(source, tile),
                              source.level == 0 || isStandIn);
        if (!detail) return std::nullopt;
        const bool isByArea = quality.preference.areaLevels > 0;
        const double area =
            isByArea ? scene::sampleAreaInEye(source.eyeImageFromSource, boxOf(scene.bounds, number)) : 0;
        const int behind = isStandIn ? kStandInLevels : 0;
        const int orderLevel =
            std::min(scene::withArea(*level, area, quality.preference) + behind, scene::kMaxOrderLevel);
        return DrawList::Chosen{number, static_cast<std::uint32_t>(orderLevel), isStandIn, warp, *detail};
    };

    // Every piece chooses in its own part of the scratch arrays; then the parts are put together in order.
    const std::vector<TilePiece>& pieces = scene.pieces;
    list.chosen.resize(kDrawsPerTile * scene.tiles.size());
    list.counts.assign(pieces.size(), 0);
    tbb::parallel_for(std::size_t{0}, pieces.size(), [&](std::size_t p) {
        const TilePiece& piece = pieces[p];
        const SourceView& source = sources[piece.image];
        if (!isDetailed && !mayStandIn && source.level > 0) return;
        if (piece.reachMetres < kAnywhere &&
            !scene::mayBeNear(glm::length(source.eyeFromCamera), piece.reachMetres, quality.preference))
            return;
        const auto add = [&](const DrawList::Chosen& chosen) {
            list.chosen[kDrawsPerTile * piece.first + list.counts[p]++] = chosen;
        };
        for (std::uint32_t i = 0; i < visible.counts[p]; ++i) {
            std::optional<DrawList::Chosen> chosen = choose(visible.slots[piece.first + i]);
            if (!chosen) continue;
            add(*chosen);
            if (!chosen->isStandIn || chosen->warp == Warp::points) continue;
            chosen->warp = Warp::points;
            add(*chosen);
        }
    });

    // What is likely seen comes first, so that the rest finds itself hidden early.
    list.runs.clear();
    list.order.clear();
    list.items = 0;
    for (const bool isFar : {false, true})
        for (const Warp warp : {Warp::adaptive, Warp::mesh, Warp::points, Warp::splats})
            for (std::size_t p = 0; p < pieces.size(); ++p)
                for (std::uint32_t i = 0; i < list.counts[p]; ++i) {
                    const std::size_t place = kDrawsPerTile * std::size_t{pieces[p].first} + i;
                    const DrawList::Chosen& chosen = list.chosen[place];
                    if (chosen.warp != warp || (chosen.orderLevel == scene::kMaxOrderLevel) != isFar) continue;
                    const ResidentTile& tile = scene.tiles[chosen.tile];
                    const std::uint32_t page = places[tile.chunk].page;
                    if (list.runs.empty() || list.runs.back().page != page || list.runs.back().warp != warp)
                        list.runs.push_back({page, static_cast<std::uint32_t>(list.order.size()), 0, warp});
                    ++list.runs.back().count;
                    list.items += itemsOf(tile, chosen.warp);
                    list.order.push_back(static_cast<std::uint32_t>(place));
                }
    list.tiles = static_cast<std::uint32_t>(list.order.size());

    const tbb::blocked_range<std::size_t> all(0, list.tiles, kDrawsPerTask);
    tbb::parallel_for(all, [&](const tbb::blocked_range<std::size_t>& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            const DrawList::Chosen& chosen = list.chosen[list.order[i]];
            const ResidentTile& tile = scene.tiles[chosen.tile];
            const ChunkPlace& place = places[tile.chunk];
            const SourceView& source = sources[tile.image];
            const scene::SampleBox box = boxOf(scene.bounds, chosen.tile);
            TileDraw draw = tileDrawOf(source.eyeImageFromSource, tile, static_cast<int>(chosen.orderLevel));
            draw.span.x += place.firstTexel;
            draw.span.z = itemsOf(tile, chosen.warp);
            std::uint32_t footprint = 1;
            if (chosen.warp == Warp::points) {
                draw.span.y = place.firstTexel + tile.firstVertex;
                footprint = footprintOf(source.eyeImageFromSource, box, quality, chosen.isStandIn);
            } else if (chosen.warp == Warp::splats) {
                draw.span.y = place.firstTexel + tile.firstVertex;
                draw.span.x = glm::floatBitsToUint(
                    scene::splatRadiusOf(source.eyeImageFromSource, box, quality.splatScale, quality.maxSplat));
            } else if (chosen.warp == Warp::mesh) {
                draw.span.y = place.firstTexel + tile.firstQuad;
            } else {
                draw.span.x = place.firstTexel + tile.firstTexel, draw.span.y = place.firstTexel / 2 + tile.firstFacet;
            }
            draw.span.w = packMark(chosen.orderLevel, classOf(tile, place), tile.placeBits, footprint);
            draw.source.z |= source.level;
            draw.source.w = source.captured;
            draw.detail = chosen.detail;
            draws[i] = draw;
        }
    });
}

} // namespace render
