#pragma once
// Which part of which controller says what. Runtimes let their users change it; these are suggestions, one table for
// each interaction profile of OpenXR (specification, section 6.4).

#include <span>

namespace input {

/// What a controller can say. The poses and the three held actions exist for each hand.
enum class Act {
    aim,
    grip,
    teleport,
    grab,
    pick,
    move,
    turn,
    hurry,
    recentre,
    home,
    next,
    previous,
    undo,
};
inline constexpr int kActs = static_cast<int>(Act::undo) + 1;

enum class ActKind { pose, button, stick };
ActKind kindOf(Act act);
/// In a path of OpenXR: lower case.
const char* nameOf(Act act);
/// For people, in the runtime's own settings.
const char* titleOf(Act act);

struct Binding {
    Act act;
    const char* path; ///< /user/hand/left/input/trigger/value
};

struct Profile {
    const char* path;
    const char* title;
    const char* extension; ///< it belongs to; nullptr: to OpenXR itself
    std::span<const Binding> bindings;
};

std::span<const Profile> profiles();

} // namespace input
