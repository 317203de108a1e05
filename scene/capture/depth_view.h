#pragma once
// Depth alone of a polygon scene: what searches need, without light.

#include "scene/capture/tracer.h"
#include "scene/depth_image.h"
#include "scene/view.h"

namespace scene {

/// As renderPolygons has it, but for the colours, which are black. In this thread.
DepthImage traceDepth(const PolygonTracer& tracer, const View& view);

/// All round from a place, as captureCube has it, in small: faceSize x faceSize pixels each.
std::vector<DepthImage> traceDepthCube(const PolygonTracer& tracer, const glm::dvec3& positionInWorld, int faceSize);

} // namespace scene
