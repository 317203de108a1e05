#include "render/command_streams.h"

#include "render/check.h"

#include <limits>

namespace render {

namespace {

/// A frame of which one eye was submitted and the other was not is never finished: waiting for it would be for ever.
/// Without memory to submit, the device is as good as lost.
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
    for (std::vector<Stream>& streams : slots_)
        for (int eye = 0; eye < eyes; ++eye) {
            Stream stream{makeRecorder(device), makeFence(device, VK_FENCE_CREATE_SIGNALED_BIT), {}};
            if (eye > 0 && !device.eyesShareQueue()) {
                VkSemaphoreCreateInfo semaphoreInfo{};
                semaphoreInfo.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO;
                VkSemaphore semaphore = VK_NULL_HANDLE;
                check(vkCreateSemaphore(device, &semaphoreInfo, nullptr, &semaphore));
                stream.joined = {device, semaphore};
            }
            streams.push_back(std::move(stream));
        }
}

CommandStreams::~CommandStreams() {
    // A lost device answers with an error here; there is nothing left to save then.
    static_cast<void>(vkDeviceWaitIdle(device_));
}

void CommandStreams::wait(std::size_t slot) {
    for (const Stream& stream : slots_[slot])
        check(
            vkWaitForFences(device_, 1, stream.finished.address(), VK_TRUE, std::numeric_limits<std::uint64_t>::max()));
}

void CommandStreams::waitForAll() {
    for (std::size_t slot = 0; slot < kFramesInFlight; ++slot)
        wait(slot);
}

bool CommandStreams::isDone(std::size_t slot) const {
    for (const Stream& stream : slots_[slot]) {
        const VkResult status = vkGetFenceStatus(device_, stream.finished);
        if (status == VK_NOT_READY) return false;
        check(status);
    }
    return true;
}

VkCommandBuffer CommandStreams::begin(std::size_t slot, int eye) {
    const Stream& stream = slots_[slot][static_cast<std::size_t>(eye)];
    check(vkResetCommandPool(device_, stream.recorder.pool, 0));
    VkCommandBufferBeginInfo info{};
    info.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
    info.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    check(vkBeginCommandBuffer(stream.recorder.commands, &info));
    return stream.recorder.commands;
}

void CommandStreams::submit(std::size_t slot, EyeQueues queues) {
    std::vector<Stream>& streams = slots_[slot];
    const bool joins = streams.size() > 1 && !device_.eyesShareQueue() && queues == EyeQueues::own;
    std::vector<VkSemaphore> joined;
    for (const Stream& stream : streams) // all before the first is submitted: what fails here leaves nothing half done
        check(vkEndCommandBuffer(stream.recorder.commands));
    for (std::size_t eye = 0; eye < streams.size(); ++eye) {
        const Stream& stream = streams[eye];
        check(vkResetFences(device_, 1, stream.finished.address()));
        VkSubmitInfo info{};
        info.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
        info.commandBufferCount = 1;
        info.pCommandBuffers = &stream.recorder.commands;
        if (joins && eye > 0) {
            info.signalSemaphoreCount = 1;
            info.pSignalSemaphores = stream.joined.address();
            joined.push_back(stream.joined);
        }
        // The first eye has finished when it has waited for the others, too: then the semaphores may be used again.
        const bool isFirst = joins && eye == 0;
        const int queue = queues == EyeQueues::own ? static_cast<int>(eye) : 0;
        checkSubmitted(
            vkQueueSubmit(device_.queue(queue), 1, &info, isFirst ? VK_NULL_HANDLE : VkFence(stream.finished)));
    }
    if (!joins) return;
    const std::vector<VkPipelineStageFlags> stages(joined.size(), VK_PIPELINE_STAGE_ALL_COMMANDS_BIT);
    VkSubmitInfo wait{};
    wait.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
    wait.waitSemaphoreCount = static_cast<std::uint32_t>(joined.size());
    wait.pWaitSemaphores = joined.data();
    wait.pWaitDstStageMask = stages.data();
    checkSubmitted(vkQueueSubmit(device_.queue(0), 1, &wait, streams[0].finished));
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
    check(vkQueueSubmit(device.queue(0), 1, &submit, VK_NULL_HANDLE));
    check(vkQueueWaitIdle(device.queue(0)));
}

void record(VkCommandBuffer commands, const Barrier& barrier) {
    VkMemoryBarrier memory{};
    memory.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
    memory.srcAccessMask = barrier.fromAccess;
    memory.dstAccessMask = barrier.toAccess;
    vkCmdPipelineBarrier(commands, barrier.fromStages, barrier.toStages, 0, 1, &memory, 0, nullptr, 0, nullptr);
}

} // namespace render
