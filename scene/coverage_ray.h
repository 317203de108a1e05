#pragma once
// A ray through the tree of what was observed: the same question that pictures ask for each pixel
// (render/shaders/shared/unseen.h), in double precision.

#include "scene/coverage.h"

namespace scene {

/// What is drawn stands on a surface, within its samples' error: a ray is asked about up to this share of its range
/// before it, since the surface's own far side must not count.
inline constexpr double kSurfaceSlack = 0.004;

/// Metres along a ray to where space begins that no image observed; nothing if none does before `end`. direction: a
/// unit vector. Where the origin itself stands in such space, that is looked through, but no farther than `pocket`
/// metres along the ray (pictures: of depth): beyond, the answer is where that stretch ends. Outside of the cube
/// nothing was observed, but a ray that leaves it in observed space meets nothing.
std::optional<double> firstUnseen(const Coverage& coverage, const glm::dvec3& originInWorld,
                                  const glm::dvec3& direction, double end, double pocket = 0);

} // namespace scene
