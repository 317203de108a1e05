#pragma once
// Synthetic places for searches of positions: where one can stand in them, and what one sees from there.

#include "scene/plan/position_search.h"
#include "scene/sight_lines.h"
#include "scene/synthetic.h"

#include <vector>

namespace scene {

struct KnownSite {
    SyntheticScene truth;
    std::vector<glm::dvec3> places, tests; ///< tests: between the places
    CaptureSmall capture() const;
    SightLines lines() const; ///< lent the site
};

/// 5.2 x 4.2 m, with furniture.
KnownSite furnishedRoom();

/// Six small images about a place.
std::vector<DepthImage> smallCube(const SyntheticScene& truth, const glm::dvec3& position);

} // namespace scene
