// The warp of a tile's samples as quadratic splats: circles of one colour whose depth falls off from their centres, so
// that of overlapping ones each pixel shows the nearest. Nyland et al. 1999, section 5.4.
#include "scene/footprint.h"
#include "scene/warp_target.h"

#include <algorithm>
#include <cmath>

namespace scene {

namespace {

/// Share of its disparity that a splat loses from centre to rim: more than neighbouring samples of a slanted surface
/// differ by, and less than surfaces that are to be told apart.
constexpr float kFalloff = 0.01f;

RowRange drawTileSplats(const TileBlock& block, const Tile& tile, const TileWarp& warp, float radius,
                        const ImageView<std::uint64_t>& zBuffer) {
    const auto width = static_cast<float>(zBuffer.width), height = static_cast<float>(zBuffer.height);
    const auto firstOf = [](float position, float reach, float most) {
        return static_cast<int>(std::clamp(std::ceil(position - reach - 0.5f), 0.f, most));
    };
    const auto endOf = [](float position, float reach, float most) {
        return static_cast<int>(std::clamp(std::floor(position + reach + 0.5f), 0.f, most));
    };
    const float perRadius2 = 1.f / (radius * radius);
    RowRange rows{zBuffer.height, 0};
    for (const TileVertex& vertex : block.vertices.subspan(tile.firstVertex, tile.pointCount)) {
        const Projected p = projectVertex(warp, vertex.place);
        if (p.disparity < 0) continue;
        const int y0 = firstOf(p.v, radius, height), y1 = endOf(p.v, radius, height);
        const int x0 = firstOf(p.u, radius, width), x1 = endOf(p.u, radius, width);
        for (int y = y0; y < y1; ++y)
            for (int x = x0; x < x1; ++x) {
                const float dx = static_cast<float>(x) + 0.5f - p.u, dy = static_cast<float>(y) + 0.5f - p.v;
                const float share = (dx * dx + dy * dy) * perRadius2;
                if (share > 1.f) continue;
                const float disparity = p.disparity * (1.f - kFalloff * share);
                zBuffer(x, y) = std::max(zBuffer(x, y), keyOf(disparity, vertex.colour, warp.levelAndClass));
            }
        if (x0 < x1 && y0 < y1) rows = {std::min(rows.first, y0), std::max(rows.end, y1)};
    }
    return rows;
}

} // namespace

void warpSplats(std::span<const TileBlock> blocks, const View& eye, const WarpOptions& options, ZBuffer& zBuffer) {
    drawTiles(
        blocks, eye, options.preference, &Tile::pointCount,
        [&](const TileBlock& block, const Tile& tile, const glm::dmat4& c, const TileWarp& warp,
            ImageView<std::uint64_t> into) {
            const float radius =
                splatRadiusOf(c, boxOf(tile, block.camera), static_cast<double>(options.splatScale), options.maxSplat);
            return drawTileSplats(block, tile, warp, radius, into);
        },
        zBuffer);
}

} // namespace scene
