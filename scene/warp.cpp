#include "scene/warp.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

namespace scene {

namespace {

/// A tile ready to be stepped through: h = origin + x columnX + y columnY + q columnQ = (u w, v w, w), all rounded from
/// double. Disparity is the order's: over orderScale(level).
struct TileWarp {
    glm::vec3 origin, columnX, columnY, columnQ;
    float minDisparity, disparityStep;
    std::uint32_t levelAndClass;
};

TileWarp tileWarpOf(const Tile& tile, const glm::dmat4& c, int level) {
    const double perScale = 1.0 / static_cast<double>(orderScale(level));
    const double step = (static_cast<double>(tile.maxDisparity) - tile.minDisparity) / kMaxQuantisedDisparity;
    const glm::dvec4 origin = c * glm::dvec4(tile.x0 + 0.5, tile.y0 + 0.5, 1.0, static_cast<double>(tile.minDisparity));
    return {glm::vec3(glm::dvec3(origin)),
            glm::vec3(glm::dvec3(c[0])),
            glm::vec3(glm::dvec3(c[1])),
            glm::vec3(glm::dvec3(c[3]) * step),
            static_cast<float>(tile.minDisparity * perScale),
            static_cast<float>(step * perScale),
            static_cast<std::uint32_t>(level) << 2 | static_cast<std::uint32_t>(PixelClass::seen)};
}

/// A vertex in the eye's image.
struct Projected {
    float u = 0, v = 0, perW = 0, disparity = -1; ///< disparity < 0: behind the eye or too near
};

inline Projected projectVertex(const TileWarp& warp, std::uint32_t place) {
    const auto x = static_cast<float>(place & 63u), y = static_cast<float>(place >> 6 & 63u);
    const auto q = static_cast<float>(place >> 12);
    const glm::vec3 h = warp.origin + x * warp.columnX + y * warp.columnY + q * warp.columnQ;
    if (!(h.z > 0)) return {};
    const float perW = 1.0f / h.z;
    const float disparity = (warp.minDisparity + q * warp.disparityStep) * perW;
    if (!(disparity <= 1.0f / kNearMetres)) return {};
    return {h.x * perW, h.y * perW, perW, disparity};
}

inline std::uint64_t keyOf(float disparity, std::uint32_t colour, std::uint32_t levelAndClass) {
    return static_cast<std::uint64_t>(std::bit_cast<std::uint32_t>(disparity)) << 32 | (colour & 0xffffffu) << 8 |
           levelAndClass;
}

void drawTilePoints(const TileBlock& block, const Tile& tile, const glm::dmat4& c, int level,
                    const WarpOptions& options, ZBuffer& zBuffer) {
    const TileWarp warp = tileWarpOf(tile, c, level);
    const int footprint = footprintOf(tile, c, options);
    const float half = 0.5f * static_cast<float>(footprint - 1);
    for (const TileVertex& vertex : block.vertices.subspan(tile.firstVertex, tile.pointCount)) {
        const Projected p = projectVertex(warp, vertex.place);
        if (p.disparity < 0) continue;
        const float left = std::floor(p.u - half), top = std::floor(p.v - half);
        if (!(left > -64.f && top > -64.f && left < static_cast<float>(zBuffer.width()) &&
              top < static_cast<float>(zBuffer.height())))
            continue;
        const std::uint64_t key = keyOf(p.disparity, vertex.colour, warp.levelAndClass);
        const int x0 = static_cast<int>(left), y0 = static_cast<int>(top);
        for (int y = std::max(y0, 0); y < std::min(y0 + footprint, zBuffer.height()); ++y)
            for (int x = std::max(x0, 0); x < std::min(x0 + footprint, zBuffer.width()); ++x)
                zBuffer(x, y) = std::max(zBuffer(x, y), key);
    }
}

/// How far outside of a triangle a pixel's centre may lie, in pixels. Edges that two triangles share differ by
/// rounding, and those of two tiles by quantisation: far less than this. What is drawn twice costs nothing, the
/// greatest key wins.
constexpr float kFatEdge = 1.0f / 64.0f;

/// Rasterises one triangle: pixel centres inside or at its edges. Disparity is affine over the image, as any plane's;
/// colour is interpolated over the source's image (perspective-correct through perW).
void drawTriangle(const Projected* p, const std::uint32_t* colours, std::uint32_t levelAndClass, ZBuffer& zBuffer) {
    const float minU = std::min(std::min(p[0].u, p[1].u), p[2].u), maxU = std::max(std::max(p[0].u, p[1].u), p[2].u);
    const float minV = std::min(std::min(p[0].v, p[1].v), p[2].v), maxV = std::max(std::max(p[0].v, p[1].v), p[2].v);
    const auto width = static_cast<float>(zBuffer.width()), height = static_cast<float>(zBuffer.height());
    const int x0 = static_cast<int>(std::ceil(std::clamp(minU - kFatEdge, 0.f, width) - 0.5f));
    const int x1 = static_cast<int>(std::floor(std::clamp(maxU + kFatEdge, -1.f, width) - 0.5f));
    const int y0 = static_cast<int>(std::ceil(std::clamp(minV - kFatEdge, 0.f, height) - 0.5f));
    const int y1 = static_cast<int>(std::floor(std::clamp(maxV + kFatEdge, -1.f, height) - 0.5f));
    if (x0 > x1 || y0 > y1) return;

    // Relative to the first vertex: small triangles far from the image's corner keep their precision.
    const float ax = p[1].u - p[0].u, ay = p[1].v - p[0].v, bx = p[2].u - p[0].u, by = p[2].v - p[0].v;
    const float area = ax * by - ay * bx;
    if (!(std::abs(area) > 1e-20f)) return; // seen edge-on: the neighbours have the pixels
    const float perArea = 1.f / area, fat = kFatEdge * std::abs(perArea);
    const float slackR = (std::abs(ax - bx) + std::abs(ay - by)) * fat;
    const float slackS = (std::abs(bx) + std::abs(by)) * fat, slackT = (std::abs(ax) + std::abs(ay)) * fat;
    const float farthest = std::min(std::min(p[0].disparity, p[1].disparity), p[2].disparity);
    const float nearest = std::max(std::max(p[0].disparity, p[1].disparity), p[2].disparity);
    const auto channel = [](std::uint32_t colour, int shift) { return static_cast<float>(colour >> shift & 255u); };
    for (int y = y0; y <= std::min(y1, zBuffer.height() - 1); ++y) {
        for (int x = x0; x <= std::min(x1, zBuffer.width() - 1); ++x) {
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
}

void drawTileMesh(const TileBlock& block, const Tile& tile, const glm::dmat4& c, int level, ZBuffer& zBuffer) {
    const TileWarp warp = tileWarpOf(tile, c, level);
    const auto vertices = block.vertices.subspan(tile.firstVertex, tile.vertexCount);
    std::vector<Projected> projected(vertices.size());
    for (std::size_t i = 0; i < vertices.size(); ++i)
        projected[i] = projectVertex(warp, vertices[i].place);
    const auto draw = [&](std::uint32_t a, std::uint32_t b, std::uint32_t d) {
        const Projected p[3] = {projected[a], projected[b], projected[d]};
        if (p[0].disparity < 0 || p[1].disparity < 0 || p[2].disparity < 0) return;
        const std::uint32_t colours[3] = {vertices[a].colour, vertices[b].colour, vertices[d].colour};
        drawTriangle(p, colours, warp.levelAndClass, zBuffer);
    };
    for (const TileQuad& quad : block.quads.subspan(tile.firstQuad, tile.quadCount)) {
        const std::uint32_t i00 = quad.top & kQuadIndexMask, i10 = quad.top >> 16 & kQuadIndexMask;
        const std::uint32_t i01 = quad.bottom & kQuadIndexMask, i11 = quad.bottom >> 16 & kQuadIndexMask;
        if (quad.top & kDrawUpper) draw(i00, i10, i01);
        if (quad.bottom & kDrawLower) draw(i10, i11, i01);
    }
}

/// Draws every tile of every block into a z-buffer of each thread's own; the greatest key of all wins.
template <class DrawTile>
void warpBlocks(std::span<const TileBlock> blocks, const View& eye, const WarpOptions& options, ZBuffer& zBuffer,
                const DrawTile& drawTile) {
    struct Work {
        std::size_t block, tile;
    };
    std::vector<Work> work;
    std::vector<glm::dmat4> matrices;
    for (std::size_t b = 0; b < blocks.size(); ++b) {
        matrices.push_back(eyeImageFromSourceImage(eye, blocks[b].camera, blocks[b].worldFromCamera));
        for (std::size_t t = 0; t < blocks[b].tiles.size(); ++t)
            work.push_back({b, t});
    }
    tbb::enumerable_thread_specific<ZBuffer> buffers([&] { return ZBuffer(zBuffer.width(), zBuffer.height(), 0); });
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, work.size(), 16), [&](const auto& range) {
        ZBuffer& mine = buffers.local();
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            const TileBlock& block = blocks[work[i].block];
            const Tile& tile = block.tiles[work[i].tile];
            const auto level = orderLevelOf(tile, block.camera, block.worldFromCamera, eye, options.preference);
            if (level) drawTile(block, tile, matrices[work[i].block], *level, mine);
        }
    });
    tbb::parallel_for(0, zBuffer.height(), [&](int y) {
        for (const ZBuffer& buffer : buffers)
            std::transform(buffer.row(y).begin(), buffer.row(y).end(), zBuffer.row(y).begin(), zBuffer.row(y).begin(),
                           [](std::uint64_t a, std::uint64_t b) { return std::max(a, b); });
    });
}

} // namespace

