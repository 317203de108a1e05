// The warp of a tile's samples as points: its footprint here, its pixels in scene/warp_points_simd.cpp.
#include "scene/warp_points.h"

#include <algorithm>
#include <cmath>

#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

namespace scene {

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
    drawTiles(
        blocks, eye, options.preference, &Tile::pointCount,
        [&](const TileBlock& block, const Tile& tile, const glm::dmat4& c, const TileWarp& warp,
            ImageView<std::uint64_t> into) {
            return drawPoints(warp, block.vertices.subspan(tile.firstVertex, tile.pointCount),
                              footprintOf(tile, c, options), into);
        },
        zBuffer);
}

} // namespace scene
