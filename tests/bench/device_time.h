#pragma once
// What a step of a frame took on the device.

#include "render/renderer.h"

#include <cstring>

namespace render {

/// Milliseconds, of both eyes together.
inline double deviceTimeOf(const FrameStats& stats, const char* step) {
    double sum = 0;
    for (const StepTime& time : stats.gpu)
        if (std::strcmp(time.step, step) == 0) sum += time.milliseconds;
    return sum;
}

} // namespace render
