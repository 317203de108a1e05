#pragma once
// A walker and a room for tests of locomotion.

#include "input/locomotion.h"

#include <cmath>
#include <limits>
#include <numbers>

namespace input {

inline constexpr double kDegree = std::numbers::pi / 180;
inline constexpr double kMillimetre = 1e-3, kHundredthOfADegree = 0.01 * kDegree;

inline scene::Pose poseAt(const glm::dvec3& place, double heading = 0, double tilt = 0) {
    const scene::Pose yaw = scene::poseFromQuaternion(place, 0, std::sin(heading / 2), 0, std::cos(heading / 2));
    return yaw * scene::poseFromQuaternion({0, 0, 0}, std::sin(tilt / 2), 0, 0, std::cos(tilt / 2));
}

inline Wants standing() {
    Wants wants;
    wants.seconds = 1.0 / 90;
    wants.trackingFromHead = poseAt({0.2, 1.6, 0.1}, 20 * kDegree, -10 * kDegree);
    return wants;
}

/// A floor at y = 0.5, seen from above, and a wall at z = -5, for rays from before them.
inline Surroundings room() {
    Surroundings surroundings;
    surroundings.hit = [](const glm::dvec3& from, const glm::dvec3& d) -> std::optional<Surface> {
        const double toFloor = d.y < 0 ? (0.5 - from.y) / d.y : std::numeric_limits<double>::infinity();
        const double toWall = d.z < 0 ? (-5 - from.z) / d.z : std::numeric_limits<double>::infinity();
        if (std::isinf(toFloor) && std::isinf(toWall)) return std::nullopt;
        if (toFloor < toWall) return Surface{from + toFloor * d, {0, 1, 0}};
        return Surface{from + toWall * d, {0, 0, 1}};
    };
    surroundings.captures = {poseAt({1, 1.2, 1}, 0.3, 0.2), poseAt({2, 1.3, 1}, -0.4), poseAt({3, 1.4, 1}, 2)};
    surroundings.homeFeet = {0.5, 0, 0.25};
    surroundings.homeHeading = 0.1;
    return surroundings;
}

inline glm::dvec3 headOf(const Locomotion& state, const Wants& wants) {
    return state.rig.toWalk(wants.trackingFromHead.translation);
}
inline double headingOf(const Locomotion& state, const Wants& wants) {
    return input::headingOf(state.rig.toWalk(wants.trackingFromHead).rotation);
}

} // namespace input
