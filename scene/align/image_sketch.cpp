#include "scene/align/image_sketch.h"

#include "scene/srgb.h"

#include <algorithm>
#include <cmath>

namespace scene {

namespace {

constexpr int kLevels = 3;           ///< of greys
constexpr float kOneSurface = 0.04f; ///< relative difference of disparity: more within a square is a silhouette
constexpr int kBroad = 8;            ///< pixels of a level, each way: the mean over so many is what is broad
constexpr int kNoise = 1; ///< the same, twice: what is finer is noise, whose slopes would hold poses where they are
constexpr double kDark = 0.02; ///< of full light: below it differences are noise

/// Mean over (2 radius + 1) squared pixels, fewer at the rims: running sums along rows, then along columns.
Image<float> blurred(const Image<float>& grey, int radius) {
    const int width = grey.width(), height = grey.height();
    Image<float> along(width, height), result(width, height);
    const auto run = [radius](int length, const auto& from, const auto& to) {
        double sum = 0;
        for (int k = 0; k < std::min(radius, length); ++k)
            sum += static_cast<double>(from(k));
        for (int k = 0; k < length; ++k) {
            if (k + radius < length) sum += static_cast<double>(from(k + radius));
            if (k - radius > 0) sum -= static_cast<double>(from(k - radius - 1));
            const int count = std::min(k + radius, length - 1) - std::max(k - radius, 0) + 1;
            to(k) = static_cast<float>(sum / count);
        }
    };
    for (int y = 0; y < height; ++y)
        run(
            width, [&](int x) { return grey(x, y); }, [&](int x) -> float& { return along(x, y); });
    for (int x = 0; x < width; ++x)
        run(
            height, [&](int y) { return along(x, y); }, [&](int y) -> float& { return result(x, y); });
    return result;
}

Image<float> halved(const Image<float>& grey) {
    Image<float> half(grey.width() / 2, grey.height() / 2);
    for (int y = 0; y < half.height(); ++y)
        for (int x = 0; x < half.width(); ++x)
            half(x, y) = 0.25f * (grey(2 * x, 2 * y) + grey(2 * x + 1, 2 * y) + grey(2 * x, 2 * y + 1) +
                                  grey(2 * x + 1, 2 * y + 1));
    return half;
}

Camera shrunk(const Camera& camera, int shrink) {
    const double by = shrink;
    return {camera.width / shrink, camera.height / shrink, camera.fx / by,
            camera.fy / by,        camera.cx / by,         camera.cy / by};
}

/// The disparity of a square's surface; 0 if there is none, or more than one.
float surfaceOf(const DepthImage& image, int left, int top, int shrink) {
    float nearest = 0, farthest = 0, sum = 0;
    int count = 0;
    for (int y = top; y < top + shrink; ++y)
        for (int x = left; x < left + shrink; ++x) {
            const float d = image.disparity(x, y);
            if (!isSurface(image.flags(x, y)) || !(d > 0)) continue;
            nearest = std::max(nearest, d), farthest = count == 0 ? d : std::min(farthest, d);
            sum += d, ++count;
        }
    return count > 0 && nearest - farthest <= kOneSurface * nearest ? sum / static_cast<float>(count) : 0;
}

double lightOf(const DepthImage& image, int left, int top, int shrink) {
    double light = 0;
    for (int y = top; y < top + shrink; ++y)
        for (int x = left; x < left + shrink; ++x) {
            const Rgb8 c = image.colour(x, y);
            light += 0.2126 * static_cast<double>(linearFromSrgb(c.r)) +
                     0.7152 * static_cast<double>(linearFromSrgb(c.g)) +
                     0.0722 * static_cast<double>(linearFromSrgb(c.b));
        }
    return light / (shrink * shrink);
}

} // namespace

ImageSketch sketchOf(const DepthImage& image, int shrink) {
    ImageSketch sketch;
    const Camera camera = shrunk(image.camera, shrink);
    sketch.depth = {image.name, camera, image.worldFromCamera, {}, {camera.width, camera.height}, {}};
    sketch.depth.flags = Image<std::uint8_t>(camera.width, camera.height, kNoSurface);
    Image<float> grey(camera.width, camera.height);
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x) {
            const float d = surfaceOf(image, x * shrink, y * shrink, shrink);
            sketch.depth.disparity(x, y) = d;
            if (d > 0) sketch.depth.flags(x, y) = 0;
            grey(x, y) = static_cast<float>(std::log(kDark + lightOf(image, x * shrink, y * shrink, shrink)));
        }
    for (int level = 0; level < kLevels; ++level) {
        if (level > 0) grey = halved(grey);
        Image<float> fine = blurred(blurred(grey, kNoise), kNoise);
        const Image<float> broad = blurred(grey, kBroad);
        for (std::size_t i = 0; i < fine.size(); ++i)
            fine.pixels()[i] -= broad.pixels()[i];
        sketch.greys.push_back(std::move(fine));
    }
    return sketch;
}

std::size_t bytesOfSketch(const Camera& camera, int shrink) {
    const std::size_t pixels =
        static_cast<std::size_t>(camera.width / shrink) * static_cast<std::size_t>(camera.height / shrink);
    return pixels * (sizeof(float) + sizeof(std::uint8_t)) + pixels * sizeof(float) * 21 / 16;
}

} // namespace scene
