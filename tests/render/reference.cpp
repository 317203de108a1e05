#include "tests/render/reference.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace render {

namespace {

struct Seen {
    double u = 0, v = 0, disparity = 0;
    bool isBefore = false;
    scene::Rgb8 colour;
};

/// Through the world, point by point: nothing of equation 2 is used.
Seen see(const scene::TileBlock& block, const scene::View& view, double x, double y, double d) {
    const glm::dvec3 ray = scene::rayThrough(block.camera, x, y);
    const scene::Pose eyeFromSource = scene::inverse(view.worldFromEye) * block.worldFromCamera;
    // d times the point, so that infinitely far ones have a direction.
    const glm::dvec3 scaled = eyeFromSource.rotation * ray + d * eyeFromSource.translation;
    Seen seen;
    if (scaled.z <= 0) return seen;
    const glm::dvec2 at = scene::project(view.camera, scaled);
    return {at.x, at.y, d / scaled.z, true, {}};
}

Seen seeVertex(const scene::TileBlock& block, const scene::View& view, const scene::Tile& tile, std::uint32_t index) {
    const scene::TileVertex& vertex = block.vertices[tile.firstVertex + index];
    const double x = tile.x0 + static_cast<int>(scene::placeOf(tile, vertex).x) + 0.5;
    const double y = tile.y0 + static_cast<int>(scene::placeOf(tile, vertex).y) + 0.5;
    const double step = (double(tile.maxDisparity) - tile.minDisparity) / scene::maxQuantisedOf(tile);
    Seen seen = see(block, view, x, y, tile.minDisparity + scene::placeOf(tile, vertex).q * step);
    seen.colour = {static_cast<std::uint8_t>(vertex.colour), static_cast<std::uint8_t>(vertex.colour >> 8),
                   static_cast<std::uint8_t>(vertex.colour >> 16)};
    return seen;
}

/// Of one disparity, by moving a sample a little to both sides.
double widthAt(const scene::TileBlock& block, const scene::View& view, double x, double y, double d) {
    const double h = 1e-3;
    const Seen left = see(block, view, x - h, y, d), right = see(block, view, x + h, y, d);
    const Seen up = see(block, view, x, y - h, d), down = see(block, view, x, y + h, d);
    if (!left.isBefore || !right.isBefore || !up.isBefore || !down.isBefore) return 1e9;
    return std::max(std::abs(right.u - left.u) + std::abs(down.u - up.u),
                    std::abs(right.v - left.v) + std::abs(down.v - up.v)) /
           (2 * h);
}

int footprintOf(const scene::TileBlock& block, const scene::View& view, const scene::Tile& tile, int maxFootprint) {
    const double right = std::min(tile.x0 + tile.width, block.camera.width - 1) + 0.5;
    const double bottom = std::min(tile.y0 + tile.height, block.camera.height - 1) + 0.5;
    double width = 0;
    if (tile.placeBits == scene::kScrapPlaceBits)
        width = widthAt(block, view, (tile.x0 + 0.5 + right) / 2, (tile.y0 + 0.5 + bottom) / 2,
                        (double{tile.minDisparity} + double{tile.maxDisparity}) / 2);
    else
        for (const double x : {tile.x0 + 0.5, right})
            for (const double y : {tile.y0 + 0.5, bottom})
                for (const float d : {tile.minDisparity, tile.maxDisparity})
                    width = std::max(width, widthAt(block, view, x, y, d));
    return static_cast<int>(std::clamp(std::ceil(width - 0.01), 1.0, static_cast<double>(maxFootprint)));
}

ReferenceImage emptyImage(const scene::Camera& camera) {
    return {{camera.width, camera.height, -1.0}, {camera.width, camera.height}, {camera.width, camera.height}};
}

void put(ReferenceImage& image, int x, int y, double disparity, scene::Rgb8 colour) {
    if (x < 0 || y < 0 || x >= image.colour.width() || y >= image.colour.height()) return;
    if (disparity <= image.disparity(x, y)) return;
    image.disparity(x, y) = disparity;
    image.colour(x, y) = colour;
}

/// What is drawn in an order of its own: depth by which pixels are taken, beside the one that they show.
struct Ordered {
    ReferenceImage shown;
    scene::Image<double> order; ///< as a disparity

