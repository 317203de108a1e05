#include "scene/capture/cube_capture.h"

#include <cassert>

#include <glm/matrix.hpp>

namespace scene {

View faceView(int face, const glm::dvec3& positionInWorld, int faceSize) {
    assert(face >= 0 && face < kFaceCount && faceSize >= kLeastFaceSize && faceSize <= kMostFaceSize);
    const glm::dmat3 worldFromCube(0, 0, -1, -1, 0, 0, 0, 1, 0); // its +X is ahead (-Z), its +Z up (+Y)
    const glm::dmat3 cubeFromFace = glm::transpose(facesFromCube(0.0)[static_cast<std::size_t>(face)]);
    const double middle = faceSize / 2.0, focal = middle - kMeshOverlapPixels;
    return {{faceSize, faceSize, focal, focal, middle, middle}, {worldFromCube * cubeFromFace, positionInWorld}};
}

void captureCube(const PolygonTracer& tracer, const SurfaceLight& light, const std::string& name,
                 const glm::dvec3& positionInWorld, int faceSize, const PolygonViewOptions& options,
                 const std::function<void(const DepthImage&)>& take) {
    for (int face = 0; face < kFaceCount; ++face) {
        DepthImage image = renderPolygons(tracer, light, faceView(face, positionInWorld, faceSize), options);
        image.name = name + "-" + kFaceNames[static_cast<std::size_t>(face)];
        take(image);
    }
}

} // namespace scene
