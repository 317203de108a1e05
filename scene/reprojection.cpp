#include "scene/reprojection.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/common.hpp>

namespace scene {

Reprojection reprojectionInto(const Camera& targetCamera, const Pose& worldFromTarget, const Camera& sourceCamera,
                              const Pose& worldFromSource) {
    const glm::dmat4 c = eyeImageFromSourceImage({targetCamera, worldFromTarget}, sourceCamera, worldFromSource);
    const auto column = [&](int i) { return glm::vec3(glm::dvec3(c[i])); };
    return {column(2), column(0), column(1), column(3)};
}

PixelBox boundsOfSightings(const Reprojection& into, const PixelBox& block, float lowestDisparity,
                           float highestDisparity, const Camera& target) {
    // w is affine over the block, and u and v are quotients of affine functions: extreme at its corners.
    const float far = std::numeric_limits<float>::max();
    float left = far, top = far, right = -far, bottom = -far;
    int behind = 0, unsure = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const Sighting at = sightingOf(into, static_cast<float>((corner & 1) != 0 ? block.x1 : block.x0),
                                       static_cast<float>((corner & 2) != 0 ? block.y1 : block.y0),
                                       (corner & 4) != 0 ? highestDisparity : lowestDisparity);
        behind += at.w < 0;
        // So near to the plane of the eye rounding decides.
        unsure += !(at.w > 0 && std::abs(at.u) < 1e6f && std::abs(at.v) < 1e6f);
        left = std::min(left, at.u), right = std::max(right, at.u);
        top = std::min(top, at.v), bottom = std::max(bottom, at.v);
    }
    if (behind == 8) return {};
    if (unsure > 0) return {0, 0, target.width, target.height};
    // A pixel more to each side, for rounding. Clamped before they become whole numbers: they may be huge.
    const auto pixel = [](float place, int margin, int size) {
        return static_cast<int>(std::clamp(place, -2.f, static_cast<float>(size) + 2.f)) + margin;
    };
    return {std::max(pixel(left, -2, target.width), 0), std::max(pixel(top, -2, target.height), 0),
            std::min(pixel(right, 2, target.width), target.width),
            std::min(pixel(bottom, 2, target.height), target.height)};
}

namespace {

/// The up to four samples about a position, and how much disparity changes between them.
struct Corners {
    int x0, y0, x1, y1;
    float s, t;
};

/// std::floor as an int. Without SSE 4.1, which is not asked for when compiling, std::floor is a long way round.
int floorOf(float value) {
    const int towardsZero = static_cast<int>(value);
    return towardsZero - (static_cast<float>(towardsZero) > value ? 1 : 0);
}

Corners cornersAbout(const Camera& camera, float u, float v) {
    const int x = floorOf(u - 0.5f), y = floorOf(v - 0.5f);
    const auto left = static_cast<float>(x), top = static_cast<float>(y);
    return {std::clamp(x, 0, camera.width - 1),
            std::clamp(y, 0, camera.height - 1),
            std::clamp(x + 1, 0, camera.width - 1),
            std::clamp(y + 1, 0, camera.height - 1),
            u - 0.5f - left,
            v - 0.5f - top};
}

/// Greatest disparity (the nearest surface) among the 3x3 samples about a pixel; 0 if none has one.
float nearestAbout(const DepthImage& image, int x, int y) {
    float nearest = 0;
    for (int j = std::max(y - 1, 0); j <= std::min(y + 1, image.camera.height - 1); ++j)
        for (int i = std::max(x - 1, 0); i <= std::min(x + 1, image.camera.width - 1); ++i)
            if (isSurface(image.flags(i, j))) nearest = std::max(nearest, image.disparity(i, j));
    return nearest;
}

} // namespace

Comparison compareAnywhere(const DepthImage& target, const Sighting& sighting, const ComparisonOptions& options) {
    Comparison result;
    const Camera& camera = target.camera;
    if (!isSeenIn(camera, sighting)) return result;

    const Corners at = cornersAbout(camera, sighting.u, sighting.v);
    const bool allSurface = isSurface(target.flags(at.x0, at.y0)) && isSurface(target.flags(at.x1, at.y0)) &&
                            isSurface(target.flags(at.x0, at.y1)) && isSurface(target.flags(at.x1, at.y1));
    const float d00 = target.disparity(at.x0, at.y0), d10 = target.disparity(at.x1, at.y0);
    const float d01 = target.disparity(at.x0, at.y1), d11 = target.disparity(at.x1, at.y1);
    const float lowest = std::min(std::min(d00, d10), std::min(d01, d11));
    const float highest = std::max(std::max(d00, d10), std::max(d01, d11));
    const float slope = highest - lowest;
    // Bilinear only within a surface.
    result.isSmooth = allSurface && slope <= smoothSlope(options, highest);
    float tolerance = options.sameSurface * sighting.disparity;
    if (result.isSmooth) {
        const float top = d00 + at.s * (d10 - d00), bottom = d01 + at.s * (d11 - d01);
        result.disparity = top + at.t * (bottom - top);
        tolerance += options.pixelError * slope;
    } else {
        const int x = static_cast<int>(sighting.u), y = static_cast<int>(sighting.v);
        if (!isSurface(target.flags(x, y))) return result;
        result.disparity = target.disparity(x, y);
    }

    const float difference = sighting.disparity - result.disparity;
    if (std::abs(difference) <= tolerance) {
        result.relation = Relation::agrees;
    } else if (difference < 0) {
        result.relation = Relation::behind;
    } else if (isBeforeAllAbout(target, sighting, tolerance)) {
        result.relation = Relation::inFront;
    }
    return result;
}

bool isBeforeAllAbout(const DepthImage& target, const Sighting& sighting, float tolerance) {
    const float nearest = nearestAbout(target, static_cast<int>(sighting.u), static_cast<int>(sighting.v));
    return sighting.disparity - nearest > tolerance;
}

glm::vec3 colourAt(const DepthImage& target, float u, float v) {
    const float left = u - 0.5f, top = v - 0.5f;
    if (left >= 0 && top >= 0 && left < static_cast<float>(target.camera.width - 1) &&
        top < static_cast<float>(target.camera.height - 1))
        return colourWithin(target, u, v);
    const Corners at = cornersAbout(target.camera, u, v);
    const glm::vec3 above = glm::mix(colourOf(target, at.x0, at.y0), colourOf(target, at.x1, at.y0), at.s);
    const glm::vec3 below = glm::mix(colourOf(target, at.x0, at.y1), colourOf(target, at.x1, at.y1), at.s);
    return glm::mix(above, below, at.t);
}

bool hasColourAt(const DepthImage& target, float u, float v) {
    const Corners at = cornersAbout(target.camera, u, v);
    return ((target.flags(at.x0, at.y0) | target.flags(at.x1, at.y0) | target.flags(at.x0, at.y1) |
             target.flags(at.x1, at.y1)) &
            kNoColour) == 0;
}

} // namespace scene
