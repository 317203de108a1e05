#include "scene/directions.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace scene {

std::vector<glm::dvec3> spreadDirections(int count, double leastY) {
    const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
    std::vector<glm::dvec3> directions;
    for (int i = 0; i < count; ++i) {
        const double y = 1 - (i + 0.5) / count * (1 - leastY);
        const double across = std::sqrt(std::max(0.0, 1 - y * y)), angle = golden * i;
        directions.emplace_back(across * std::cos(angle), y, across * std::sin(angle));
    }
    return directions;
}

} // namespace scene
