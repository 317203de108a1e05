#pragma once
// A window on the desk: pictures side by side, and a panel over them. It draws with OpenGL and knows nothing of the
// device that made the pictures, so that it neither waits for a headset's frames nor holds them up.

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

struct GLFWwindow;

namespace xr {

/// r | g << 8 | b << 16 per pixel, row by row; what stands above is not looked at.
struct WindowPicture {
    std::span<const std::uint32_t> pixels;
    int width = 0, height = 0;
};

/// Where a picture stands in the window, in pixels from its upper left corner.
struct WindowArea {
    double x = 0, y = 0, width = 0, height = 0;
};

/// All of it in the thread that runs main, as GLFW wants it; wake() alone may come from any.
class Window {
  public:
    /// Throws scene::Failure if there is no display, or none that draws.
    Window(const char* title, int width, int height);
    ~Window();
    Window(const Window&) = delete;
    Window& operator=(const Window&) = delete;

    GLFWwindow* handle() const { return window_; }
    bool isOpen() const;
    void close();
    /// It is there but cannot be seen any more.
    void hide();
    void toggleFullScreen();
    /// Pixels, 0 while it is an icon.
    int width() const;
    int height() const;

    /// Takes events as they come, waiting for the first no longer than so.
    void takeEvents(double seconds);
    /// Ends such a wait.
    static void wake();

    /// From now on shows these, side by side.
    void show(std::span<const WindowPicture> pictures);
    /// Where the picture with this number stands; nothing if it is not shown.
    WindowArea areaOf(std::size_t picture) const;
    /// Draws pictures and panel (Dear ImGui's calls) and brings them to the screen.
    void draw(const std::function<void()>& panel);
    /// Whether the panel, not the walk, is meant by the mouse or by the keys.
    bool panelHasMouse() const;
    /// area: x, y, width, height, in the window's own units.
    bool hasMouseIn(const std::array<float, 4>& area) const;
    bool panelHasKeys() const;

  private:
    struct Shown {
        unsigned texture = 0;
        int width = 0, height = 0;
    };
    void drawPictures() const;

    GLFWwindow* window_ = nullptr;
    std::vector<Shown> shown_;
    int placeX_ = 0, placeY_ = 0, placeWidth_ = 0, placeHeight_ = 0; ///< before it filled the screen
};

} // namespace xr
