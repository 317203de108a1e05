#pragma once
// A pinhole: how a point before the COP becomes a place in the image.

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace scene {

/// Pixels; cx = width / 2 is the middle of the image. fx and fy may differ (scans are denser along one axis).
/// An eye with an asymmetric field of view is a Camera whose centre is not in the middle.
struct Camera {
    int width = 0, height = 0;
    double fx = 0, fy = 0, cx = 0, cy = 0;
    friend bool operator==(const Camera&, const Camera&) = default;
};

/// E: (x, y, 1, d) of the image -> homogeneous point of the camera (Nyland et al. 1999, eq. 1).
glm::dmat4 cameraFromImage(const Camera& camera);

/// Inverse of E: homogeneous point of the camera -> (x w, y w, w, d w).
glm::dmat4 imageFromCamera(const Camera& camera);

/// The point at depth 1 that pixel position (x, y) looks at.
inline glm::dvec3 rayThrough(const Camera& camera, double x, double y) {
    return {(x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1.0};
}

/// Where a point before the camera (z > 0) is seen.
inline glm::dvec2 project(const Camera& camera, const glm::dvec3& pInCamera) {
    return {camera.fx * pInCamera.x / pInCamera.z + camera.cx, camera.fy * pInCamera.y / pInCamera.z + camera.cy};
}

/// The same view in a picture of another size.
Camera resized(const Camera& camera, int width, int height);

/// True if sizes are positive and all numbers finite with positive focal lengths.
bool isUsable(const Camera& camera);

} // namespace scene
