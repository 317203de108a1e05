#pragma once
// Distances to simplices: a point, a segment, a triangle or a tetrahedron.

#include <span>

#include <glm/vec3.hpp>

namespace scene {

/// The place in the simplex with these corners (1 to 4) that is nearest to p. Corners may coincide or lie in a line:
/// then the simplex is what they span.
glm::dvec3 nearestInSimplex(std::span<const glm::dvec3> corners, const glm::dvec3& p);

} // namespace scene
