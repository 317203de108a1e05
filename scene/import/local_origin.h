#pragma once
// Points that carry a national grid's offsets inside, and an origin near them that single precision can bear.

#include <optional>
#include <span>

#include <glm/vec3.hpp>

namespace scene {

/// Ranges beyond this lose sub-millimetre accuracy in single precision (half a step at 10 km is 0.5 mm; we
/// stay below).
inline constexpr double kFarMetres = 1000.0;

/// A place amid the points if they stand so far from their origin that it cannot be the scanner: farther than
/// kFarMetres and than four times their own extent. Whole metres, so that shifting by it is exact. Judged by
/// medians: a few outliers, such as 0 0 0 for no return, do not matter. Nothing for points that belong where
/// they are, and for no points.
std::optional<glm::dvec3> localOrigin(std::span<const glm::dvec3> points);

} // namespace scene
