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
constexpr float kTwoPixels = 0.5000002f; ///< square of the least radius (scene/footprint.h), rounded up

bool isWithin(const ImageView<std::uint64_t>& zBuffer, int x, int y) {
    return x >= 0 && y >= 0 && x < zBuffer.width && y < zBuffer.height;
}

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
    // With a centre a and b off its pixel's, the squares of the distances to the next one across and to the next one
    // along add up to 1 at least: so small a circle covers one of them at most. Within a thousandth of a pixel of where
    // four meet, one is left out.
    const bool coversTwoAtMost = radius * radius <= kTwoPixels;
    RowRange rows{zBuffer.height, 0};
    for (const TileVertex& vertex : block.vertices.subspan(tile.firstVertex, tile.pointCount)) {
        const Projected p = projectVertex(warp, vertex.place);
        if (p.disparity < 0) continue;
        const int y0 = firstOf(p.v, radius, height), y1 = endOf(p.v, radius, height);
        const int x0 = firstOf(p.u, radius, width), x1 = endOf(p.u, radius, width);
        if (x0 >= x1 || y0 >= y1) continue;
        const auto draw = [&](int x, int y) {
            const float dx = static_cast<float>(x) + 0.5f - p.u, dy = static_cast<float>(y) + 0.5f - p.v;
            const float share = (dx * dx + dy * dy) * perRadius2;
            if (share > 1.f) return;
            const float disparity = p.disparity * (1.f - kFalloff * share);
            zBuffer(x, y) = std::max(zBuffer(x, y), withPlace(keyOf(disparity, vertex.colour, warp.levelAndClass), dx,
                                                              dy, kPlaceStepsOfSplat));
        };
        if (coversTwoAtMost) {
            const int x = static_cast<int>(std::floor(p.u)), y = static_cast<int>(std::floor(p.v));
            const float dx = static_cast<float>(x) + 0.5f - p.u, dy = static_cast<float>(y) + 0.5f - p.v;
            const bool isAcross = std::abs(dx) >= std::abs(dy);
            const int nextX = x + (isAcross ? dx < 0 ? 1 : -1 : 0), nextY = y + (isAcross ? 0 : dy < 0 ? 1 : -1);
            if (isWithin(zBuffer, x, y)) draw(x, y);
            if (isWithin(zBuffer, nextX, nextY)) draw(nextX, nextY);
        } else {
            for (int y = y0; y < y1; ++y)
                for (int x = x0; x < x1; ++x)
                    draw(x, y);
        }
        rows = {std::min(rows.first, y0), std::max(rows.end, y1)};
    }
    return rows;
}

} // namespace

void warpSplats(std::span<const TileBlock> blocks, const View& eye, const WarpOptions& options, ZBuffer& zBuffer) {
    drawTiles(
        blocks, eye, options.preference, &Tile::pointCount,
        [&](const TileBlock& block, const Tile& tile, const glm::dmat4& c, const TileWarp& warp,
            ImageView<std::uint64_t> into) {
            const float radius = splatRadiusOf(c, typicalOf(boxOf(tile, block.camera), tile.placeBits),
                                               static_cast<double>(options.splatScale), options.maxSplat);
            return drawTileSplats(block, tile, warp, radius, into);
        },
        zBuffer);
}

} // namespace scene
