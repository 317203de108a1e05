#include "render/timing.h"

#include "render/check.h"
#include "render/device.h"

#include <array>
#include <cassert>

namespace render {

namespace {

/// Some drivers write a timestamp into as many queries as the last render pass had views.
constexpr std::uint32_t kQueriesPerMark = 2;

} // namespace

StepTimer::StepTimer(const Device& device) : device_(device) {
    if (!device.hasTimestamps()) return;
    VkQueryPoolCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO;
    info.queryType = VK_QUERY_TYPE_TIMESTAMP;
    info.queryCount = kMaxMarks * kQueriesPerMark;
    VkQueryPool pool = VK_NULL_HANDLE;
    check(vkCreateQueryPool(device, &info, nullptr, &pool));
    pool_ = {device, pool};
    millisecondsPerTick_ = static_cast<double>(device.limits().timestampPeriod) * 1e-6;
}

void StepTimer::begin(VkCommandBuffer commands) {
    steps_.clear();
    written_ = 0;
    if (pool_ == VK_NULL_HANDLE) return;
    vkCmdResetQueryPool(commands, pool_, 0, kMaxMarks * kQueriesPerMark);
    write(commands);
}

void StepTimer::mark(VkCommandBuffer commands, const char* step, bool isOfBoth) {
    if (pool_ == VK_NULL_HANDLE) return;
    steps_.push_back({step, isOfBoth});
    write(commands);
}

void StepTimer::write(VkCommandBuffer commands) {
    assert(written_ < kMaxMarks);
    vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, pool_, written_ * kQueriesPerMark);
    ++written_;
}

void StepTimer::read(int eye, std::vector<StepTime>& times) const {
    std::array<std::uint64_t, kMaxMarks> ticks{};
    for (std::uint32_t i = 0; i < written_; ++i)
        check(vkGetQueryPoolResults(device_, pool_, i * kQueriesPerMark, 1, sizeof(std::uint64_t), &ticks[i],
                                    sizeof(std::uint64_t), VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT));
    for (std::size_t i = 0; i < steps_.size(); ++i)
        times.push_back({steps_[i].name, steps_[i].isOfBoth ? kWholeFrame : eye,
                         static_cast<double>(ticks[i + 1] - ticks[i]) * millisecondsPerTick_,
                         static_cast<double>(ticks[i]) * millisecondsPerTick_});
}

} // namespace render
