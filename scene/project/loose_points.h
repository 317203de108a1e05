#pragma once
// Points without a grid: how densely they stand as seen from a place, and from where they are best seen.

#include "scene/project/cube_layout.h"
#include "scene/scan.h"

namespace scene {

/// Median angle between a point's direction and the nearest other one, as seen from a place.
AngularSteps looseSteps(const Scan& scan, const glm::dvec3& copInScanner);

/// Where loose points are projected from: the scanner's origin, unless it cannot be where they were seen
/// from.
glm::dvec3 viewpointOf(const Scan& scan);

} // namespace scene
