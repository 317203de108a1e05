#pragma once
// A screen without a monitor (Xvfb), and hands at its keys and mouse (xdotool).

#include <string>
#include <vector>

#include <sys/types.h>

#include <glm/glm.hpp>

namespace app {

/// Whether this machine has what it takes; a test skips where it has not.
bool canHaveScreen();

class Screen {
  public:
    /// Returns when it takes connections. Throws std::runtime_error.
    Screen();
    ~Screen();
    Screen(const Screen&) = delete;
    Screen& operator=(const Screen&) = delete;

    /// The command that runs another on this screen, in that folder, with settings of its own below config/ there.
    std::vector<std::string> around(const std::string& folder, const std::vector<std::string>& command) const;

    /// Waits until a window with that title is seen and gives it the keys; false if that takes too long.
    bool focus(const std::string& title);
    /// xdotool's own words: {"key", "F12"}. The window focused last is meant.
    void act(const std::vector<std::string>& words) const;
    /// What the window shows, as PNG. False if that does not work.
    bool grab(const std::string& file) const;
    /// Asks the window to close, as the button in its frame would.
    void closeWindow() const;

  private:
    pid_t server_ = 0;
    std::string display_; ///< :7
    std::string window_;
};

/// Where the last picture that a walk kept (F12) was seen from: metres, the capture's own coordinates; by what the walk
/// has said. Throws std::runtime_error if none was kept.
glm::dvec3 placeOfLastPicture(const std::string& said);

} // namespace app
