#include "xr/window.h"

#include "scene/errors.h"

#include <algorithm>
#include <string>

#define GLFW_INCLUDE_GLEXT
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl2.h>
#include <imgui.h>

namespace xr {

namespace {

constexpr const char* kNoWindow = "check that DISPLAY or WAYLAND_DISPLAY names a screen, or walk without: --headless";

[[noreturn]] void failForWantOfWindow(const char* what) {
    const char* reason = nullptr;
    glfwGetError(&reason);
    throw scene::Failure(std::string(what) + (reason != nullptr ? std::string(" (") + reason + ")" : ""),
                         std::string("the desktop"), kNoWindow);
}

} // namespace

Window::Window(const char* title, int width, int height) {
    if (glfwInit() != GLFW_TRUE) failForWantOfWindow("no display answers");
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 2);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 0);
    window_ = glfwCreateWindow(width, height, title, nullptr, nullptr);
    if (window_ == nullptr) {
        // The reason must be read before glfwTerminate forgets it.
        try {
            failForWantOfWindow("no window can be opened");
        } catch (...) {
            glfwTerminate();
            throw;
        }
    }
    glfwMakeContextCurrent(window_);
    glfwSwapInterval(1);
    glfwSetInputMode(window_, GLFW_STICKY_KEYS, GLFW_TRUE); // a key hit between two looks counts
    glfwSetInputMode(window_, GLFW_STICKY_MOUSE_BUTTONS, GLFW_TRUE);
    IMGUI_CHECKVERSION();
    ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr; // leaves no file behind wherever it is started
    ImGui_ImplGlfw_InitForOpenGL(window_, true);
    ImGui_ImplOpenGL2_Init();
}

Window::~Window() {
    for (const Shown& shown : shown_)
        glDeleteTextures(1, &shown.texture);
    ImGui_ImplOpenGL2_Shutdown();
    ImGui_ImplGlfw_Shutdown();
    ImGui::DestroyContext();
    glfwDestroyWindow(window_);
    glfwTerminate();
}

bool Window::isOpen() const {
    return glfwWindowShouldClose(window_) == GLFW_FALSE;
}

void Window::close() {
    glfwSetWindowShouldClose(window_, GLFW_TRUE);
}

int Window::width() const {
    int width = 0, height = 0;
    glfwGetFramebufferSize(window_, &width, &height);
    return width;
}

int Window::height() const {
    int width = 0, height = 0;
    glfwGetFramebufferSize(window_, &width, &height);
    return height;
}

void Window::hide() {
    glfwHideWindow(window_);
    glfwPollEvents();
}

void Window::toggleFullScreen() {
    if (glfwGetWindowMonitor(window_) != nullptr) {
        glfwSetWindowMonitor(window_, nullptr, placeX_, placeY_, placeWidth_, placeHeight_, GLFW_DONT_CARE);
        return;
    }
    GLFWmonitor* const monitor = glfwGetPrimaryMonitor();
    const GLFWvidmode* const mode = monitor != nullptr ? glfwGetVideoMode(monitor) : nullptr;
    if (mode == nullptr) return;
    glfwGetWindowPos(window_, &placeX_, &placeY_);
    glfwGetWindowSize(window_, &placeWidth_, &placeHeight_);
    glfwSetWindowMonitor(window_, monitor, 0, 0, mode->width, mode->height, mode->refreshRate);
}

void Window::takeEvents(double seconds) {
    if (seconds > 0)
        glfwWaitEventsTimeout(seconds);
    else
        glfwPollEvents();
}

void Window::wake() {
    glfwPostEmptyEvent();
}

bool Window::panelHasMouse() const {
    return ImGui::GetIO().WantCaptureMouse;
}

bool Window::hasMouseIn(const std::array<float, 4>& area) const {
    double x = 0, y = 0;
    glfwGetCursorPos(window_, &x, &y);
    const auto [left, top, width, height] = area;
    return x >= left && x < left + width && y >= top && y < top + height;
}

bool Window::panelHasKeys() const {
    return ImGui::GetIO().WantTextInput;
}

void Window::show(std::span<const WindowPicture> pictures) {
    while (shown_.size() > pictures.size()) {
        glDeleteTextures(1, &shown_.back().texture);
        shown_.pop_back();
    }
    while (shown_.size() < pictures.size()) {
        Shown shown;
        glGenTextures(1, &shown.texture);
        shown_.push_back(shown);
    }
    for (std::size_t i = 0; i < pictures.size(); ++i) {
        const WindowPicture& picture = pictures[i];
        Shown& shown = shown_[i];
        glBindTexture(GL_TEXTURE_2D, shown.texture);
        if (shown.width != picture.width || shown.height != picture.height) {
            for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
                glTexParameteri(GL_TEXTURE_2D, filter, GL_LINEAR);
            for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
                glTexParameteri(GL_TEXTURE_2D, wrap, GL_CLAMP_TO_EDGE);
            glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB, picture.width, picture.height, 0, GL_RGBA, GL_UNSIGNED_BYTE,
                         picture.pixels.data());
            shown.width = picture.width, shown.height = picture.height;
        } else {
            glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, picture.width, picture.height, GL_RGBA, GL_UNSIGNED_BYTE,
                            picture.pixels.data());
        }
    }
}

WindowArea Window::areaOf(std::size_t picture) const {
    if (picture >= shown_.size() || shown_[picture].width == 0) return {};
    const Shown& shown = shown_[picture];
    const double columns = width() / static_cast<double>(shown_.size());
    const double scale = std::min(columns / shown.width, height() / static_cast<double>(shown.height));
    WindowArea area;
    area.width = shown.width * scale, area.height = shown.height * scale;
    area.x = columns * static_cast<double>(picture) + (columns - area.width) / 2;
    area.y = (height() - area.height) / 2;
    return area;
}

void Window::drawPictures() const {
    glMatrixMode(GL_PROJECTION);
    glLoadIdentity();
    glOrtho(0, width(), height(), 0, -1, 1);
    glMatrixMode(GL_MODELVIEW);
    glLoadIdentity();
    glEnable(GL_TEXTURE_2D);
    glColor3f(1, 1, 1);
    for (std::size_t i = 0; i < shown_.size(); ++i) {
        const WindowArea area = areaOf(i);
        glBindTexture(GL_TEXTURE_2D, shown_[i].texture);
        glBegin(GL_QUADS);
        for (const auto& [u, v] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
            glTexCoord2i(u, v);
            glVertex2d(area.x + u * area.width, area.y + v * area.height);
        }
        glEnd();
    }
    glDisable(GL_TEXTURE_2D);
}

void Window::draw(const std::function<void()>& panel) {
    ImGui_ImplOpenGL2_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    ImGui::NewFrame();
    panel();
    ImGui::Render();
    if (width() > 0 && height() > 0) {
        glViewport(0, 0, width(), height());
        glClearColor(0.08f, 0.08f, 0.09f, 1);
        glClear(GL_COLOR_BUFFER_BIT);
        drawPictures();
        ImGui_ImplOpenGL2_RenderDrawData(ImGui::GetDrawData());
    }
    glfwSwapBuffers(window_);
}

} // namespace xr
