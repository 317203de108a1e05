#pragma once
// How the walker's wishes move the rig: a pure function from state to state.
//
// What a wearer cannot foresee makes people sick or lost: the horizon never tilts, nothing moves while the head is not
// known, bad numbers and long pauses move nothing.

#include "input/rig.h"
#include "input/wants.h"

#include <functional>
#include <optional>
#include <vector>

namespace input {

struct LocomotionSettings {
    double snapDegrees = 30;          ///< a turn of the stick; 0: it turns smoothly
    double turnDegreesPerSecond = 90; ///< smoothly
    double metresPerSecond = 1.4;     ///< of the wearer's own: in a world made small one strides along
    double hurryFactor = 3;
    bool flies = false;          ///< ahead is where one looks, not only its horizontal part
    double steepestDegrees = 30; ///< slope of a floor one can stand on
    double reachMetres = 20;     ///< how far one can go at once, the wearer's own metres
    bool hasVignette = true;
    double vignetteRiseSeconds = 0.1, vignetteFallSeconds = 0.3;
};

/// A place on a surface that was really seen, in walk space.
struct Surface {
    glm::dvec3 position{0};
    glm::dvec3 normal{0, 1, 0}; ///< towards whoever looks; unit length
};

/// What locomotion asks of the scene; all in walk space.
struct Surroundings {
    /// Where a ray first meets something really seen. May be empty: then there is no way to go at once.
    std::function<std::optional<Surface>(const glm::dvec3& from, const glm::dvec3& direction)> hit;
    std::vector<scene::Pose> captures; ///< heads (looking along -Z) where the scanner stood
    glm::dvec3 homeFeet{0};
    double homeHeading = 0;
};

/// Where the walker would go if the hand let go now.
struct TeleportTarget {
    std::size_t hand = 0;
    glm::dvec3 from{0}, to{0}; ///< walk space
    bool isAllowed = false;    ///< seen, flat enough, near enough
};

struct Locomotion {
    Rig rig;
    double speedFactor = 1; ///< over the settings' speed
    double vignette = 0;    ///< 0 none to 1 narrowest
    std::optional<TeleportTarget> target;
    std::optional<std::size_t> capture; ///< the scanner's place one was brought to last

    // Latches.
    bool isTurnArmed = true;
    std::array<std::optional<glm::dvec3>, kHands> held; ///< what hangs on each hand, walk space
    std::array<bool, kHands> wasTeleporting{};
};

/// The state after a frame in which the walker wanted this.
Locomotion step(const Locomotion& before, const Wants& wants, const LocomotionSettings& settings,
                const Surroundings& surroundings);

/// Metres a second, in walk space, with the stick pushed all the way.
double speedOf(const Locomotion& state, const LocomotionSettings& settings);

} // namespace input
