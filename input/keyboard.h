#pragma once
// Keyboard, mouse and gamepad at the desk, through GLFW's window.

#include "input/wants.h"

#include <glm/vec2.hpp>

#include <array>
#include <bitset>
#include <cstdint>
#include <span>

struct GLFWwindow;

namespace input {

/// What concerns the window and the pictures, not the walker's place.
enum class Command : std::uint8_t {
    panel,
    fullScreen,
    screenshot,
    video,
    viewWalker,
    viewLeft,
    viewBoth,
    warp,
    unseen,
    cameras,
    floorGrid,
    startHere,
    quit,
};
inline constexpr std::size_t kCommands = static_cast<std::size_t>(Command::quit) + 1;

/// What was said at the desk since it was last asked. The hands are left to whoever knows where the cursor points.
struct DeskSays {
    Wants wants;
    double tilt = 0; ///< radians the head was raised by
    std::bitset<kCommands> commands;
    bool said(Command command) const { return commands[static_cast<std::size_t>(command)]; }

    glm::dvec2 cursor{0};                                 ///< window's pixels
    bool picks = false, teleports = false, grabs = false; ///< the mouse's buttons, as wants.h has them
};

/// A line of help: "W A S D", "walk".
struct KeyHelp {
    const char* keys;
    const char* does;
};
std::span<const KeyHelp> keyHelp();

class Keyboard {
  public:
    explicit Keyboard(GLFWwindow* window) : window_(window) {}

    /// After GLFW has taken its events. Keys or mouse are passed over where a panel has them.
    DeskSays read(bool hasKeys, bool hasMouse);

  private:
    bool isDown(int key) const;
    /// True once for each time it is pressed.
    bool wasPressed(int key);
    void readKeys(DeskSays& says);
    void readMouse(DeskSays& says);
    void readGamepad(DeskSays& says);

    GLFWwindow* window_;
    std::bitset<512> before_;
    glm::dvec2 cursorBefore_{0};
    bool wasLooking_ = false;
    std::array<bool, 16> buttonsBefore_{};
};

} // namespace input
