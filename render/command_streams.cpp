#include "render/command_streams.h"

#include "render/check.h"

#include <limits>

namespace render {

namespace {

/// The fence of a frame that was not submitted is never signalled: waiting for it would be for ever. Without memory to
/// submit, the device is as good as lost.
void checkSubmitted(VkResult result, std::source_location asked = std::source_location::current()) {
    const bool isFull = result == VK_ERROR_OUT_OF_HOST_MEMORY || result == VK_ERROR_OUT_OF_DEVICE_MEMORY;
    check(isFull ? VK_ERROR_DEVICE_LOST : result, asked);
}

} // namespace

Recorder makeRecorder(const Device& device) {
    VkCommandPoolCreateInfo poolInfo{};
    poolInfo.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
    poolInfo.flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT;
    poolInfo.queueFamilyIndex = device.queueFamily();
    VkCommandPool pool = VK_NULL_HANDLE;
    check(vkCreateCommandPool(device, &poolInfo, nullptr, &pool));
    Recorder recorder{{device, pool}, VK_NULL_HANDLE};
    VkCommandBufferAllocateInfo allocate{};
    allocate.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
    allocate.commandPool = pool;
    allocate.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
    allocate.commandBufferCount = 1;
    check(vkAllocateCommandBuffers(device, &allocate, &recorder.commands));
    return recorder;
}

Fence makeFence(const Device& device, VkFenceCreateFlags flags) {
    VkFenceCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO;
    info.flags = flags;
    VkFence fence = VK_NULL_HANDLE;
    check(vkCreateFence(device, &info, nullptr, &fence));
    return {device, fence};
}

CommandStreams::CommandStreams(const Device& device, int eyes) : device_(device) {
    for (Slot& slot : slots_) {
        slot.finished = makeFence(device, VK_FENCE_CREATE_SIGNALED_BIT);
        for (int eye = 0; eye < eyes; ++eye)
            slot.eyes.push_back(makeRecorder(device));
    }
}

CommandStreams::~CommandStreams() {
    // A lost device answers with an error here; there is nothing left to save then.
    static_cast<void>(vkDeviceWaitIdle(device_));
}

void CommandStreams::wait(std::size_t slot) {
    check(vkWaitForFences(device_, 1, slots_[slot].finished.address(), VK_TRUE,
                          std::numeric_limits<std::uint64_t>::max()));
}

void CommandStreams::waitForAll() {
    for (std::size_t slot = 0; slot < kFramesInFlight; ++slot)
        wait(slot);
}

bool CommandStreams::isDone(std::size_t slot) const {
    const VkResult status = vkGetFenceStatus(device_, slots_[slot].finished);
    if (status == VK_NOT_READY) return false;
    check(status);
    return true;
}

VkCommandBuffer CommandStreams::begin(std::size_t slot, int eye) {
    const Recorder& recorder = slots_[slot].eyes[static_cast<std::size_t>(eye)];
    check(vkResetCommandPool(device_, recorder.pool, 0));
    VkCommandBufferBeginInfo info{};
    info.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
    info.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    check(vkBeginCommandBuffer(recorder.commands, &info));
    return recorder.commands;
}

void CommandStreams::submit(std::size_t slot) {
    std::vector<VkCommandBuffer> commands;
    for (const Recorder& recorder : slots_[slot].eyes) {
        check(vkEndCommandBuffer(recorder.commands));
        commands.push_back(recorder.commands);
    }
    check(vkResetFences(device_, 1, slots_[slot].finished.address()));
    VkSubmitInfo info{};
    info.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
    info.commandBufferCount = static_cast<std::uint32_t>(commands.size());
    info.pCommandBuffers = commands.data();
    checkSubmitted(vkQueueSubmit(device_.queue(), 1, &info, slots_[slot].finished));
}

void runAndWait(const Device& device, const std::function<void(VkCommandBuffer)>& recordCommands) {
    const Recorder recorder = makeRecorder(device);
    const VkCommandBuffer commands = recorder.commands;

    VkCommandBufferBeginInfo begin{};
    begin.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
    begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    check(vkBeginCommandBuffer(commands, &begin));
    recordCommands(commands);
    check(vkEndCommandBuffer(commands));

    VkSubmitInfo submit{};
    submit.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &commands;
    check(vkQueueSubmit(device.queue(), 1, &submit, VK_NULL_HANDLE));
    check(vkQueueWaitIdle(device.queue()));
}

void record(VkCommandBuffer commands, const Barrier& barrier) {
    VkMemoryBarrier memory{};
    memory.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
    memory.srcAccessMask = barrier.fromAccess;
    memory.dstAccessMask = barrier.toAccess;
    vkCmdPipelineBarrier(commands, barrier.fromStages, barrier.toStages, 0, 1, &memory, 0, nullptr, 0, nullptr);
}

} // namespace render