    void put(int x, int y, double orderDisparity, const Seen& seen) {
        if (x < 0 || y < 0 || x >= order.width() || y >= order.height() || orderDisparity <= order(x, y)) return;
        order(x, y) = orderDisparity;
        shown.disparity(x, y) = seen.disparity;
        shown.colour(x, y) = seen.colour;
    }
};

double cross(const Seen& a, const Seen& b, double x, double y) {
    return (b.u - a.u) * (y - a.v) - (b.v - a.v) * (x - a.u);
}

void drawTriangle(ReferenceImage& image, const std::array<Seen, 3>& corner) {
    if (!corner[0].isBefore || !corner[1].isBefore || !corner[2].isBefore) return;
    const double area = cross(corner[0], corner[1], corner[2].u, corner[2].v);
    if (area == 0) return;
    const auto [left, right] = std::minmax({corner[0].u, corner[1].u, corner[2].u});
    const auto [top, bottom] = std::minmax({corner[0].v, corner[1].v, corner[2].v});
    const int x0 = static_cast<int>(std::clamp(left - 2, 0.0, 1e5)),
              x1 = static_cast<int>(std::min<double>(right + 2, image.colour.width() - 1));
    const int y0 = static_cast<int>(std::clamp(top - 2, 0.0, 1e5)),
              y1 = static_cast<int>(std::min<double>(bottom + 2, image.colour.height() - 1));
    for (int y = y0; y <= y1; ++y)
        for (int x = x0; x <= x1; ++x) {
            double share[3], outside = -1e9, disparity = 0;
            for (int i = 0; i < 3; ++i) {
                const Seen &a = corner[static_cast<std::size_t>((i + 1) % 3)],
                           &b = corner[static_cast<std::size_t>((i + 2) % 3)];
                const double c = cross(a, b, x + 0.5, y + 0.5);
                share[i] = c / area;
                outside = std::max(outside, -c * (area > 0 ? 1 : -1) / std::hypot(b.u - a.u, b.v - a.v));
                disparity += share[i] * corner[static_cast<std::size_t>(i)].disparity;
            }
            if (std::abs(outside) < 1.0 / 32) image.isUncertain(x, y) = 1;
            if (outside > 0) continue;
            const auto mix = [&](auto channel) {
                double sum = 0.5;
                for (std::size_t i = 0; i < 3; ++i)
                    sum += share[i] * channel(corner[i].colour);
                return static_cast<std::uint8_t>(std::clamp(sum, 0.0, 255.0));
            };
            put(image, x, y, disparity,
                {mix([](scene::Rgb8 c) { return c.r; }), mix([](scene::Rgb8 c) { return c.g; }),
                 mix([](scene::Rgb8 c) { return c.b; })});
        }
}

} // namespace

ReferenceImage referencePoints(std::span<const scene::TileBlock> blocks, const scene::View& view, int maxFootprint) {
    constexpr double kNearnessOfRim = 0.99;
    Ordered image{emptyImage(view.camera), {view.camera.width, view.camera.height, -1.0}};
    for (const scene::TileBlock& block : blocks)
        for (const scene::Tile& tile : block.tiles) {
            const int size = footprintOf(block, view, tile, maxFootprint);
            for (std::uint32_t i = 0; i < tile.pointCount; ++i) {
                const Seen seen = seeVertex(block, view, tile, i);
                if (!seen.isBefore || std::abs(seen.u) > 1e5 || std::abs(seen.v) > 1e5) continue;
                const int left = static_cast<int>(std::floor(seen.u - 0.5 * (size - 1)));
                const int top = static_cast<int>(std::floor(seen.v - 0.5 * (size - 1)));
                for (int y = top; y < top + size; ++y)
                    for (int x = left; x < left + size; ++x) {
                        const bool isMiddle = x == std::floor(seen.u) && y == std::floor(seen.v);
                        image.put(x, y, isMiddle ? seen.disparity : seen.disparity * kNearnessOfRim, seen);
                    }
            }
        }
    return image.shown;
}

ReferenceImage referenceMesh(std::span<const scene::TileBlock> blocks, const scene::View& view) {
    ReferenceImage image = emptyImage(view.camera);
    for (const scene::TileBlock& block : blocks)
        for (const scene::Tile& tile : block.tiles)
            for (const scene::TileQuad& quad : block.quads.subspan(tile.firstQuad, tile.quadCount)) {
                const auto corner = [&](std::uint32_t index) {
                    return seeVertex(block, view, tile, index & scene::kQuadIndexMask);
                };
                const Seen topRight = corner(quad.top >> 16), bottomLeft = corner(quad.bottom);
                if ((quad.top & scene::kDrawUpper) != 0) drawTriangle(image, {corner(quad.top), topRight, bottomLeft});
                if ((quad.bottom & scene::kDrawLower) != 0)
                    drawTriangle(image, {topRight, corner(quad.bottom >> 16), bottomLeft});
            }
    return image;
}

} // namespace render
