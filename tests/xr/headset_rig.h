#pragma once
// Runtime, device and headset within the test itself, in Monado; and the environment that leads there.

#include "tests/xr/monado.h"

#include "render/device.h"
#include "xr/headset.h"

#include <memory>
#include <optional>

namespace xr {

/// From here on this process finds Monado and nothing else.
void enter(const Monado& monado);

class HeadsetRig {
  public:
    /// Throws as Runtime, Device and Headset do.
    HeadsetRig();

    Runtime& runtime() { return *runtime_; }
    const render::Device& device() const { return *device_; }
    Headset& headset() { return *headset_; }

    /// Draws a scene for the frame's eyes into the frame's images, with so many pixels along a side for one of theirs,
    /// and says in the frame what was drawn; checks there that colours are the eyes' own, and depth theirs as near / z,
    /// where the runtime takes depth.
    void drawAndCheck(Frame& frame, double scale = 1);

    /// Skipped frames are waited for; none if the session ends or is lost before.
    std::optional<Frame> nextDrawn();

  private:
    std::unique_ptr<Runtime> runtime_;
    std::unique_ptr<render::Device> device_;
    std::unique_ptr<Headset> headset_;
};

} // namespace xr
