#pragma once
// report.json: what was drawn, on what, and how long each step took.

#include "app/spread.h"

#include "render/gpu_scene.h"
#include "render/renderer.h"

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

namespace app {

/// From the first eye's culling until both are submitted; waiting left out.
double processorMilliseconds(const render::FrameStats& stats);
/// From the device's first step of that frame until its last one's end; 0 if it tells no times.
double deviceMilliseconds(const render::FrameStats& stats);

/// What of it is on the device; null if nothing is.
nlohmann::json toJson(const render::GpuCoverage* coverage);

/// Gathers the figures of a run's frames, however many.
class FrameReport {
  public:
    /// wallMilliseconds: from the call of draw until the frame was finished on the device.
    void add(const render::FrameStats& stats, double wallMilliseconds);

    /// What there is to say where frames were drawn and nothing of the scene was in any of them.
    std::optional<std::string> remark() const;

    /// Median, p95, p99 and maximum of every step, tiles and samples; `settings` (warp, size, eyes, ...) goes in as it
    /// is.
    nlohmann::json summarise(const render::Device& device, const render::GpuScene& scene,
                             nlohmann::json settings) const;

  private:
    std::map<std::string, Spread> milliseconds_; ///< by "cpu.cull.left" and so on
    Spread tested_, rejected_, drawn_, samples_, triangles_;
    bool hasDrawn_ = false; ///< a sample or a triangle
    std::size_t frames_ = 0, framesInOnePass_ = 0, framesStanding_ = 0;
    render::FrameStats last_;
};

} // namespace app
