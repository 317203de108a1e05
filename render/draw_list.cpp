#include "render/draw_list.h"

#include "render/shaders/shared/z_key.h"
#include "scene/footprint.h"

#include <glm/geometric.hpp>
#include <tbb/blocked_range.h>

#include <tbb/parallel_for.h>

#include <limits>

namespace render {

namespace {

constexpr std::size_t kDrawsPerTask = 512;

constexpr double kAnywhere = std::numeric_limits<double>::infinity();

std::uint32_t itemsOf(const ResidentTile& tile, Warp warp) {
    return warp == Warp::mesh ? tile.quadCount : tile.pointCount;
}

uint classOf(const ResidentTile& tile) {
    return tile.middle.tier == scene::Tier::guess ? kClassFilled : kClassSeen;
}

scene::SampleBox boxOf(const TileBounds& bounds, std::uint32_t i) {
    return {{bounds.xMin[i], bounds.yMin[i], bounds.dMin[i]}, {bounds.xMax[i], bounds.yMax[i], bounds.dMax[i]}};
}

std::uint32_t footprintOf(const glm::dmat4& c, const TileBounds& bounds, std::uint32_t i, const Quality& quality) {
    return static_cast<std::uint32_t>(
        scene::footprintOf(c, boxOf(bounds, i), quality.footprintScale, quality.maxFootprint));
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
    draw.span = {tile.firstVertex, 0, 0, packMark(static_cast<uint>(orderLevel), classOf(tile), tile.placeBits, 1)};
    return draw;
}

void buildDrawList(std::span<const ResidentTile> tiles, const TileBounds& bounds, std::span<const TilePiece> pieces,
                   std::span<const glm::dmat4> eyeImagesFromSources, std::span<const glm::dvec3> eyeFromCameras,
                   const VisibleTiles& visible, const Quality& quality, std::span<TileDraw> draws, DrawList& list) {
    // Every piece chooses in its own part of the scratch arrays; then the parts are put together in order.
    list.numbers.resize(tiles.size());
    list.levels.resize(tiles.size());
    list.counts.assign(pieces.size(), 0);
    tbb::parallel_for(std::size_t{0}, pieces.size(), [&](std::size_t p) {
        const TilePiece& piece = pieces[p];
        const glm::dvec3& eyeFromCamera = eyeFromCameras[piece.image];
        if (piece.reachMetres < kAnywhere &&
            !scene::mayBeNear(glm::length(eyeFromCamera), piece.reachMetres, quality.preference))
            return;
        for (std::uint32_t i = 0; i < visible.counts[p]; ++i) {
            const std::uint32_t number = visible.slots[piece.first + i];
            const ResidentTile& tile = tiles[number];
            if (itemsOf(tile, quality.warp) == 0) continue;
            const auto level = scene::orderLevelOf(tile.middle, eyeFromCamera, quality.preference);
            if (!level) continue;
            const std::uint32_t place = piece.first + list.counts[p]++;
            list.numbers[place] = number;
            const bool isByArea = quality.preference.areaLevels > 0;
            const double area =
                isByArea ? scene::sampleAreaInEye(eyeImagesFromSources[tile.image], boxOf(bounds, number)) : 0;
            list.levels[place] = static_cast<std::uint8_t>(scene::withArea(*level, area, quality.preference));
        }
    });

    list.runs.clear();
    list.items = 0;
    list.tiles = 0;
    for (std::size_t p = 0; p < pieces.size(); ++p)
        for (std::uint32_t i = 0; i < list.counts[p]; ++i) {
            const std::uint32_t place = pieces[p].first + i, number = list.numbers[place];
            const ResidentTile& tile = tiles[number];
            if (list.runs.empty() || list.runs.back().page != tile.page)
                list.runs.push_back({tile.page, list.tiles, 0});
            ++list.runs.back().count;
            list.items += itemsOf(tile, quality.warp);
            list.numbers[list.tiles] = number;
            list.levels[list.tiles] = list.levels[place];
            ++list.tiles;
        }

    const tbb::blocked_range<std::size_t> all(0, list.tiles, kDrawsPerTask);
    tbb::parallel_for(all, [&](const tbb::blocked_range<std::size_t>& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            const std::uint32_t number = list.numbers[i];
            const ResidentTile& tile = tiles[number];
            const glm::dmat4& c = eyeImagesFromSources[tile.image];
            const int level = list.levels[i];
            TileDraw draw = tileDrawOf(c, tile, level);
            draw.span.z = itemsOf(tile, quality.warp);
            draw.span.y = quality.warp == Warp::mesh ? tile.firstQuad : tile.firstVertex;
            if (quality.warp == Warp::splats)
                draw.span.x = glm::floatBitsToUint(
                    scene::splatRadiusOf(c, boxOf(bounds, number), quality.splatScale, quality.maxSplat));
            const std::uint32_t footprint = quality.warp == Warp::points ? footprintOf(c, bounds, number, quality) : 1;
            draw.span.w = packMark(static_cast<uint>(level), classOf(tile), tile.placeBits, footprint);
            draws[i] = draw;
        }
    });
}

} // namespace render
