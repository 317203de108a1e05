#pragma once
// Where things stand, and the conventions everything else relies on.
//
//   units     metres, seconds, radians
//   world     the capture's own coordinates, double precision (national grids have offsets of 10^6 m)
//   walk      metres, right-handed, +Y up, -Z forward, floor at Y = 0, as OpenXR
//   camera    x right, y down, z forward, as OpenCV; an eye is a camera
//   head      x right, y up, z back, as OpenXR: looks along -z
//   image     pixel (i, j) covers [i, i + 1) x [j, j + 1); its centre is (i + 1/2, j + 1/2)
//   disparity generalised: |COP to pixel on the image plane| / |COP to surface|. The image plane stands one
//   metre
//             before the COP, so that disparity is 1 / depth along z, in 1/m; 0 is infinitely far
//   matrices  column vectors, column-major; bFromA carries a point of a into b, so adjacent names cancel:
//             cFromB * bFromA = cFromA

#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

namespace scene {

/// A rigid motion bFromA: p_b = rotation * p_a + translation.
struct Pose {
    glm::dmat3 rotation{1.0};
    glm::dvec3 translation{0.0};

    glm::dvec3 operator*(const glm::dvec3& pInA) const { return rotation * pInA + translation; }
    friend bool operator==(const Pose&, const Pose&) = default;
};

/// cFromA of cFromB and bFromA.
Pose operator*(const Pose& cFromB, const Pose& bFromA);

/// aFromB.
Pose inverse(const Pose& bFromA);

/// Of the angle by which two rotations differ.
double cosineBetween(const glm::dmat3& a, const glm::dmat3& b);

glm::dmat4 toMatrix(const Pose& bFromA);

/// The pose in a 4x4 matrix: finite, last row 0 0 0 1, rotation orthonormal within tolerance and right-handed
/// (it is then made exactly so). Returns false and leaves pose alone otherwise.
bool poseFromMatrix(const glm::dmat4& matrix, double tolerance, Pose& pose);

/// Between a head, which has x right, y up and z back (as OpenXR), and a camera: half a turn about x, the same both
/// ways.
inline Pose headFromCamera() {
    return {glm::dmat3(1, 0, 0, 0, -1, 0, 0, 0, -1), glm::dvec3(0)};
}

/// As OpenXR and glTF write it; the quaternion (x, y, z, w) need not be normalised but must not be zero.
Pose poseFromQuaternion(const glm::dvec3& translation, double x, double y, double z, double w);

/// (x, y, z, w) of a pose's rotation, w >= 0.
glm::dvec4 quaternionOf(const Pose& pose);

} // namespace scene
