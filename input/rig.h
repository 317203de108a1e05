#pragma once
// Where the wearer's room stands in the scene: turned about the vertical only, since a tilted horizon makes people
// sick.
//
//   walk space       scene/pose.h
//   tracking space   wants.h

#include "scene/pose.h"

namespace input {

struct Rig {
    glm::dvec3 origin{0}; ///< of tracking space, in walk space
    double yaw = 0;       ///< radians about +Y; positive to the left
    double scale = 1;     ///< walk metres per tracking metre: above 1 the world looks small

    glm::dmat3 rotation() const;
    glm::dvec3 toWalk(const glm::dvec3& pInTracking) const;
    /// Of a head, hand or eye; distances are scaled, its axes keep their length.
    scene::Pose toWalk(const scene::Pose& trackingFromThing) const;
};

/// The heading of a head that looks along -Z, radians about +Y: of its crown or chin where it looks straight up or
/// down.
double headingOf(const glm::dmat3& rotation);

/// The rig, with this scale, that brings a head to a place in walk space and to a heading.
Rig rigWithHeadAt(const scene::Pose& trackingFromHead, const glm::dvec3& place, double heading, double scale);

/// The same, but the floor under the head comes to that place.
Rig rigWithFeetAt(const scene::Pose& trackingFromHead, const glm::dvec3& place, double heading, double scale);

/// Turned by so much to the left about a point of tracking space, which stays where it is in walk space.
Rig turned(const Rig& rig, double radians, const glm::dvec3& pInTracking);

} // namespace input
