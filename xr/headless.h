#pragma once
// Eyes without any display, led along a path: for servers, tests and measurements.

#include "xr/view_source.h"

#include <functional>
#include <optional>

namespace xr {

struct HeadlessOptions {
    int width = 640, height = 480;
    double fieldOfViewRadians = 1.2; ///< across
    double eyeDistanceMetres = 0.063;
    double framesPerSecond = 90; ///< how far the path's time goes on from frame to frame; frames follow at once
};

class Headless final : public ViewSource {
  public:
    /// trackingFromHead at so many seconds; nothing when the path has ended.
    using Path = std::function<std::optional<scene::Pose>(double seconds)>;
    Headless(Path path, const HeadlessOptions& options);

    int width() const override { return options_.width; }
    int height() const override { return options_.height; }
    Frame begin() override;
    void end(const Frame&) override {}

  private:
    Path path_;
    HeadlessOptions options_;
    scene::Camera camera_;
    std::int64_t frame_ = 0;
};

} // namespace xr
