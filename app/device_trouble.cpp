#include "app/device_trouble.h"

#include "app/say.h"
#include "render/device.h"
#include "render/warp/polygon_pass.h"
#include "render/warp/stereo_pass.h"

#include <string>

namespace app {

void LossWatch::tell(const render::DeviceLost& loss, Time now) {
    const std::optional<Time> before = std::exchange(lastLoss_, now);
    if (before && now - *before < kSoonLostAgain)
        throw scene::Failure("the device was lost again right after it had been made anew (" +
                                 std::string(loss.what()) + ")",
                             std::string("Vulkan"), "see the system's log for what stops it");
    say("the device was lost, and is made anew; what was being drawn is drawn again (" + std::string(loss.what()) +
        ")");
}

render::Quality without(render::Quality asked, const GivenUp& givenUp) {
    if (givenUp.blending) asked.isBlended = false;
    if (givenUp.resolution) asked.resolutionScale = 1;
    return asked;
}

bool giveUpMore(const render::Quality& drawn, const render::OutOfMemory& failure, GivenUp& givenUp) {
    const std::string why = " (" + std::string(failure.what()) + ")";
    if (drawn.isBlended && !givenUp.blending) {
        givenUp.blending = true;
        say("the device has no memory to blend: drawn without" + why);
        return true;
    }
    if (drawn.resolutionScale != 1 && !givenUp.resolution) {
        givenUp.resolution = true;
        say("the device has no memory for another resolution: drawn in the pictures' own" + why);
        return true;
    }
    return false;
}

void sayWhatCannotBeHad(const render::Device& device, const render::Quality& quality, int eyes) {
    const std::string why = quality.isOnePass ? render::whyNotInOnePass(device, quality, eyes) : "";
    if (!why.empty()) say("--one-pass: " + why);
    const int samples = render::edgeSamplesOf(device, quality.edgeSamples);
    if (samples < quality.edgeSamples)
        say("--edge-samples: " + std::to_string(samples) + " of a pixel, the most up to " +
            std::to_string(quality.edgeSamples) + " that " + device.name() + " has");
}

void sayPassedOver(const render::Device& device) {
    if (device.passedOver().empty()) return;
    say("drawn on " + device.name() + ": " + device.passedOver());
}

} // namespace app
