#include "scene/pose.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/matrix.hpp>

namespace scene {

Pose operator*(const Pose& cFromB, const Pose& bFromA) {
    return {cFromB.rotation * bFromA.rotation, cFromB.rotation * bFromA.translation + cFromB.translation};
}

Pose inverse(const Pose& bFromA) {
    const glm::dmat3 aFromBRotation = glm::transpose(bFromA.rotation);
    return {aFromBRotation, -(aFromBRotation * bFromA.translation)};
}

double cosineBetween(const glm::dmat3& a, const glm::dmat3& b) {
    double trace = 0;
    for (int i = 0; i < 3; ++i)
        trace += glm::dot(a[i], b[i]);
    return (trace - 1) / 2;
}

glm::dmat4 toMatrix(const Pose& bFromA) {
    glm::dmat4 matrix(bFromA.rotation);
    matrix[3] = glm::dvec4(bFromA.translation, 1.0);
    return matrix;
}

bool poseFromMatrix(const glm::dmat4& matrix, double tolerance, Pose& pose) {
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row)
            if (!std::isfinite(matrix[column][row])) return false;
    for (int column = 0; column < 4; ++column)
        if (std::abs(matrix[column][3] - (column == 3 ? 1.0 : 0.0)) > tolerance) return false;

    glm::dmat3 rotation(matrix);
    const glm::dmat3 gram = glm::transpose(rotation) * rotation;
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row)
            if (std::abs(gram[column][row] - (column == row ? 1.0 : 0.0)) > tolerance) return false;
    if (glm::determinant(rotation) < 0.0) return false;

    rotation[0] = glm::normalize(rotation[0]);
    rotation[2] = glm::normalize(glm::cross(rotation[0], rotation[1]));
    rotation[1] = glm::cross(rotation[2], rotation[0]);
    pose = {rotation, glm::dvec3(matrix[3])};
    return true;
}

Pose poseFromQuaternion(const glm::dvec3& translation, double x, double y, double z, double w) {
    // Any length will do, also one whose square is no number: the largest component becomes 1 first.
    const double largest = std::max({std::abs(x), std::abs(y), std::abs(z), std::abs(w)});
    assert(largest > 0.0 && std::isfinite(largest));
    glm::dquat q;
    q.x = x / largest, q.y = y / largest, q.z = z / largest, q.w = w / largest;
    return {glm::mat3_cast(glm::normalize(q)), translation};
}

glm::dvec4 quaternionOf(const Pose& pose) {
    glm::dquat q = glm::quat_cast(pose.rotation);
    if (q.w < 0.0) q = -q;
    return {q.x, q.y, q.z, q.w};
}

} // namespace scene
