#pragma once
// Handles that a device makes, each owned once and destroyed with its owner.

#include <volk.h>

#include <utility>

namespace render {

/// destroy points at volk's function pointer, which is known only at run time.
template <class T, auto* destroy>
class Handle {
  public:
    Handle() = default;
    Handle(VkDevice device, T handle) : device_(device), handle_(handle) {}
    Handle(Handle&& other) noexcept
        : device_(std::exchange(other.device_, {})), handle_(std::exchange(other.handle_, {})) {}
    Handle& operator=(Handle&& other) noexcept {
        std::swap(device_, other.device_);
        std::swap(handle_, other.handle_);
        return *this;
    }
    ~Handle() {
        if (handle_ != VK_NULL_HANDLE) (*destroy)(device_, handle_, nullptr);
    }
    // It goes where Vulkan wants its own. NOLINTNEXTLINE(google-explicit-constructor)
    operator T() const { return handle_; }
    const T* address() const { return &handle_; }

  private:
    VkDevice device_ = VK_NULL_HANDLE;
    T handle_ = VK_NULL_HANDLE;
};

using BufferHandle = Handle<VkBuffer, &vkDestroyBuffer>;
using BufferView = Handle<VkBufferView, &vkDestroyBufferView>;
using CommandPool = Handle<VkCommandPool, &vkDestroyCommandPool>;
using DescriptorPool = Handle<VkDescriptorPool, &vkDestroyDescriptorPool>;
using DescriptorSetLayout = Handle<VkDescriptorSetLayout, &vkDestroyDescriptorSetLayout>;
using Fence = Handle<VkFence, &vkDestroyFence>;
using Memory = Handle<VkDeviceMemory, &vkFreeMemory>;
using Pipeline = Handle<VkPipeline, &vkDestroyPipeline>;
using PipelineLayout = Handle<VkPipelineLayout, &vkDestroyPipelineLayout>;
using QueryPool = Handle<VkQueryPool, &vkDestroyQueryPool>;
using ShaderModule = Handle<VkShaderModule, &vkDestroyShaderModule>;

} // namespace render
