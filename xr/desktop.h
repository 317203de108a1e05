#pragma once
// The desk as a source of views: one eye, or both, of someone who sits before a window. The window itself lives in
// another thread (xr/window.h) and says here what it wants.

#include "xr/view_source.h"

#include <chrono>
#include <condition_variable>
#include <mutex>

namespace xr {

struct DesktopOptions {
    double fieldOfViewRadians = 1.05; ///< from top to bottom
    double eyeHeightMetres = 1.6;
    double eyeDistanceMetres = 0.063;
    int width = 640, height = 480, eyes = 1;
};

/// begin() waits until a picture is asked for, so that nothing is drawn that nobody will see.
class Desktop final : public ViewSource {
  public:
    explicit Desktop(const DesktopOptions& options);

    int width() const override { return now_.width; }
    int height() const override { return now_.height; }
    int eyes() const override { return now_.eyes; }
    Frame begin() override;
    void end(const Frame&) override {}

    // From any thread; each holds from the next begin on.

    /// Pixels of an eye, at least 1; 1 or 2 eyes; metres above the floor.
    void resize(int width, int height, int eyes, double eyeHeightMetres);
    /// One more picture will be shown.
    void ask();
    /// Raises what the head looks at; it cannot look behind itself over its own top.
    void tilt(double radians);
    /// begin() says that it is over.
    void close();

  private:
    DesktopOptions now_; ///< of the thread that draws
    std::mutex mutex_;
    std::condition_variable changed_;
    DesktopOptions wanted_;
    double tilt_ = 0;
    bool isAsked_ = true, isClosed_ = false;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

} // namespace xr
