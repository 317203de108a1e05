#pragma once
// An upright box about what was observed: where walls, floor and ceiling of a place are, as far as it was seen. Of all
// upright boxes about the surfaces the one over the least ground, so that it lies along the walls however the place is
// turned in its world.

#include "scene/coverage.h"
#include "scene/pose.h"

#include <glm/vec3.hpp>

namespace scene {

/// Inside is 0 <= boundsFromWorld * p <= size: x and z over the ground, y up; metres.
struct UprightBounds {
    Pose boundsFromWorld;
    glm::dvec3 size{0.0};
    bool isEmpty() const { return !(size.x > 0 && size.y > 0 && size.z > 0); }
    double cubicMetres() const { return size.x * size.y * size.z; }
    bool holds(const glm::dvec3& pInWorld) const;
};

/// What was seen far off through a small window does not count. walkFromWorld: +Y up (scene/pose.h). Empty if nothing
/// was seen empty.
UprightBounds findUprightBounds(const Coverage& coverage, const Pose& walkFromWorld);

/// All that a coverage knows of, along the world's axes.
UprightBounds wholeCube(const Coverage& coverage);

/// Cubic metres of a box that nobody observed; from points on a grid, a million at most. Parallel; the same on any
/// number of threads.
double unseenWithin(const Coverage& coverage, const UprightBounds& bounds);

} // namespace scene
