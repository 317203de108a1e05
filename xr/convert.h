#pragma once
// Between a head, which has x right, y up and z back, and a camera, which has x right, y down and z forward
// (scene/pose.h); and from fields of view to cameras.

#include "scene/view.h"

namespace xr {

/// Half a turn about x, the same both ways.
inline scene::Pose headFromCamera() {
    return {glm::dmat3(1, 0, 0, 0, -1, 0, 0, 0, -1), glm::dvec3(0)};
}

/// Radians from straight ahead, as OpenXR has them: left and down are negative of an eye that sees to all sides.
struct FieldOfView {
    double left = 0, right = 0, up = 0, down = 0;
};

/// The camera whose image shows just that field of view.
scene::Camera cameraOf(const FieldOfView& field, int width, int height);

} // namespace xr
