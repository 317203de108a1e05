#pragma once
// What the walker wants during one frame, whichever device says so: controllers, keyboard and mouse, a gamepad.
//
//   tracking space   metres, +Y up, -Z forward, floor at Y = 0: the wearer's room, or the desk (xr/view_source.h)

#include "scene/pose.h"

#include <array>
#include <cstddef>

namespace input {

inline constexpr std::size_t kHands = 2; ///< left, right

struct Hand {
    bool isTracked = false;
    scene::Pose trackingFromAim;  ///< points along -Z: a controller's ray, or the mouse's
    scene::Pose trackingFromGrip; ///< where the hand itself is
    bool teleports = false;       ///< held while aiming; the walker goes when it is let go
    bool grabs = false;           ///< held: the world hangs on the hand
    bool picks = false;           ///< held while aiming; a point is set when it is let go
};

/// Analogue values hold on as long as they are wanted; what is said once is true in one frame only.
struct Wants {
    double seconds = 0;           ///< since the frame before
    scene::Pose trackingFromHead; ///< in this frame
    bool isHeadTracked = true;    ///< false: trackingFromHead is an old one, or made up; the walker stays
    std::array<Hand, kHands> hands{};
    glm::dvec2 move{0}; ///< to the right and ahead of where the head looks, each -1 to 1
    double climb = 0;   ///< -1 down to 1 up
    double turn = 0;    ///< a stick or key, -1 left to 1 right: smooth or in snaps, as the settings say
    double turnBy = 0;  ///< radians to the right, at once: the mouse's share
    double speedUp = 0; ///< steps the speed is raised by, once; negative: lowered
    double scaleUp = 0; ///< steps the world is enlarged by, once; negative: made smaller
    double riseBy = 0;  ///< metres the eyes are raised by, once
    bool recentre = false, home = false, next = false, previous = false; ///< each said once
    bool undo = false;                                                   ///< of the last point set; said once
    bool hurries = false;                                                ///< held: faster
};

} // namespace input
