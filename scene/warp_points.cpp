// The warp of a tile's samples as points; its pixels in scene/warp_points_simd.cpp.
#include "scene/warp_points.h"

#include "scene/footprint.h"

namespace scene {

void warpPoints(std::span<const TileBlock> blocks, const View& eye, const WarpOptions& options, ZBuffer& zBuffer) {
    drawTiles(
        blocks, eye, options.preference, &Tile::pointCount,
        [&](const TileBlock& block, const Tile& tile, const glm::dmat4& c, const TileWarp& warp,
            ImageView<std::uint64_t> into) {
            return drawPoints(warp, block.vertices.subspan(tile.firstVertex, tile.pointCount),
                              footprintOf(typicalInEye(c, boxOf(tile, block.camera), tile.placeBits).sampleWidth,
                                          static_cast<double>(options.footprintScale), options.maxFootprint),
                              into);
        },
        zBuffer);
}

} // namespace scene
