#include "input/keyboard.h"

#include <algorithm>
#include <cmath>

#include <GLFW/glfw3.h>

namespace input {

namespace {

constexpr double kRadiansPerPixel = 0.003;
constexpr double kStickDeadZone = 0.15;

constexpr KeyHelp kHelp[] = {
    {"W A S D", "walk (Shift: faster)"},
    {"Space, C", "fly up, down"},
    {"Q, E, Left, Right", "turn"},
    {"right button, drag", "look around"},
    {"left button", "set a point (with Shift: a distance between two), on let go"},
    {"Z", "take the last point back"},
    {"middle button, T", "go where the mouse points, on let go"},
    {"Page Up, Page Down", "next, previous place of the scanner"},
    {"Home, R", "back to the start; recentre"},
    {"B", "walks through this scene begin here from now on"},
    {"+, -", "faster, slower"},
    {"[, ]", "smaller, larger world"},
    {"F, V", "higher, lower eyes"},
    {"1, 2, 3", "one eye, left eye, both"},
    {"M", "points or mesh"},
    {"U, K, G", "show or hide the unseen, cameras, floor grid"},
    {"Tab, F11", "panel; full screen"},
    {"F12, F9", "screenshot; start and end a video"},
    {"Esc", "leave"},
};

constexpr std::pair<int, Command> kCommandKeys[] = {
    {GLFW_KEY_TAB, Command::panel},   {GLFW_KEY_F11, Command::fullScreen}, {GLFW_KEY_F12, Command::screenshot},
    {GLFW_KEY_F9, Command::video},    {GLFW_KEY_1, Command::viewWalker},   {GLFW_KEY_2, Command::viewLeft},
    {GLFW_KEY_3, Command::viewBoth},  {GLFW_KEY_M, Command::warp},         {GLFW_KEY_U, Command::unseen},
    {GLFW_KEY_K, Command::cameras},   {GLFW_KEY_G, Command::floorGrid},    {GLFW_KEY_B, Command::startHere},
    {GLFW_KEY_ESCAPE, Command::quit},
};

double stick(float value) {
    const double v = static_cast<double>(value);
    return std::abs(v) > kStickDeadZone ? std::clamp(v, -1.0, 1.0) : 0.0;
}

} // namespace

std::span<const KeyHelp> keyHelp() {
    return kHelp;
}

bool Keyboard::isDown(int key) const {
    return glfwGetKey(window_, key) == GLFW_PRESS;
}

bool Keyboard::wasPressed(int key) {
    const auto i = static_cast<std::size_t>(key);
    const bool was = before_[i];
    before_[i] = isDown(key);
    return before_[i] && !was;
}

void Keyboard::readKeys(DeskSays& says) {
    Wants& wants = says.wants;
    const auto axis = [&](int more, int less) { return (isDown(more) ? 1.0 : 0.0) - (isDown(less) ? 1.0 : 0.0); };
    wants.move += glm::dvec2(axis(GLFW_KEY_D, GLFW_KEY_A), axis(GLFW_KEY_W, GLFW_KEY_S));
    wants.move.y += axis(GLFW_KEY_UP, GLFW_KEY_DOWN);
    wants.climb += axis(GLFW_KEY_SPACE, GLFW_KEY_C);
    wants.turn += axis(GLFW_KEY_E, GLFW_KEY_Q) + axis(GLFW_KEY_RIGHT, GLFW_KEY_LEFT);
    wants.hurries = isDown(GLFW_KEY_LEFT_SHIFT) || isDown(GLFW_KEY_RIGHT_SHIFT);

    const auto once = [&](int more, int less) {
        return (wasPressed(more) ? 1.0 : 0.0) - (wasPressed(less) ? 1.0 : 0.0);
    };
    wants.speedUp += once(GLFW_KEY_EQUAL, GLFW_KEY_MINUS) + once(GLFW_KEY_KP_ADD, GLFW_KEY_KP_SUBTRACT);
    wants.scaleUp += once(GLFW_KEY_RIGHT_BRACKET, GLFW_KEY_LEFT_BRACKET);
    wants.riseBy += 0.05 * once(GLFW_KEY_F, GLFW_KEY_V);
    wants.recentre = wasPressed(GLFW_KEY_R);
    wants.home = wasPressed(GLFW_KEY_HOME);
    wants.next = wasPressed(GLFW_KEY_PAGE_UP);
    wants.previous = wasPressed(GLFW_KEY_PAGE_DOWN);
    wants.undo = wasPressed(GLFW_KEY_Z);
    says.teleports = says.teleports || isDown(GLFW_KEY_T);
    for (const auto& [key, command] : kCommandKeys)
        if (wasPressed(key)) says.commands.set(static_cast<std::size_t>(command));
}

void Keyboard::readMouse(DeskSays& says) {
    const auto isHeld = [&](int button) { return glfwGetMouseButton(window_, button) == GLFW_PRESS; };
    says.picks = isHeld(GLFW_MOUSE_BUTTON_LEFT);
    says.teleports = says.teleports || isHeld(GLFW_MOUSE_BUTTON_MIDDLE);
    const bool looks = isHeld(GLFW_MOUSE_BUTTON_RIGHT);
    if (looks && wasLooking_) {
        const glm::dvec2 moved = says.cursor - cursorBefore_;
        says.wants.turnBy += moved.x * kRadiansPerPixel;
        says.tilt -= moved.y * kRadiansPerPixel;
    }
    wasLooking_ = looks;
}

void Keyboard::readGamepad(DeskSays& says) {
    GLFWgamepadstate pad{};
    if (glfwGetGamepadState(GLFW_JOYSTICK_1, &pad) != GLFW_TRUE) {
        buttonsBefore_.fill(false);
        return;
    }
    Wants& wants = says.wants;
    wants.move += glm::dvec2(stick(pad.axes[GLFW_GAMEPAD_AXIS_LEFT_X]), -stick(pad.axes[GLFW_GAMEPAD_AXIS_LEFT_Y]));
    wants.turn += stick(pad.axes[GLFW_GAMEPAD_AXIS_RIGHT_X]);
    // A trigger at rest is at -1.
    wants.climb += (static_cast<double>(pad.axes[GLFW_GAMEPAD_AXIS_RIGHT_TRIGGER]) -
                    static_cast<double>(pad.axes[GLFW_GAMEPAD_AXIS_LEFT_TRIGGER])) /
                   2;
    const auto once = [&](int button) {
        const auto i = static_cast<std::size_t>(button);
        const bool was = buttonsBefore_[i];
        buttonsBefore_[i] = pad.buttons[button] == GLFW_PRESS;
        return buttonsBefore_[i] && !was;
    };
    wants.hurries = wants.hurries || pad.buttons[GLFW_GAMEPAD_BUTTON_LEFT_THUMB] == GLFW_PRESS;
    wants.next = wants.next || once(GLFW_GAMEPAD_BUTTON_RIGHT_BUMPER);
    wants.previous = wants.previous || once(GLFW_GAMEPAD_BUTTON_LEFT_BUMPER);
    wants.home = wants.home || once(GLFW_GAMEPAD_BUTTON_BACK);
    wants.recentre = wants.recentre || once(GLFW_GAMEPAD_BUTTON_Y);
    wants.undo = wants.undo || once(GLFW_GAMEPAD_BUTTON_B);
    says.teleports = says.teleports || pad.buttons[GLFW_GAMEPAD_BUTTON_A] == GLFW_PRESS;
    says.picks = says.picks || pad.buttons[GLFW_GAMEPAD_BUTTON_X] == GLFW_PRESS;
    if (once(GLFW_GAMEPAD_BUTTON_START)) says.commands.set(static_cast<std::size_t>(Command::panel));
}

DeskSays Keyboard::read(bool hasKeys, bool hasMouse) {
    DeskSays says;
    glfwGetCursorPos(window_, &says.cursor.x, &says.cursor.y);
    if (hasKeys) readKeys(says);
    if (hasMouse)
        readMouse(says);
    else
        wasLooking_ = false;
    readGamepad(says);
    cursorBefore_ = says.cursor;
    return says;
}

} // namespace input
