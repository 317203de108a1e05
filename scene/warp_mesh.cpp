// The warp of a tile's mesh: two triangles a square, each over the pixels whose centres it holds.
#include "scene/warp_target.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scene {

namespace {

/// How far outside of a triangle a pixel's centre may lie, in pixels. Edges that two triangles share differ by
/// rounding, and those of two tiles by quantisation: far less than this. What is drawn twice costs nothing, the
/// greatest key wins.
constexpr float kFatEdge = 1.0f / 64.0f;

/// Rasterises one triangle: pixel centres inside or at its edges. Disparity is affine over the image, as any plane's;
/// colour is interpolated over the source's image (perspective-correct through perW).
RowRange drawTriangle(const Projected* p, const std::uint32_t* colours, std::uint32_t levelAndClass,
                      const ImageView<std::uint64_t>& zBuffer) {
    const float minU = std::min(std::min(p[0].u, p[1].u), p[2].u), maxU = std::max(std::max(p[0].u, p[1].u), p[2].u);
    const float minV = std::min(std::min(p[0].v, p[1].v), p[2].v), maxV = std::max(std::max(p[0].v, p[1].v), p[2].v);
    const auto width = static_cast<float>(zBuffer.width), height = static_cast<float>(zBuffer.height);
    const int x0 = static_cast<int>(std::ceil(std::clamp(minU - kFatEdge, 0.f, width) - 0.5f));
    const int x1 = static_cast<int>(std::floor(std::clamp(maxU + kFatEdge, -1.f, width) - 0.5f));
    const int y0 = static_cast<int>(std::ceil(std::clamp(minV - kFatEdge, 0.f, height) - 0.5f));
    const int y1 = static_cast<int>(std::floor(std::clamp(maxV + kFatEdge, -1.f, height) - 0.5f));
    if (x0 > x1 || y0 > y1) return {};

    // Relative to the first vertex: small triangles far from the image's corner keep their precision.
    const float ax = p[1].u - p[0].u, ay = p[1].v - p[0].v, bx = p[2].u - p[0].u, by = p[2].v - p[0].v;
    const float area = ax * by - ay * bx;
    if (!(std::abs(area) > 1e-20f)) return {}; // seen edge-on: the neighbours have the pixels
    const float perArea = 1.f / area, fat = kFatEdge * std::abs(perArea);
    const float slackR = (std::abs(ax - bx) + std::abs(ay - by)) * fat;
    const float slackS = (std::abs(bx) + std::abs(by)) * fat, slackT = (std::abs(ax) + std::abs(ay)) * fat;
    const float farthest = std::min(std::min(p[0].disparity, p[1].disparity), p[2].disparity);
    const float nearest = std::max(std::max(p[0].disparity, p[1].disparity), p[2].disparity);
    const auto channel = [](std::uint32_t colour, int shift) { return static_cast<float>(colour >> shift & 255u); };
    for (int y = y0; y <= std::min(y1, zBuffer.height - 1); ++y) {
        for (int x = x0; x <= std::min(x1, zBuffer.width - 1); ++x) {
            const float dx = static_cast<float>(x) + 0.5f - p[0].u, dy = static_cast<float>(y) + 0.5f - p[0].v;
            const float s = (dx * by - dy * bx) * perArea, t = (ax * dy - ay * dx) * perArea;
            const float r = 1.f - s - t;
            if (!(s >= -slackS && t >= -slackT && r >= -slackR)) continue;
            // A fat edge must not carry a thin triangle beyond its corners.
            const float disparity =
                std::clamp(r * p[0].disparity + s * p[1].disparity + t * p[2].disparity, farthest, nearest);
            const float r1 = std::max(r, 0.f) * p[0].perW, s1 = std::max(s, 0.f) * p[1].perW,
                        t1 = std::max(t, 0.f) * p[2].perW;
            const float scale = 1.f / (r1 + s1 + t1);
            std::uint32_t colour = 0;
            for (int shift = 0; shift < 24; shift += 8) {
                const float value = (r1 * channel(colours[0], shift) + s1 * channel(colours[1], shift) +
                                     t1 * channel(colours[2], shift)) *
                                    scale;
                colour |= static_cast<std::uint32_t>(value + 0.5f) << shift;
            }
            zBuffer(x, y) = std::max(zBuffer(x, y), keyOf(disparity, colour, levelAndClass));
        }
    }
    return {y0, std::min(y1 + 1, zBuffer.height)};
}

/// How far outside of a triangle that reaches behind the eye a pixel may look, in samples: there are no edges on the
/// screen to measure from.
constexpr double kCutEdge = 1.0 / 16.0;

/// A triangle that reaches from before the eye to behind it. Its corners have no place on the screen, so the warp is
/// turned round: (r, s, t) / w of the corners' shares is affine on the screen, and positive w is before the eye.
RowRange drawCutTriangle(const glm::dvec3* h, const double* disparities, const std::uint32_t* colours,
                         std::uint32_t levelAndClass, const ImageView<std::uint64_t>& zBuffer) {
    const auto isBeyond = [&](const glm::dvec3& edge) {
        return glm::dot(edge, h[0]) < 0 && glm::dot(edge, h[1]) < 0 && glm::dot(edge, h[2]) < 0;
    };
    if (isBeyond({1, 0, 0}) || isBeyond({-1, 0, zBuffer.width}) || isBeyond({0, 1, 0}) ||
        isBeyond({0, -1, zBuffer.height}))
        return {}; // beside the picture
    const glm::dmat3 sharesToScreen(h[0], h[1], h[2]);
    if (!(std::abs(glm::determinant(sharesToScreen)) > 1e-30)) return {}; // seen edge-on
    const glm::dmat3 screenToShares = glm::inverse(sharesToScreen);
    RowRange rows{zBuffer.height, 0};
    for (int y = 0; y < zBuffer.height; ++y)
        for (int x = 0; x < zBuffer.width; ++x) {
            const glm::dvec3 perW = screenToShares * glm::dvec3(x + 0.5, y + 0.5, 1);
            const double sum = perW.x + perW.y + perW.z;
            if (!(sum > 0)) continue;
            const glm::dvec3 share = perW / sum;
            if (!(share.x >= -kCutEdge && share.y >= -kCutEdge && share.z >= -kCutEdge)) continue;
            const auto disparity = static_cast<float>(
                std::max(perW.x * disparities[0] + perW.y * disparities[1] + perW.z * disparities[2], 0.0));
            if (!(disparity <= 1.0f / kNearMetres)) continue;
            const glm::dvec3 weight = glm::max(share, glm::dvec3(0)) /
                                      (std::max(share.x, 0.0) + std::max(share.y, 0.0) + std::max(share.z, 0.0));
            std::uint32_t colour = 0;
            for (int shift = 0; shift < 24; shift += 8) {
                double value = 0.5;
                for (int corner = 0; corner < 3; ++corner)
                    value += weight[corner] * (colours[corner] >> shift & 255u);
                colour |= static_cast<std::uint32_t>(value) << shift;
            }
            zBuffer(x, y) = std::max(zBuffer(x, y), keyOf(disparity, colour, levelAndClass));
            rows = {std::min(rows.first, y), y + 1};
        }
    return rows;
}

RowRange drawTileMesh(const TileBlock& block, const Tile& tile, const TileWarp& warp,
                      const ImageView<std::uint64_t>& zBuffer) {
    const auto vertices = block.vertices.subspan(tile.firstVertex, tile.vertexCount);
    std::vector<Projected> projected(vertices.size());
    for (std::size_t i = 0; i < vertices.size(); ++i)
        projected[i] = projectVertex(warp, vertices[i].place);
    RowRange rows{zBuffer.height, 0};
    const auto draw = [&](std::uint32_t a, std::uint32_t b, std::uint32_t d) {
        const Projected p[3] = {projected[a], projected[b], projected[d]};
        const auto before = std::count_if(p, p + 3, [](const Projected& corner) { return corner.disparity >= 0; });
        if (before == 0) return;
        const std::uint32_t colours[3] = {vertices[a].colour, vertices[b].colour, vertices[d].colour};
        RowRange drawn;
        if (before == 3) {
            drawn = drawTriangle(p, colours, warp.levelAndClass, zBuffer);
        } else {
            glm::dvec3 h[3];
            double disparities[3];
            for (int i = 0; i < 3; ++i) {
                const VertexPlace place = placeOf(tile, vertices[i == 0 ? a : i == 1 ? b : d]);
                h[i] = glm::dvec3(warp.origin) + double(place.x) * glm::dvec3(warp.columnX) +
                       double(place.y) * glm::dvec3(warp.columnY) + double(place.q) * glm::dvec3(warp.columnQ);
                disparities[i] = double(warp.minDisparity) + place.q * double(warp.disparityStep);
            }
            drawn = drawCutTriangle(h, disparities, colours, warp.levelAndClass, zBuffer);
        }
        if (drawn.first < drawn.end) rows = {std::min(rows.first, drawn.first), std::max(rows.end, drawn.end)};
    };
    for (const TileQuad& quad : block.quads.subspan(tile.firstQuad, tile.quadCount)) {
        const std::uint32_t i00 = quad.top & kQuadIndexMask, i10 = quad.top >> 16 & kQuadIndexMask;
        const std::uint32_t i01 = quad.bottom & kQuadIndexMask, i11 = quad.bottom >> 16 & kQuadIndexMask;
        if (quad.top & kDrawUpper) draw(i00, i10, i01);
        if (quad.bottom & kDrawLower) draw(i10, i11, i01);
    }
    return rows;
}

} // namespace

void warpMesh(std::span<const TileBlock> blocks, const View& eye, const WarpOptions& options, ZBuffer& zBuffer) {
    drawTiles(
        blocks, eye, options.preference, &Tile::vertexCount,
        [](const TileBlock& block, const Tile& tile, const glm::dmat4&, const TileWarp& warp,
           ImageView<std::uint64_t> into) { return drawTileMesh(block, tile, warp, into); },
        zBuffer);
}

} // namespace scene
