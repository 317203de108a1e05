#pragma once
// The corners of an eye's picture that no lens shows (XR_KHR_visibility_mask).

#include "xr/convert.h"

#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>

namespace xr {

/// Triangles that hide, as the runtime gives them: places on the plane one metre before the eye, x right and y up.
struct VisibilityMask {
    std::vector<glm::dvec2> vertices;
    std::vector<std::uint32_t> indices; ///< three a triangle
};

/// Which share of the picture they cover, taken that they do not cover each other; what lies outside it does not count.
double hiddenShare(const VisibilityMask& mask, const FieldOfView& field);

} // namespace xr
