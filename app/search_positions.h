#pragma once
// --positions auto: reference positions of a polygon scene that choose themselves (scene/plan/sight_search.h).

#include "scene/capture/tracer.h"

#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

namespace app {

struct SearchedPositions {
    std::vector<glm::dvec3> positions; ///< world
    /// Of what is seen from places all over, what the images of the first position alone do not know, of the first
    /// two, and so on (scene/plan/unknown_space.h).
    std::vector<double> unknownShares;
    std::int64_t trials = 0; ///< sets of positions that were weighed
};

/// So many at most; fewer where more would hardly show anything new. Tells how far it is. Throws scene::Failure if
/// nobody can stand in the scene.
SearchedPositions searchPositions(const scene::PolygonTracer& tracer, int count);

} // namespace app
