#pragma once
// Lines of sight through a scene of any kind: what a ray meets, and whether anything stands between two places.

#include <functional>
#include <optional>

#include <glm/vec3.hpp>

namespace scene {

/// Where a ray meets a surface, in the world.
struct SightEnd {
    glm::dvec3 position{0}, normal{0}; ///< normal: a unit vector, to either side
};

/// In the world. May be asked from any number of threads.
struct SightLines {
    std::function<std::optional<SightEnd>(const glm::dvec3& from, const glm::dvec3& direction)> cast;
    /// Short of where the line ends: a surface there does not count.
    std::function<bool(const glm::dvec3& from, const glm::dvec3& to)> isBlocked;
};

} // namespace scene
