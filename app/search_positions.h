#pragma once
// --positions auto: reference positions of a polygon scene that choose themselves (scene/plan/position_search.h).

#include "scene/capture/tracer.h"
#include "scene/plan/position_search.h"

#include <vector>

namespace app {

/// So many at most; fewer where more would hardly show anything new. Tells how far it is, and how much is still
/// unknown. Throws scene::Failure if nobody can stand in the scene.
std::vector<scene::PositionSearchStep> searchPositions(const scene::PolygonTracer& tracer, int count);

} // namespace app
