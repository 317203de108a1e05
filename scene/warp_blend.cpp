// The second pass of the blended warp on the processor.
#include "scene/blend.h"
#include "scene/tile_warp.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include <tbb/parallel_for.h>

namespace scene {

namespace {

/// A pixel of the z-buffer: class 0 is nothing.
struct Front {
    float disparity = 0;
    std::uint32_t pixelClass = 0;
};

Image<Front> frontOf(const ZBuffer& zBuffer) {
    Image<Front> front(zBuffer.width(), zBuffer.height());
    for (std::size_t i = 0; i < front.size(); ++i) {
        const std::uint64_t key = zBuffer.pixels()[i];
        const auto low = static_cast<std::uint32_t>(key);
        front.pixels()[i] = {eyeDisparityOf(key), low & 3u};
    }
    return front;
}

void add(std::uint32_t& sum, std::uint32_t value) {
    std::atomic_ref(sum).fetch_add(value, std::memory_order_relaxed);
}

void addSpot(const Projected& p, std::uint32_t colour, const BlendSpot& spot, float weight, std::uint32_t pixelClass,
             const Image<Front>& front, Image<BlendSums>& sums) {
    const auto width = static_cast<float>(sums.width()), height = static_cast<float>(sums.height());
    const auto firstOf = [](float position, float reach, float most) {
        return static_cast<int>(std::clamp(std::ceil(position - reach - 0.5f), 0.f, most));
    };
    const auto endOf = [](float position, float reach, float most) {
        return static_cast<int>(std::clamp(std::floor(position + reach + 0.5f), 0.f, most));
    };
    const int endX = endOf(p.u, spot.reachX, width), endY = endOf(p.v, spot.reachY, height);
    for (int y = firstOf(p.v, spot.reachY, height); y < endY; ++y)
        for (int x = firstOf(p.u, spot.reachX, width); x < endX; ++x) {
            const Front& there = front(x, y);
            if (there.pixelClass != pixelClass) continue;
            if (!(std::abs(p.disparity - there.disparity) <= spot.tolerance * there.disparity)) continue;
            const float dx = static_cast<float>(x) + 0.5f - p.u, dy = static_cast<float>(y) + 0.5f - p.v;
            const float rest = std::max(1.f - (spot.xx * dx * dx + spot.xy * dx * dy + spot.yy * dy * dy), 0.f);
            const auto counts = static_cast<std::uint32_t>(weight * rest * rest + 0.5f);
            if (counts == 0) continue;
            BlendSums& sum = sums(x, y);
            add(sum.red, (colour & 255u) * counts);
            add(sum.green, (colour >> 8 & 255u) * counts);
            add(sum.blue, (colour >> 16 & 255u) * counts);
            add(sum.weight, counts);
        }
}

} // namespace

Image<BlendSums> warpBlend(std::span<const TileBlock> blocks, const View& eye, const BlendOptions& options,
                           const ZBuffer& zBuffer) {
    const Image<Front> front = frontOf(zBuffer);
    Image<BlendSums> sums(zBuffer.width(), zBuffer.height());
    const float unit = blendUnitOf(blocks.size());
    tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t b) {
        const TileBlock& block = blocks[b];
        const glm::dmat4 c = eyeImageFromSourceImage(eye, block.camera, block.worldFromCamera);
        const glm::dvec3 eyeFromCamera = eye.worldFromEye.translation - block.worldFromCamera.translation;
        for (const Tile& tile : block.tiles) {
            const auto spot = blendSpotOf(c, boxOf(tile, block.camera),
                                          middleOf(tile, block.camera, block.worldFromCamera), eyeFromCamera, options);
            if (!spot) continue;
            const TileWarp warp = tileWarpOf(tile, c, 0);
            const auto pixelClass = static_cast<std::uint32_t>(classOf(tile.tier));
            for (const TileVertex& vertex : block.vertices.subspan(tile.firstVertex, tile.pointCount)) {
                const Projected p = projectVertex(warp, vertex.place);
                if (p.disparity >= 0) addSpot(p, vertex.colour, *spot, unit * spot->weight, pixelClass, front, sums);
            }
        }
    });
    return sums;
}

} // namespace scene
