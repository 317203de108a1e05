#include "xr/convert.h"

#include <cmath>

namespace xr {

scene::Camera cameraOf(const FieldOfView& field, int width, int height) {
    const double left = std::tan(field.left), right = std::tan(field.right);
    const double up = std::tan(field.up), down = std::tan(field.down);
    const double fx = width / (right - left), fy = height / (up - down);
    return {width, height, fx, fy, -left * fx, up * fy};
}

} // namespace xr
