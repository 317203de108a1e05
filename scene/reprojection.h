#pragma once
// The primitive under everything: take a sample of depth image A to where depth image B sees it, and compare
// disparities. McMillan and Bishop: "Plenoptic modeling", 1995; Nyland et al. 1999, sections 4.4 and 4.6.

#include "scene/depth_image.h"
#include "scene/view.h"

#include <algorithm>
#include <cmath>

#include <glm/vec3.hpp>

namespace scene {

/// C = P V M of a pair in the form that costs three multiply-adds a sample: h = origin + x columnX + y columnY + d
/// columnD = (u w, v w, w), composed in double precision and only then rounded.
struct Reprojection {
    glm::vec3 origin, columnX, columnY, columnD;
};

Reprojection reprojectionInto(const Camera& targetCamera, const Pose& worldFromTarget, const Camera& sourceCamera,
                              const Pose& worldFromSource);

inline Reprojection reprojectionInto(const DepthImage& target, const DepthImage& source) {
    return reprojectionInto(target.camera, target.worldFromCamera, source.camera, source.worldFromCamera);
}

/// Where a sample is seen: position (u, v) in the target's pixels and disparity (1/m). Meaningless unless w > 0.
struct Sighting {
    float u = 0, v = 0, disparity = 0, w = 0;
};

/// Whether it is before the camera and within its image.
inline bool isSeenIn(const Camera& camera, const Sighting& at) {
    return at.w > 0 && at.u >= 0 && at.v >= 0 && at.u < static_cast<float>(camera.width) &&
           at.v < static_cast<float>(camera.height);
}

inline Sighting sightingOf(const Reprojection& into, float x, float y, float disparity) {
    const glm::vec3 h = into.origin + x * into.columnX + y * into.columnY + disparity * into.columnD;
    const float perW = 1.0f / h.z;
    return {h.x * perW, h.y * perW, disparity * perW, h.z};
}

/// Pixels of an image, x1 and y1 excluded.
struct PixelBox {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
    bool isEmpty() const { return x0 >= x1 || y0 >= y1; }
};

/// All pixels of the target in which samples of a block of the source can be seen: those whose places are within
/// `block` and whose disparities lie between the two. Somewhat too large, never too small.
PixelBox boundsOfSightings(const Reprojection& into, const PixelBox& block, float lowestDisparity,
                           float highestDisparity, const Camera& target);

/// How a sample of A stands to what B saw along the same ray.
enum class Relation {
    outside, ///< behind B, beside its image, or where B has no range
    agrees,  ///< both sampled the same surface
    inFront, ///< B saw through it: the sample claims surface where B found empty space
    behind   ///< hidden from B by something nearer
};

struct Comparison {
    Relation relation = Relation::outside;
    float disparity = 0;   ///< of B's surface at (u, v), where B has one; bilinear within a surface
    bool isSmooth = false; ///< the four samples of B about (u, v) are one surface: bilinear was used
};

struct ComparisonOptions {
    float sameSurface = 0.02f; ///< relative difference in disparity up to which two samples are one surface
    float pixelError =
        1.0f; ///< how many pixels B's samples may be misplaced: B's own slope over so many is allowed for
};

/// How much disparity may change between four samples of one surface. A surface may be steep, but a step of several
/// times the tolerance is a silhouette.
inline float smoothSlope(const ComparisonOptions& options, float highest) {
    return 4 * options.sameSurface * highest;
}

/// Soft depth comparison. inFront is only said where every sample of B about (u, v), 3x3, is farther: the paper's wide
/// lines.
Comparison compareWith(const DepthImage& target, const Sighting& sighting, const ComparisonOptions& options);

/// The same, wherever the sighting is: what compareWith asks when the four samples about it are no surface within the
/// image.
Comparison compareAnywhere(const DepthImage& target, const Sighting& sighting, const ComparisonOptions& options);

/// Whether every sample of B about the sighting is farther than it by more than tolerance.
bool isBeforeAllAbout(const DepthImage& target, const Sighting& sighting, float tolerance);

/// The stored values of a pixel, 0 to 255.
inline glm::vec3 colourOf(const DepthImage& image, int x, int y) {
    const Rgb8 c = image.colour(x, y);
    return {c.r, c.g, c.b};
}

/// Bilinear colour where all four samples about (u, v) are within the image. Linear in the stored values.
inline glm::vec3 colourWithin(const DepthImage& image, float u, float v) {
    const float left = u - 0.5f, top = v - 0.5f;
    const int x = static_cast<int>(left), y = static_cast<int>(top);
    const float s = left - static_cast<float>(x), t = top - static_cast<float>(y);
    const Rgb8* const upper = &image.colour(x, y);
    const Rgb8* const lower = upper + image.camera.width;
    const auto mix = [&](std::uint8_t a, std::uint8_t b, std::uint8_t c, std::uint8_t d) {
        const float above = static_cast<float>(a) + s * static_cast<float>(b - a);
        const float below = static_cast<float>(c) + s * static_cast<float>(d - c);
        return above + t * (below - above);
    };
    return {mix(upper[0].r, upper[1].r, lower[0].r, lower[1].r), mix(upper[0].g, upper[1].g, lower[0].g, lower[1].g),
            mix(upper[0].b, upper[1].b, lower[0].b, lower[1].b)};
}

/// The same anywhere in the image; its rim goes on beyond it. Of B, where compareWith found a smooth surface.
glm::vec3 colourAt(const DepthImage& target, float u, float v);
/// Whether all of what that is mixed of has a colour of its own (kNoColour).
bool hasColourAt(const DepthImage& target, float u, float v);

// Inline, since the stages of refine compare every sample with every partner. The parts of the result stay apart until
// the end: g++ 12 would carry a whole Comparison through memory, and wait for it there.
inline Comparison compareWith(const DepthImage& target, const Sighting& sighting, const ComparisonOptions& options) {
    const float left = sighting.u - 0.5f, top = sighting.v - 0.5f;
    const int width = target.camera.width, height = target.camera.height;
    if (!isSeenIn(target.camera, sighting)) return {};
    if (left >= 0 && top >= 0 && left < static_cast<float>(width - 1) && top < static_cast<float>(height - 1)) {
        const int x = static_cast<int>(left), y = static_cast<int>(top);
        const std::uint8_t* const flags = &target.flags(x, y);
        const auto anyFlags = static_cast<std::uint8_t>(flags[0] | flags[1] | flags[width] | flags[width + 1]);
        const float* const d = &target.disparity(x, y);
        const float d00 = d[0], d10 = d[1], d01 = d[width], d11 = d[width + 1];
        const float highest = std::max(std::max(d00, d10), std::max(d01, d11));
        const float slope = highest - std::min(std::min(d00, d10), std::min(d01, d11));
        if (isSurface(anyFlags) && slope <= smoothSlope(options, highest)) {
            const float s = left - static_cast<float>(x), t = top - static_cast<float>(y);
            const float above = d00 + s * (d10 - d00), below = d01 + s * (d11 - d01);
            const float disparity = above + t * (below - above);
            const float tolerance = options.sameSurface * sighting.disparity + options.pixelError * slope;
            const float difference = sighting.disparity - disparity;
            Relation relation = Relation::outside;
            if (std::abs(difference) <= tolerance)
                relation = Relation::agrees;
            else if (difference < 0)
                relation = Relation::behind;
            else if (isBeforeAllAbout(target, sighting, tolerance))
                relation = Relation::inFront;
            return {relation, disparity, true};
        }
    }
    const Comparison elsewhere = compareAnywhere(target, sighting, options);
    return {elsewhere.relation, elsewhere.disparity, elsewhere.isSmooth};
}

} // namespace scene