int footprintOf(const Tile& tile, const glm::dmat4& c, const WarpOptions& options) {
    if (options.maxFootprint <= 1) return 1;
    double largestArea = 0;
    for (const double d : {static_cast<double>(tile.minDisparity), static_cast<double>(tile.maxDisparity)}) {
        const glm::dvec3 atDisparity = glm::dvec3(c[2]) + d * glm::dvec3(c[3]);
        const double jacobian = std::abs(glm::determinant(glm::dmat3(glm::dvec3(c[0]), glm::dvec3(c[1]), atDisparity)));
        for (const int x : {tile.x0, tile.x0 + tile.width})
            for (const int y : {tile.y0, tile.y0 + tile.height}) {
                const double w = c[0].z * x + c[1].z * y + atDisparity.z;
                if (!(w > 0)) return options.maxFootprint;
                largestArea = std::max(largestArea, jacobian / (w * w * w));
            }
    }
    const double side = std::ceil(std::sqrt(largestArea) * static_cast<double>(options.footprintScale) - 1e-3);
    return static_cast<int>(std::clamp(side, 1.0, static_cast<double>(options.maxFootprint)));
}

void warpPoints(std::span<const TileBlock> blocks, const View& eye, const WarpOptions& options, ZBuffer& zBuffer) {
    warpBlocks(blocks, eye, options, zBuffer,
               [&](const TileBlock& block, const Tile& tile, const glm::dmat4& c, int level, ZBuffer& mine) {
                   drawTilePoints(block, tile, c, level, options, mine);
               });
}

void warpMesh(std::span<const TileBlock> blocks, const View& eye, const WarpOptions& options, ZBuffer& zBuffer) {
    warpBlocks(blocks, eye, options, zBuffer, drawTileMesh);
}

EyeImage resolve(const ZBuffer& zBuffer) {
    EyeImage eye{Image<Rgb8>(zBuffer.width(), zBuffer.height()), Image<float>(zBuffer.width(), zBuffer.height(), 0.f),
                 Image<std::uint8_t>(zBuffer.width(), zBuffer.height(), 0)};
    for (int y = 0; y < zBuffer.height(); ++y)
        for (int x = 0; x < zBuffer.width(); ++x) {
            const std::uint64_t key = zBuffer(x, y);
            if (key == 0) continue;
            const auto byte = [&](int shift) { return static_cast<std::uint8_t>(key >> shift & 255u); };
            eye.colour(x, y) = {byte(8), byte(16), byte(24)};
            eye.depthMetres(x, y) =
                1.f / (std::bit_cast<float>(static_cast<std::uint32_t>(key >> 32)) * orderScale(byte(0) >> 2));
            eye.pixelClass(x, y) = byte(0) & 3;
        }
    return eye;
}

} // namespace scene
