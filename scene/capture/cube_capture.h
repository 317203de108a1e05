#pragma once
// A reference position of a polygon world: what is seen from there all round, as six square depth images on the faces
// of a cube (scene/cube.h), as a scan is.

#include "scene/capture/polygon_view.h"
#include "scene/cube.h"

#include <functional>
#include <string>

namespace scene {

inline constexpr int kLeastFaceSize = 16, kMostFaceSize = 8192;

/// One face of the cube at a place of a world with +Y up; the front looks along -Z. faceSize x faceSize pixels, of
/// which kMeshOverlapPixels on each side lie beyond 90 degrees.
View faceView(int face, const glm::dvec3& positionInWorld, int faceSize);

/// Hands each face to `take` as soon as it is there, in the order of kFaceNames, so that one is held at a time; they
/// are called NAME-front, NAME-left, ...
void captureCube(const PolygonTracer& tracer, const SurfaceLight& light, const std::string& name,
                 const glm::dvec3& positionInWorld, int faceSize, const PolygonViewOptions& options,
                 const std::function<void(const DepthImage&)>& take);

} // namespace scene
