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
    render::Device& device() { return *device_; }
    Headset& headset() { return *headset_; }

    /// Skipped frames are waited for; none if the session ends or is lost before.
    std::optional<Frame> nextDrawn();

  private:
    std::unique_ptr<Runtime> runtime_;
    std::unique_ptr<render::Device> device_;
    std::unique_ptr<Headset> headset_;
};

} // namespace xr
