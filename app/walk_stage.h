#pragma once
// All that stands between a scene and somebody's eyes: where the views come from, the device they are drawn on, and the
// renderer. Made anew, whole, when a headset comes or goes: its runtime may hang on another device.

#include "app/drawn_scene.h"
#include "app/walk_scene.h"

#include "input/actions.h"
#include "render/check.h"
#include "render/renderer.h"
#include "scene/scene.h"
#include "xr/desktop.h"
#include "xr/headless.h"
#include "xr/headset.h"

#include <array>
#include <memory>
#include <utility>

namespace app {

class WalkStage {
  public:
    /// A headset at an OpenXR runtime of this machine. Throws scene::Failure or xr::Lost.
    static WalkStage inHeadset(const DrawnScene& drawn, std::unique_ptr<xr::Runtime> runtime);
    /// At the desk; desktop must outlive it.
    static WalkStage atDesk(const DrawnScene& drawn, xr::Desktop& desktop);
    /// No display; along a path.
    static WalkStage headless(const DrawnScene& drawn, xr::Headless::Path path, const WalkOptions& options);

    xr::ViewSource& source() { return *source_; }
    const xr::ViewSource& source() const { return *source_; }
    /// Null if nobody wears one.
    xr::Headset* headset() { return headset_.get(); }
    input::Actions* actions() { return actions_.get(); }
    /// One that fits the source's pictures; made anew when they have changed their size. The headset's, and one for
    /// those at the desk.
    render::Renderer& rendererFor(const xr::ViewSource& source);

    /// Where there is no memory to draw (giveUpFinest); renderers are made anew. False if there is no coverage.
    bool giveUpFinestCoverage(const render::OutOfMemory& failure);

    /// Where no headset hangs on it: device, scene and renderers, all made anew; the source goes on as it is.
    void remakeDevice(const DrawnScene& drawn);

    /// True once for each device: what it draws is yet to be compiled.
    bool wasCold() { return std::exchange(isCold_, false); }

    const render::Device& device() const { return *device_; }
    const render::GpuScene& gpuScene() const { return *on_.images; }
    render::GpuScene& gpuScene() { return *on_.images; }
    const render::GpuCoverage* coverage() const { return on_.coverage.get(); }
    const scene::Coverage* hidingCoverage() const { return on_.hidingCoverage(); }
    const std::string& name() const { return name_; } ///< what the walker looks through
    /// Asks the headset for the offered rate that is nearest; 0: as it is. What is to be said if it is not that rate.
    std::string askForRate(double framesPerSecond);
    /// Of each eye's picture, what no lens shows.
    std::array<double, xr::kEyes> hiddenShares() const;
    /// Asks the headset to end its session; false if there is none to ask.
    bool requestEnd();

  private:
    void makeDevice(const DrawnScene& drawn, const render::DeviceMaker& maker);
    std::unique_ptr<render::Renderer> makeRenderer(const xr::ViewSource& source) const;

    // In the order in which they are made; the last goes first.
    std::string name_;
    std::unique_ptr<xr::Runtime> runtime_;
    std::unique_ptr<render::Device> device_;
    bool isCold_ = true;
    const scene::Scene* scene_ = nullptr; ///< what is brought to it
    DeviceScene on_;
    std::unique_ptr<xr::Headset> headset_;
    std::unique_ptr<input::Actions> actions_;
    std::unique_ptr<xr::Headless> headless_;
    xr::ViewSource* source_ = nullptr;
    std::array<std::unique_ptr<render::Renderer>, 2> renderers_; ///< the stage's own source, any other
};

} // namespace app
