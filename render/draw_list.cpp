#include "render/draw_list.h"

#include "render/shaders/shared/z_key.h"
#include "scene/footprint.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>

namespace render {

namespace {

constexpr std::uint64_t kTileBits = 26, kNearnessBits = 24;
constexpr std::size_t kDrawsPerTask = 512;

std::uint32_t itemsOf(const ResidentTile& tile, Warp warp) {
    return warp == Warp::points ? tile.pointCount : tile.quadCount;
}

uint classOf(const ResidentTile& tile) {
    return tile.middle.tier == scene::Tier::guess ? kClassFilled : kClassSeen;
}

/// Sorts by page, then near to far, then by number, so that no two are equal.
std::uint64_t orderOf(const glm::dmat4& c, const ResidentTile& tile, const TileBounds& bounds, std::uint32_t number) {
    const double x = (static_cast<double>(bounds.xMin[number]) + bounds.xMax[number]) / 2;
    const double y = (static_cast<double>(bounds.yMin[number]) + bounds.yMax[number]) / 2;
    const double d = (static_cast<double>(tile.minDisparity) + tile.maxDisparity) / 2;
    const double w = c[0][2] * x + c[1][2] * y + c[2][2] + c[3][2] * d;
    const float nearness = w > 0 ? static_cast<float>(std::min(d / w, 1e30)) : 1e30f;
    const std::uint64_t farFirst = std::bit_cast<std::uint32_t>(std::max(nearness, 0.0f)) >> (32 - kNearnessBits);
    const std::uint64_t nearFirst = ((std::uint64_t{1} << kNearnessBits) - 1) - farFirst;
    return ((std::uint64_t{tile.page} << kNearnessBits | nearFirst) << kTileBits) | number;
}

std::uint32_t tileIn(std::uint64_t order) {
    return static_cast<std::uint32_t>(order & ((std::uint64_t{1} << kTileBits) - 1));
}

std::uint32_t footprintOf(const glm::dmat4& c, const TileBounds& bounds, std::uint32_t i, const Quality& quality) {
    const scene::SampleBox box{{bounds.xMin[i], bounds.yMin[i], bounds.dMin[i]},
                               {bounds.xMax[i], bounds.yMax[i], bounds.dMax[i]}};
    return static_cast<std::uint32_t>(scene::footprintOf(c, box, quality.footprintScale, quality.maxFootprint));
}

} // namespace

TileDraw tileDrawOf(const glm::dmat4& c, const ResidentTile& tile, int orderLevel) {
    const double perScale = 1.0 / static_cast<double>(scene::orderScale(orderLevel));
    const auto hOf = [&](const glm::dvec4& sample) {
        const glm::dvec4 h = c * sample;
        return glm::dvec4(h.x, h.y, h.z, h.w * perScale);
    };
    const double step = (static_cast<double>(tile.maxDisparity) - tile.minDisparity) / scene::kMaxQuantisedDisparity;
    TileDraw draw;
    draw.base = glm::vec4(hOf({tile.x0 + 0.5, tile.y0 + 0.5, 1.0, tile.minDisparity}));
    draw.perX = glm::vec4(hOf({1, 0, 0, 0}));
    draw.perY = glm::vec4(hOf({0, 1, 0, 0}));
    draw.perQ = glm::vec4(hOf({0, 0, 0, step}));
    draw.span = {tile.firstVertex, 0, 0, packMark(static_cast<uint>(orderLevel), classOf(tile), 1)};
    return draw;
}

void buildDrawList(std::span<const ResidentTile> tiles, const TileBounds& bounds, std::span<const TilePiece> pieces,
                   std::span<const glm::dmat4> eyeImagesFromSources, std::span<const glm::dvec3> eyeFromCameras,
                   const VisibleTiles& visible, const Quality& quality, std::span<TileDraw> draws, DrawList& list) {
    assert(tiles.size() < (std::size_t{1} << kTileBits));
    list.order.clear();
    list.levels.resize(tiles.size());
    for (std::size_t p = 0; p < pieces.size(); ++p)
        for (std::uint32_t i = 0; i < visible.counts[p]; ++i) {
            const std::uint32_t number = visible.slots[pieces[p].first + i];
            const ResidentTile& tile = tiles[number];
            if (itemsOf(tile, quality.warp) == 0) continue;
            const auto level = scene::orderLevelOf(tile.middle, eyeFromCameras[tile.image], quality.preference);
            if (!level) continue;
            list.levels[number] = static_cast<std::uint8_t>(*level);
            list.order.push_back(orderOf(eyeImagesFromSources[tile.image], tile, bounds, number));
        }
    std::sort(list.order.begin(), list.order.end());

    list.runs.clear();
    list.items = 0;
    list.tiles = static_cast<std::uint32_t>(list.order.size());
    for (std::uint32_t i = 0; i < list.tiles; ++i) {
        const ResidentTile& tile = tiles[tileIn(list.order[i])];
        if (list.runs.empty() || list.runs.back().page != tile.page) list.runs.push_back({tile.page, i, 0});
        ++list.runs.back().count;
        list.items += itemsOf(tile, quality.warp);
    }

    const tbb::blocked_range<std::size_t> all(0, list.order.size(), kDrawsPerTask);
    tbb::parallel_for(all, [&](const tbb::blocked_range<std::size_t>& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            const std::uint32_t number = tileIn(list.order[i]);
            const ResidentTile& tile = tiles[number];
            const glm::dmat4& c = eyeImagesFromSources[tile.image];
            const int level = list.levels[number];
            TileDraw draw = tileDrawOf(c, tile, level);
            draw.span.z = itemsOf(tile, quality.warp);
            draw.span.y = quality.warp == Warp::points ? tile.firstVertex : tile.firstQuad;
            const std::uint32_t footprint = quality.warp == Warp::points ? footprintOf(c, bounds, number, quality) : 1;
            draw.span.w = packMark(static_cast<uint>(level), classOf(tile), footprint);
            draws[i] = draw;
        }
    });
}

} // namespace render
