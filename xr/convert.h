#pragma once
// From fields of view to cameras.

#include "scene/view.h"

namespace xr {

/// Radians from straight ahead, as OpenXR has them: left and down are negative of an eye that sees to all sides.
struct FieldOfView {
    double left = 0, right = 0, up = 0, down = 0;
};

/// The camera whose image shows just that field of view.
scene::Camera cameraOf(const FieldOfView& field, int width, int height);

} // namespace xr
