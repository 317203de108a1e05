#include "render/resources.h"

#include "render/check.h"
#include "render/device.h"

#include <cassert>
#include <cstring>

namespace render {

namespace {

struct MemoryWish {
    VkMemoryPropertyFlags wanted, liked;
};

MemoryWish wishFor(MemoryUse use) {
    constexpr VkMemoryPropertyFlags kMapped =
        VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    switch (use) {
    case MemoryUse::onDevice:
        return {0, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT};
    case MemoryUse::hostWrites:
        return {kMapped, 0};
    default:
        return {kMapped, VK_MEMORY_PROPERTY_HOST_CACHED_BIT};
    }
}

/// Copies and waits; only for what happens once.
void copyAndWait(const Device& device, const Buffer& from, const Buffer& to) {
    VkCommandPoolCreateInfo poolInfo{};
    poolInfo.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
    poolInfo.queueFamilyIndex = device.queueFamily();
    VkCommandPool rawPool = VK_NULL_HANDLE;
    check(vkCreateCommandPool(device, &poolInfo, nullptr, &rawPool));
    const CommandPool pool(device, rawPool);

    VkCommandBufferAllocateInfo allocate{};
    allocate.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
    allocate.commandPool = pool;
    allocate.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
    allocate.commandBufferCount = 1;
    VkCommandBuffer commands = VK_NULL_HANDLE;
    check(vkAllocateCommandBuffers(device, &allocate, &commands));

    VkCommandBufferBeginInfo begin{};
    begin.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
    begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    check(vkBeginCommandBuffer(commands, &begin));
    const VkBufferCopy all{0, 0, from.size()};
    vkCmdCopyBuffer(commands, from.handle(), to.handle(), 1, &all);
    check(vkEndCommandBuffer(commands));

    VkSubmitInfo submit{};
    submit.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &commands;
    check(vkQueueSubmit(device.queue(0), 1, &submit, VK_NULL_HANDLE));
    check(vkQueueWaitIdle(device.queue(0)));
}

} // namespace

Buffer::Buffer(const Device& device, VkDeviceSize size, VkBufferUsageFlags usage, MemoryUse use) : size_(size) {
    assert(size > 0);
    VkBufferCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
    info.size = size;
    info.usage = usage;
    VkBuffer buffer = VK_NULL_HANDLE;
    check(vkCreateBuffer(device, &info, nullptr, &buffer));
    buffer_ = {device, buffer};

    VkMemoryRequirements needs{};
    vkGetBufferMemoryRequirements(device, buffer, &needs);
    const MemoryWish wish = wishFor(use);
    VkMemoryAllocateInfo allocate{};
    allocate.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
    allocate.allocationSize = needs.size;
    allocate.memoryTypeIndex = device.memoryType(needs.memoryTypeBits, wish.wanted, wish.liked);
    VkDeviceMemory memory = VK_NULL_HANDLE;
    check(vkAllocateMemory(device, &allocate, nullptr, &memory));
    memory_ = {device, memory};
    check(vkBindBufferMemory(device, buffer, memory, 0));

    constexpr VkMemoryPropertyFlags kMapped =
        VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    if ((device.memoryFlags(allocate.memoryTypeIndex) & kMapped) == kMapped) {
        void* address = nullptr;
        check(vkMapMemory(device, memory, 0, VK_WHOLE_SIZE, 0, &address));
        mapped_ = static_cast<std::byte*>(address);
    }
}

Buffer uploadTexels(const Device& device, std::span<const std::byte> bytes) {
    Buffer target(device, bytes.size(), VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                  MemoryUse::onDevice);
    if (target.mapped() != nullptr) {
        std::memcpy(target.mapped(), bytes.data(), bytes.size());
        return target;
    }
    const Buffer staging(device, bytes.size(), VK_BUFFER_USAGE_TRANSFER_SRC_BIT, MemoryUse::hostWrites);
    std::memcpy(staging.mapped(), bytes.data(), bytes.size());
    copyAndWait(device, staging, target);
    return target;
}

BufferView makeTexelView(const Device& device, const Buffer& buffer) {
    VkBufferViewCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO;
    info.buffer = buffer.handle();
    info.format = VK_FORMAT_R32G32_UINT;
    info.range = VK_WHOLE_SIZE;
    VkBufferView view = VK_NULL_HANDLE;
    check(vkCreateBufferView(device, &info, nullptr, &view));
    return {device, view};
}

} // namespace render
