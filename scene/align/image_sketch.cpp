#include "scene/align/image_sketch.h"

#include "scene/srgb.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

namespace scene {

namespace {

constexpr int kLevels = 3;           ///< of greys
constexpr float kOneSurface = 0.04f; ///< relative difference of disparity: more within a square is a silhouette
constexpr int kBroadPixels = 8;      ///< pixels of a level, each way: the mean over so many is what is broad
constexpr int kNoise = 1; ///< the same, twice: what is finer is noise, whose slopes would hold poses where they are
constexpr double kDark = 0.02; ///< of full light: below it differences are noise

/// OpenCV has no pictures that are lent for reading alone; nothing writes to this one.
cv::Mat1f lent(const Image<float>& grey) {
    return {grey.height(), grey.width(), const_cast<float*>(grey.pixels().data())};
}

/// Mean over (2 radius + 1) squared pixels; beyond the rims the rims go on.
Image<float> blurred(const Image<float>& grey, int radius) {
    Image<float> result(grey.width(), grey.height());
    if (!grey.empty()) {
        cv::Mat1f to = lent(result);
        cv::blur(lent(grey), to, {2 * radius + 1, 2 * radius + 1}, {-1, -1}, cv::BORDER_REPLICATE);
    }
    return result;
}

/// Each pixel the mean of four; the last of an odd number is left out.
Image<float> halved(const Image<float>& grey) {
    Image<float> half(grey.width() / 2, grey.height() / 2);
    if (!half.empty()) {
        cv::Mat1f to = lent(half);
        cv::resize(lent(grey)(cv::Rect(0, 0, 2 * half.width(), 2 * half.height())), to, to.size(), 0, 0,
                   cv::INTER_AREA);
    }
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
        const Image<float> broad = blurred(grey, kBroadPixels);
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
