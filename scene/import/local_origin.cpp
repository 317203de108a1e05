#include "scene/import/local_origin.h"

#include "scene/median.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <glm/geometric.hpp>

namespace scene {
std::optional<glm::dvec3> localOrigin(std::span<const glm::dvec3> points) {
    if (points.empty()) return std::nullopt;
    glm::dvec3 centre{0.0};
    std::vector<double> values(points.size());
    for (int axis = 0; axis < 3; ++axis) {
        for (std::size_t i = 0; i < points.size(); ++i)
            values[i] = points[i][axis];
        centre[axis] = std::round(medianOf(values));
    }
    for (std::size_t i = 0; i < points.size(); ++i)
        values[i] = glm::distance(points[i], centre);
    const double extent = medianOf(values), away = glm::length(centre);
    if (!std::isfinite(away) || away < kFarMetres || away < 4.0 * extent) return std::nullopt;
    return centre;
}

void PointsAboutOrigin::add(const glm::dvec3& p) {
    if (isDecided_) {
        points_.emplace_back(glm::vec3(p - shift_));
        return;
    }
    waiting_.push_back(p);
    if (waiting_.size() == kDeciding) decide();
}

std::optional<glm::dvec3> PointsAboutOrigin::finish() {
    if (!isDecided_) decide();
    return origin_;
}

void PointsAboutOrigin::decide() {
    isDecided_ = true;
    origin_ = localOrigin(waiting_);
    shift_ = origin_.value_or(glm::dvec3(0.0));
    for (const glm::dvec3& p : waiting_)
        points_.emplace_back(glm::vec3(p - shift_));
    waiting_ = {};
}

} // namespace scene
