#pragma once
// Directions spread evenly, to look round with.

#include <vector>

#include <glm/vec3.hpp>

namespace scene {

/// Unit directions, each for as much of the sphere as the others, down to a least y (the sine of an elevation; -1: all
/// of the sphere): a spiral of equal areas about +Y, turned by the golden angle from one to the next, which leaves no
/// clumps.
std::vector<glm::dvec3> spreadDirections(int count, double leastY = -1);

} // namespace scene
