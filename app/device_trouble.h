#pragma once
// What a run does when its device fails it: a lost one is made anew, once; of a full one less is asked, step by step.
// Each time one line says so.

#include "render/check.h"
#include "render/quality.h"

#include <chrono>
#include <optional>

namespace render {
class Device;
} // namespace render

namespace app {

/// A device that is lost again so soon after it was made anew will be lost every time.
inline constexpr std::chrono::seconds kSoonLostAgain{30};

/// Whether a lost device is made anew.
class LossWatch {
  public:
    using Time = std::chrono::steady_clock::time_point;

    /// Says that the device was lost and is made anew. Throws scene::Failure if the one before was lost only just.
    void tell(const render::DeviceLost& loss, Time now = std::chrono::steady_clock::now());

  private:
    std::optional<Time> lastLoss_;
};

/// What is asked for no more since there was no memory for it.
struct GivenUp {
    bool blending = false, resolution = false;
};

/// What is left of a wish.
render::Quality without(render::Quality asked, const GivenUp& givenUp);

/// Gives up the next thing that takes memory in drawing so, and says what and why; false if there is none.
bool giveUpMore(const render::Quality& drawn, const render::OutOfMemory& failure, GivenUp& givenUp);

/// Says what of a quality this device cannot do, and what it does instead: eyes that were to be drawn in one pass are
/// drawn one by one, edges of polygons by fewer samples.
void sayWhatCannotBeHad(const render::Device& device, const render::Quality& quality, int eyes);

/// Says which better devices were passed over, and what they lack, if there are any.
void sayPassedOver(const render::Device& device);

} // namespace app
