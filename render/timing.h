#pragma once
// How long the steps of a frame take, on the processor and on the device.

#include "render/handle.h"

#include <chrono>
#include <cstdint>
#include <vector>

namespace render {

class Device;

inline constexpr int kWholeFrame = -1; ///< a step that is not of one eye

struct StepTime {
    const char* step = ""; ///< its name, for reports
    int eye = kWholeFrame;
    double milliseconds = 0;
    double startMilliseconds = 0; ///< by a clock of the processor's, or of the device's: to compare within either
};

/// Runs work and appends how long it took.
template <class Work>
void timed(std::vector<StepTime>& times, const char* step, int eye, Work&& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    const std::chrono::duration<double, std::milli> passed = std::chrono::steady_clock::now() - start;
    const std::chrono::duration<double, std::milli> started = start.time_since_epoch();
    times.push_back({step, eye, passed.count(), started.count()});
}

/// Timestamps between the steps of one command buffer. Silent on devices without timestamps.
class StepTimer {
  public:
    explicit StepTimer(const Device& device);

    /// First of all commands.
    void begin(VkCommandBuffer commands);
    /// After a step and the barrier that ends it: without that barrier a device may write the time before the
    /// work is done. step must outlive the timer.
    void mark(VkCommandBuffer commands, const char* step) { mark(commands, step, false); }
    /// The same for a step that is not of one eye.
    void markBoth(VkCommandBuffer commands, const char* step) { mark(commands, step, true); }
    /// Appends the steps' times; only when the commands are known to have finished.
    void read(int eye, std::vector<StepTime>& times) const;

  private:
    static constexpr std::uint32_t kMaxMarks = 16;
    struct Step {
        const char* name = "";
        bool isOfBoth = false;
    };
    void mark(VkCommandBuffer commands, const char* step, bool isOfBoth);
    void write(VkCommandBuffer commands);

    VkDevice device_ = VK_NULL_HANDLE;
    QueryPool pool_;
    double millisecondsPerTick_ = 0;
    std::vector<Step> steps_;
    std::uint32_t written_ = 0;
};

} // namespace render
