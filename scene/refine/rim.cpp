#include "scene/refine/rim.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include <tbb/parallel_for.h>

namespace scene {

namespace {

constexpr int kMarginShare = 8; ///< of the face's width that it is continued by: one part in so many

std::size_t samplesOf(const Camera& face) {
    const auto margin = static_cast<std::size_t>(Rim::marginOf(face)), width = static_cast<std::size_t>(face.width),
               height = static_cast<std::size_t>(face.height);
    return 2 * margin * (width + height + 2 * margin);
}

} // namespace

RayEnd rayEndOf(const DepthImage& image, int x, int y) {
    RayEnd end;
    if (isDrawable(image.flags(x, y))) end.disparity = image.disparity(x, y);
    if (isOpenSky(image.flags(x, y))) end.disparity = 0;
    const auto isSame = [sky = isOpenSky(image.flags(x, y))](std::uint8_t other) {
        return sky ? isOpenSky(other) : isSurface(other);
    };
    const int right = x + 1, below = y + 1;
    if (right < image.camera.width && below < image.camera.height)
        end.isEdge = (image.flags(x, y) & (kSkinUpper | kSkinLower)) != 0 || !isSame(image.flags(x, y)) ||
                     !isSame(image.flags(right, y)) || !isSame(image.flags(x, below)) ||
                     !isSame(image.flags(right, below));
    return end;
}

int Rim::marginOf(const Camera& face) {
    return std::max(face.width / kMarginShare, 2);
}

Rim::Rim(const Camera& face, const glm::dmat3& worldFromFace)
    : margin_(marginOf(face)), widened_(face), worldFromFace_(worldFromFace) {
    widened_.width += 2 * margin_, widened_.height += 2 * margin_;
    widened_.cx += margin_, widened_.cy += margin_;
    disparities_.assign(samplesOf(face), RayEnd::kNothing);
    edges_.assign(samplesOf(face), 1);
}

bool Rim::mayShow(const Camera& face, const glm::dmat3& worldFromFace, const Camera& other,
                  const glm::dmat3& worldFromOther) {
    if (face == other && worldFromFace == worldFromOther) return false;
    const int margin = marginOf(face);
    const double right = std::max(face.width + margin - face.cx, face.cx + margin) / face.fx,
                 down = std::max(face.height + margin - face.cy, face.cy + margin) / face.fy;
    // Of rays of depth 1, the most along the other's axis.
    const glm::dvec3 along = glm::transpose(worldFromFace) * worldFromOther[2];
    return right * std::abs(along.x) + down * std::abs(along.y) + along.z > 0;
}

void Rim::take(const DepthImage& image) {
    const Camera& camera = image.camera;
    const auto takeRay = [&](int x, int y) {
        const std::size_t index = indexOf(x, y);
        if (disparities_[index] < RayEnd::kNothing) return;
        const glm::dvec3 inWorld = worldFromFace_ * rayThrough(widened_, x + 0.5, y + 0.5);
        const glm::dvec3 there = glm::transpose(image.worldFromCamera.rotation) * inWorld;
        if (there.z <= 0) return;
        const glm::dvec2 at = project(camera, there);
        if (!(at.x >= 0 && at.y >= 0 && at.x < camera.width && at.y < camera.height)) return;
        const int column = static_cast<int>(at.x), row = static_cast<int>(at.y);
        const RayEnd end = rayEndOf(image, column, row);
        if (!end.provesSomething()) return;
        // Depths of one point along two axes are as the ray's lengths along them.
        disparities_[index] = static_cast<float>(end.disparity * there.z);
        // The next image sees on where this one ends.
        const bool isBorder = column + 1 >= camera.width || row + 1 >= camera.height;
        edges_[index] = !isBorder && end.isEdge ? 1 : 0;
    };
    tbb::parallel_for(0, widened_.height, [&](int y) {
        const int left = crossesFace(y) ? margin_ : widened_.width, right = widened_.width - margin_;
        for (int x = 0; x < left; ++x)
            takeRay(x, y);
        for (int x = right; crossesFace(y) && x < widened_.width; ++x)
            takeRay(x, y);
    });
}

RayEnd Rim::at(int x, int y) const {
    const std::size_t index = indexOf(x, y);
    return {disparities_[index], edges_[index] != 0};
}

std::size_t Rim::bytesOf(const Camera& face) {
    return samplesOf(face) * (sizeof(float) + sizeof(std::uint8_t));
}

std::size_t Rim::indexOf(int x, int y) const {
    assert(!crossesFace(y) || x < margin_ || x >= widened_.width - margin_);
    const auto width = static_cast<std::size_t>(widened_.width), across = 2 * static_cast<std::size_t>(margin_),
               row = static_cast<std::size_t>(y), column = static_cast<std::size_t>(x),
               margin = static_cast<std::size_t>(margin_),
               face = static_cast<std::size_t>(widened_.height) - across; // rows that cross it
    if (y < margin_) return row * width + column;
    if (crossesFace(y))
        return margin * width + (row - margin) * across + (x < margin_ ? column : column + across - width);
    return margin * width + face * across + (row - margin - face) * width + column;
}

} // namespace scene
