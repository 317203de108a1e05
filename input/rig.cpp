#include "input/rig.h"

#include <cmath>
#include <numbers>

namespace input {

namespace {

/// Nearer than this to straight up or down, where a head looks says nothing of its heading; cosine.
constexpr double kSteep = 0.999;

/// To (-pi, pi], so that a million turns lose nothing.
double wrapped(double radians) {
    return std::remainder(radians, 2 * std::numbers::pi);
}

} // namespace

glm::dmat3 Rig::rotation() const {
    const double s = std::sin(yaw), c = std::cos(yaw);
    return {c, 0, -s, 0, 1, 0, s, 0, c};
}

glm::dvec3 Rig::toWalk(const glm::dvec3& p) const {
    return origin + rotation() * (scale * p);
}

scene::Pose Rig::toWalk(const scene::Pose& trackingFromThing) const {
    return {rotation() * trackingFromThing.rotation, toWalk(trackingFromThing.translation)};
}

double headingOf(const glm::dmat3& rotation) {
    glm::dvec3 ahead = -rotation[2];
    if (std::abs(ahead.y) > kSteep) ahead = ahead.y > 0 ? -rotation[1] : rotation[1];
    return std::atan2(-ahead.x, -ahead.z);
}

Rig rigWithHeadAt(const scene::Pose& trackingFromHead, const glm::dvec3& place, double heading, double scale) {
    Rig rig;
    rig.scale = scale;
    rig.yaw = wrapped(heading - headingOf(trackingFromHead.rotation));
    rig.origin = place - rig.rotation() * (scale * trackingFromHead.translation);
    return rig;
}

Rig rigWithFeetAt(const scene::Pose& trackingFromHead, const glm::dvec3& place, double heading, double scale) {
    scene::Pose onFloor = trackingFromHead;
    onFloor.translation.y = 0;
    return rigWithHeadAt(onFloor, place, heading, scale);
}

Rig turned(const Rig& rig, double radians, const glm::dvec3& p) {
    Rig result = rig;
    result.yaw = wrapped(rig.yaw + radians);
    result.origin += rig.toWalk(p) - result.toWalk(p);
    return result;
}

} // namespace input
