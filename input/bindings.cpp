#include "input/bindings.h"

#include <array>

namespace input {

namespace {

#define LEFT "/user/hand/left/input/"
#define RIGHT "/user/hand/right/input/"
#define POSES                                                                                                          \
    {Act::aim, LEFT "aim/pose"}, {Act::aim, RIGHT "aim/pose"}, {Act::grip, LEFT "grip/pose"}, {                        \
        Act::grip, RIGHT "grip/pose"                                                                                   \
    }

// Two buttons a hand: the hands share out what matters most, going and measuring.
constexpr Binding kSimple[] = {
    POSES,
    {Act::teleport, RIGHT "select/click"},
    {Act::pick, LEFT "select/click"},
    {Act::recentre, LEFT "menu/click"},
    {Act::next, RIGHT "menu/click"},
};

constexpr Binding kTouch[] = {
    POSES,
    {Act::pick, LEFT "trigger/value"},
    {Act::pick, RIGHT "trigger/value"},
    {Act::grab, LEFT "squeeze/value"},
    {Act::grab, RIGHT "squeeze/value"},
    {Act::move, LEFT "thumbstick"},
    {Act::turn, RIGHT "thumbstick"},
    {Act::hurry, LEFT "thumbstick/click"},
    {Act::recentre, RIGHT "thumbstick/click"},
    {Act::teleport, RIGHT "a/click"},
    {Act::undo, RIGHT "b/click"},
    {Act::previous, LEFT "x/click"},
    {Act::next, LEFT "y/click"},
    {Act::home, LEFT "menu/click"},
};

constexpr Binding kIndex[] = {
    POSES,
    {Act::pick, LEFT "trigger/click"},
    {Act::pick, RIGHT "trigger/click"},
    {Act::grab, LEFT "squeeze/value"},
    {Act::grab, RIGHT "squeeze/value"},
    {Act::move, LEFT "thumbstick"},
    {Act::turn, RIGHT "thumbstick"},
    {Act::hurry, LEFT "thumbstick/click"},
    {Act::recentre, RIGHT "thumbstick/click"},
    {Act::teleport, RIGHT "a/click"},
    {Act::undo, RIGHT "b/click"},
    {Act::previous, LEFT "a/click"},
    {Act::next, LEFT "b/click"},
    {Act::home, LEFT "trackpad/force"},
};

constexpr Binding kVive[] = {
    POSES,
    {Act::pick, LEFT "trigger/click"},
    {Act::pick, RIGHT "trigger/click"},
    {Act::grab, LEFT "squeeze/click"},
    {Act::grab, RIGHT "squeeze/click"},
    {Act::move, LEFT "trackpad"},
    {Act::turn, RIGHT "trackpad"},
    {Act::teleport, RIGHT "trackpad/click"},
    {Act::hurry, LEFT "trackpad/click"},
    {Act::recentre, LEFT "menu/click"},
    {Act::next, RIGHT "menu/click"},
};

constexpr Binding kMixedReality[] = {
    POSES,
    {Act::pick, LEFT "trigger/value"},
    {Act::pick, RIGHT "trigger/value"},
    {Act::grab, LEFT "squeeze/click"},
    {Act::grab, RIGHT "squeeze/click"},
    {Act::move, LEFT "thumbstick"},
    {Act::turn, RIGHT "thumbstick"},
    {Act::hurry, LEFT "thumbstick/click"},
    {Act::home, RIGHT "thumbstick/click"},
    {Act::teleport, RIGHT "trackpad/click"},
    {Act::next, LEFT "trackpad/click"},
    {Act::recentre, LEFT "menu/click"},
    {Act::undo, RIGHT "menu/click"},
};

constexpr Binding kHandInteraction[] = {
    POSES,
    {Act::pick, LEFT "pinch_ext/value"},
    {Act::pick, RIGHT "pinch_ext/value"},
    {Act::grab, LEFT "grasp_ext/value"},
    {Act::grab, RIGHT "grasp_ext/value"},
    {Act::teleport, RIGHT "aim_activate_ext/value"},
};

#undef POSES
#undef LEFT
#undef RIGHT

constexpr Profile kProfiles[] = {
    {"/interaction_profiles/khr/simple_controller", "a simple controller", nullptr, kSimple},
    {"/interaction_profiles/oculus/touch_controller", "Touch", nullptr, kTouch},
    {"/interaction_profiles/valve/index_controller", "Index", nullptr, kIndex},
    {"/interaction_profiles/htc/vive_controller", "Vive", nullptr, kVive},
    {"/interaction_profiles/microsoft/motion_controller", "Windows Mixed Reality", nullptr, kMixedReality},
    {"/interaction_profiles/ext/hand_interaction_ext", "bare hands", "XR_EXT_hand_interaction", kHandInteraction},
};

struct Named {
    ActKind kind;
    const char* name;
    const char* title;
};

constexpr std::array<Named, kActs> kNames{{
    {ActKind::pose, "aim", "Where the hand points"},
    {ActKind::pose, "grip", "Where the hand is"},
    {ActKind::button, "teleport", "Go there (hold, aim, let go)"},
    {ActKind::button, "grab", "Hold the world"},
    {ActKind::button, "pick", "Set a point (left), measure (right): hold, aim, let go"},
    {ActKind::stick, "move", "Walk"},
    {ActKind::stick, "turn", "Turn; fly up and down"},
    {ActKind::button, "hurry", "Faster"},
    {ActKind::button, "recentre", "Recentre"},
    {ActKind::button, "home", "Back to the start"},
    {ActKind::button, "next", "Next place of the scanner"},
    {ActKind::button, "previous", "Previous place of the scanner"},
    {ActKind::button, "undo", "Take the last point back"},
}};

} // namespace

ActKind kindOf(Act act) {
    return kNames[static_cast<std::size_t>(act)].kind;
}

const char* nameOf(Act act) {
    return kNames[static_cast<std::size_t>(act)].name;
}

const char* titleOf(Act act) {
    return kNames[static_cast<std::size_t>(act)].title;
}

std::span<const Profile> profiles() {
    return kProfiles;
}

} // namespace input
