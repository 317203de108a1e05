#include "scene/capture/simulated_camera.h"

#include "scene/srgb.h"
#include "scene/synthetic_random.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdlib>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <tbb/parallel_for.h>

namespace scene {

namespace {

constexpr int kSameColour = 6; ///< of 255: neighbours that differ by no more are looked at once

int differenceOf(const Rgb8& a, const Rgb8& b) {
    return std::max({std::abs(a.r - b.r), std::abs(a.g - b.g), std::abs(a.b - b.b)});
}

glm::dvec3 linearOf(const Rgb8& c) {
    return {linearFromSrgb(c.r), linearFromSrgb(c.g), linearFromSrgb(c.b)};
}

std::uint8_t noisy(std::uint8_t value, double noise) {
    return static_cast<std::uint8_t>(std::clamp(std::lround(value + noise), 0L, 255L));
}

} // namespace

Image<Rgb8> takePhotograph(const ScannedWorld& world, const Pose& worldFromCamera,
                           const SimulatedCameraOptions& options) {
    assert(world.colour && isUsable(options.lens.camera) && options.raysPerPixel >= 1);
    const Camera& camera = options.lens.camera;
    const auto seenAt = [&](double x, double y) {
        const glm::dvec2 ideal = undistorted(options.lens.distortion, glm::dvec2(rayThrough(camera, x, y)));
        return world.colour(worldFromCamera.translation, worldFromCamera.rotation * glm::dvec3(ideal, 1.0));
    };
    Image<Rgb8> middles(camera.width, camera.height);
    tbb::parallel_for(0, camera.height, [&](int y) {
        for (int x = 0; x < camera.width; ++x)
            middles(x, y) = seenAt(x + 0.5, y + 0.5);
    });

    const double gain = std::exp2(options.exposureStops);
    Image<Rgb8> picture(camera.width, camera.height);
    tbb::parallel_for(0, camera.height, [&](int y) {
        for (int x = 0; x < camera.width; ++x) {
            const Rgb8& middle = middles(x, y);
            int most = 0;
            for (int j = std::max(y - 1, 0); j <= std::min(y + 1, camera.height - 1); ++j)
                for (int i = std::max(x - 1, 0); i <= std::min(x + 1, camera.width - 1); ++i)
                    most = std::max(most, differenceOf(middle, middles(i, j)));
            glm::dvec3 light = linearOf(middle);
            if (most > kSameColour && options.raysPerPixel > 1) {
                light = glm::dvec3(0);
                for (int ray = 0; ray < options.raysPerPixel; ++ray) {
                    const double down = 0.5 + (ray + 0.25) * 0.6180339887498949;
                    light += linearOf(seenAt(x + (ray + 0.5) / options.raysPerPixel, y + down - std::floor(down)));
                }
                light /= static_cast<double>(options.raysPerPixel);
            }
            Rgb8 pixel = encoded(gain * options.whiteBalance * light);
            SeededSequence chance(
                mixBits(mixBits(options.seed, static_cast<std::uint64_t>(y)), static_cast<std::uint64_t>(x)));
            pixel.r = noisy(pixel.r, options.noise * chance.normal());
            pixel.g = noisy(pixel.g, options.noise * chance.normal());
            pixel.b = noisy(pixel.b, options.noise * chance.normal());
            picture(x, y) = pixel;
        }
    });
    return picture;
}

CameraFile usualCamera(int width, int height, double degreesAcross) {
    CameraFile file;
    const double focal = 0.5 * width / std::tan(glm::radians(degreesAcross) / 2);
    file.camera = {width, height, focal, 1.0005 * focal, 0.503 * width, 0.496 * height};
    file.distortion.k1 = -0.12;
    file.distortion.k2 = 0.03;
    return file;
}

} // namespace scene
