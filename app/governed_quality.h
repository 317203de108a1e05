#pragma once
// The quality of a walk's frames under the governor: what the walker asked for, less what must be given up.

#include "app/frame_report.h"
#include "app/governor.h"

#include <optional>
#include <vector>

namespace app {

class GovernedQuality {
  public:
    explicit GovernedQuality(double framesPerSecond) : framesPerSecond_(framesPerSecond) {}

    /// How to draw the renderer's frame number `frame`. Whoever asks for something else starts at the top again, and
    /// the report is of the newest that was asked for.
    const render::Quality& next(const render::Quality& asked, std::uint64_t frame);

    /// One of each kind of what may be drawn from now on: warps, and less than the full resolution.
    std::vector<render::Quality> ways() const;

    /// The newest figures. isProcessor: the device is this machine's own processor, so that both work in turns.
    void tell(const render::FrameStats& stats, bool isProcessor);

    /// What has been given up now; empty if nothing.
    std::string given() const;
    nlohmann::json report() const;

  private:
    double framesPerSecond_;
    nlohmann::json asked_; ///< its knobs, to notice a change
    std::vector<Rung> ladder_;
    std::optional<Governor> governor_;
    std::optional<std::uint64_t> told_;
};

} // namespace app
