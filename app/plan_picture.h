#pragma once
// A floor plan of what was observed, with where scanners stood and where the next ones should stand.

#include "scene/plan/next_scan.h"
#include "scene/scene.h"

#include <cstddef>
#include <span>
#include <vector>

namespace app {

/// A PNG, encoded. The plan lies as the box of plan.bounds does, turned so that walk's -Z (the way the first camera
/// looks) is within 45 degrees of up. stood: world.
std::vector<std::byte> drawPlan(const scene::Scene& scene, const scene::NextScanPlan& plan,
                                std::span<const glm::dvec3> stood);

} // namespace app
