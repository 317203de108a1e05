#pragma once
// All that stands between a scene and somebody's eyes: where the views come from, the device they are drawn on, and the
// renderer. Made anew, whole, when a headset comes back: its runtime may hang on another device.

#include "app/walk_scene.h"

#include "render/renderer.h"
#include "scene/scene.h"
#include "xr/headless.h"
#include "xr/headset.h"

#include <memory>

namespace app {

class WalkStage {
  public:
    /// A headset at the OpenXR runtime of this machine. Throws scene::Failure if there is none.
    static WalkStage inHeadset(const scene::Scene& scene);
    /// No display; along a path.
    static WalkStage headless(const scene::Scene& scene, xr::Headless::Path path, const WalkOptions& options);

    xr::ViewSource& source() { return *source_; }
    render::Renderer& renderer() { return *renderer_; }
    const render::Device& device() const { return *device_; }
    const render::GpuScene& gpuScene() const { return *gpuScene_; }
    const std::string& name() const { return name_; } ///< what the walker looks through
    /// Asks the headset to end its session; false if there is none to ask.
    bool requestEnd();

  private:
    void makeRenderer(const scene::Scene& scene);

    // In the order in which they are made; the last goes first.
    std::string name_;
    std::unique_ptr<xr::Runtime> runtime_;
    std::unique_ptr<render::Device> device_;
    std::unique_ptr<render::GpuScene> gpuScene_;
    std::unique_ptr<xr::ViewSource> source_;
    xr::Headset* headset_ = nullptr;
    std::unique_ptr<render::Renderer> renderer_;
};

} // namespace app
