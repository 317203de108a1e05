#include "render/resources.h"

#include "render/check.h"
#include "render/command_streams.h"
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
    case MemoryUse::hostFeeds:
        return {kMapped, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT};
    default:
        return {kMapped, VK_MEMORY_PROPERTY_HOST_CACHED_BIT};
    }
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
    const std::uint32_t best = device.memoryType(needs.memoryTypeBits, wish.wanted, wish.liked),
                        good = device.memoryType(needs.memoryTypeBits, wish.wanted, 0);
    allocate.memoryTypeIndex = best;
    VkDeviceMemory memory = VK_NULL_HANDLE;
    VkResult result = vkAllocateMemory(device, &allocate, nullptr, &memory);
    // Of a card's memory the processor may reach a small part alone, and others want that, too.
    if (result == VK_ERROR_OUT_OF_DEVICE_MEMORY && use == MemoryUse::hostFeeds && good != best) {
        allocate.memoryTypeIndex = good;
        result = vkAllocateMemory(device, &allocate, nullptr, &memory);
    }
    check(result);
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

Buffer upload(const Device& device, std::span<const std::byte> bytes, VkBufferUsageFlags usage) {
    Buffer target(device, bytes.size(), usage | VK_BUFFER_USAGE_TRANSFER_DST_BIT, MemoryUse::onDevice);
    if (target.mapped() != nullptr) {
        std::memcpy(target.mapped(), bytes.data(), bytes.size());
        return target;
    }
    const Buffer staging(device, bytes.size(), VK_BUFFER_USAGE_TRANSFER_SRC_BIT, MemoryUse::hostWrites);
    std::memcpy(staging.mapped(), bytes.data(), bytes.size());
    runAndWait(device, [&](VkCommandBuffer commands) {
        const VkBufferCopy all{0, 0, staging.size()};
        vkCmdCopyBuffer(commands, staging.handle(), target.handle(), 1, &all);
    });
    return target;
}

Buffer download(const Device& device, const Buffer& buffer, VkDeviceSize bytes) {
    assert(bytes <= buffer.size());
    Buffer copy(device, bytes, VK_BUFFER_USAGE_TRANSFER_DST_BIT, MemoryUse::hostReads);
    runAndWait(device, [&](VkCommandBuffer commands) {
        const VkBufferCopy first{0, 0, bytes};
        vkCmdCopyBuffer(commands, buffer.handle(), copy.handle(), 1, &first);
        record(commands, {VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_HOST_BIT,
                          VK_ACCESS_HOST_READ_BIT});
    });
    return copy;
}

BufferView makeTexelView(const Device& device, const Buffer& buffer, VkFormat format) {
    VkBufferViewCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO;
    info.buffer = buffer.handle();
    info.format = format;
    info.range = VK_WHOLE_SIZE;
    VkBufferView view = VK_NULL_HANDLE;
    check(vkCreateBufferView(device, &info, nullptr, &view));
    return {device, view};
}

} // namespace render
