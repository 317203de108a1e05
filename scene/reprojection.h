#pragma once
// The primitive under everything: take a sample of depth image A to where depth image B sees it, and compare
// disparities. McMillan and Bishop: "Plenoptic modeling", 1995; Nyland et al. 1999, sections 4.4 and 4.6.

#include "scene/depth_image.h"
#include "scene/view.h"

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

inline Sighting sightingOf(const Reprojection& into, float x, float y, float disparity) {
    const glm::vec3 h = into.origin + x * into.columnX + y * into.columnY + disparity * into.columnD;
    const float perW = 1.0f / h.z;
    return {h.x * perW, h.y * perW, disparity * perW, h.z};
}

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

/// Soft depth comparison. inFront is only said where every sample of B about (u, v), 3x3, is farther: the paper's wide
/// lines.
Comparison compareWith(const DepthImage& target, const Sighting& sighting, const ComparisonOptions& options);

/// B's colour at (u, v): bilinear; call where compareWith found a smooth surface. Linear in the stored values, 0 to
/// 255.
glm::vec3 colourAt(const DepthImage& target, float u, float v);

} // namespace scene
