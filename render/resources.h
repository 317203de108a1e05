#pragma once
// Buffers on the device, each with its own memory; where the processor can see that memory it stays mapped.

#include "render/handle.h"

#include <cstddef>
#include <span>

namespace render {

class Device;

enum class MemoryUse {
    onDevice,   ///< fast for the device; may or may not be mapped
    hostWrites, ///< mapped; written by the processor, in order, and read by the device once
    hostFeeds,  ///< the same, read often: on the device, where the processor can write there
    hostReads   ///< mapped; written by the device, once, and read by the processor
};

/// Mapped memory is coherent: no flush, no invalidation.
class Buffer {
  public:
    Buffer() = default;
    Buffer(const Device& device, VkDeviceSize size, VkBufferUsageFlags usage, MemoryUse use);
    Buffer(Buffer&&) noexcept = default;
    Buffer& operator=(Buffer&&) noexcept = default;

    VkBuffer handle() const { return buffer_; }
    VkDeviceSize size() const { return size_; }

    /// Null if the processor cannot see it.
    std::byte* mapped() const { return mapped_; }
    /// The whole buffer as values; it must be mapped.
    template <class T>
    std::span<T> as() const {
        return {reinterpret_cast<T*>(mapped_), static_cast<std::size_t>(size_) / sizeof(T)};
    }

  private:
    Memory memory_; // freed after the buffer
    BufferHandle buffer_;
    VkDeviceSize size_ = 0;
    std::byte* mapped_ = nullptr;
};

/// A buffer on the device that holds these bytes (at least one). Waits until they are there.
Buffer upload(const Device& device, std::span<const std::byte> bytes, VkBufferUsageFlags usage);

/// The first bytes of a buffer (usage: transfer source) that nothing is writing any more, where the processor can read
/// them. Waits until they are there.
Buffer download(const Device& device, const Buffer& buffer, VkDeviceSize bytes);

/// A texel: two 32-bit numbers. All that tiles hold is counted in texels: a vertex, a square or a colour is one, a
/// facet two.
inline constexpr std::size_t kTexelBytes = 8;

/// The whole buffer as texels, by default of two numbers. It must have at most limits().maxTexelBufferElements of them.
BufferView makeTexelView(const Device& device, const Buffer& buffer, VkFormat format = VK_FORMAT_R32G32_UINT);

} // namespace render
