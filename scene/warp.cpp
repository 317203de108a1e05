#include "scene/warp.h"

#include "scene/tile_warp.h"

namespace scene {

EyeImage resolve(const ZBuffer& zBuffer) {
    EyeImage eye{Image<Rgb8>(zBuffer.width(), zBuffer.height()), Image<float>(zBuffer.width(), zBuffer.height(), 0.f),
                 Image<std::uint8_t>(zBuffer.width(), zBuffer.height(), 0)};
    for (int y = 0; y < zBuffer.height(); ++y)
        for (int x = 0; x < zBuffer.width(); ++x) {
            const std::uint64_t key = zBuffer(x, y);
            if (key == 0) continue;
            const auto byte = [&](int shift) { return static_cast<std::uint8_t>(key >> shift & 255u); };
            eye.colour(x, y) = {byte(8), byte(16), byte(24)};
            eye.depthMetres(x, y) = 1.f / eyeDisparityOf(key);
            eye.pixelClass(x, y) = byte(0) & 3;
        }
    return eye;
}

} // namespace scene
