#include "scene/import/straighten.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include <tbb/parallel_for.h>

namespace scene {

namespace {

glm::dvec3 bilinearAt(const Image<Rgb8>& picture, double x, double y) {
    const double u = std::clamp(x - 0.5, 0.0, picture.width() - 1.0),
                 v = std::clamp(y - 0.5, 0.0, picture.height() - 1.0);
    const int i = static_cast<int>(u), j = static_cast<int>(v);
    const int right = std::min(i + 1, picture.width() - 1), below = std::min(j + 1, picture.height() - 1);
    const double a = u - i, b = v - j;
    const auto at = [&](int px, int py) {
        const Rgb8& c = picture(px, py);
        return glm::dvec3(c.r, c.g, c.b);
    };
    return (1 - b) * ((1 - a) * at(i, j) + a * at(right, j)) + b * ((1 - a) * at(i, below) + a * at(right, below));
}

} // namespace

StraightPicture straightened(const Image<Rgb8>& picture, const CameraFile& lens, const Camera& pinhole) {
    const Camera& from = lens.camera;
    assert(picture.width() == from.width && picture.height() == from.height);
    // So many places in each pixel that every pixel of the photograph has a part.
    const int across = std::clamp(static_cast<int>(std::ceil(from.fx / pinhole.fx)), 1, 16),
              down = std::clamp(static_cast<int>(std::ceil(from.fy / pinhole.fy)), 1, 16);
    StraightPicture straight{Image<Rgb8>(pinhole.width, pinhole.height),
                             Image<std::uint8_t>(pinhole.width, pinhole.height, std::uint8_t{0})};
    tbb::parallel_for(0, pinhole.height, [&](int y) {
        const auto placeOf = [&](double u, double v) {
            const glm::dvec2 seen = distorted(lens.distortion, glm::dvec2(rayThrough(pinhole, u, v)));
            return glm::dvec2(from.fx * seen.x + from.cx, from.fy * seen.y + from.cy);
        };
        for (int x = 0; x < pinhole.width; ++x) {
            glm::dvec3 sum(0);
            for (int j = 0; j < down; ++j)
                for (int i = 0; i < across; ++i) {
                    const glm::dvec2 place = placeOf(x + (i + 0.5) / across, y + (j + 0.5) / down);
                    sum += bilinearAt(picture, place.x, place.y);
                }
            sum /= static_cast<double>(across * down);
            const auto byte = [](double v) { return static_cast<std::uint8_t>(std::lround(v)); };
            straight.colour(x, y) = {byte(sum.x), byte(sum.y), byte(sum.z)};
            const glm::dvec2 middle = placeOf(x + 0.5, y + 0.5);
            straight.isSeen(x, y) = middle.x >= 0 && middle.y >= 0 && middle.x < from.width && middle.y < from.height;
        }
    });
    return straight;
}

} // namespace scene
