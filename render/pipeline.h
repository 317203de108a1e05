#pragma once
// Compute pipelines, and the sets of storage buffers they read and write.

#include "render/handle.h"

#include <cstdint>
#include <span>

namespace render {

class Device;
class Buffer;

struct ComputePipeline {
    PipelineLayout layout;
    Pipeline pipeline;
};

/// What every device allows in one direction of a dispatch.
inline constexpr std::uint32_t kMaxWorkgroups = 65535;

/// code: SPIR-V. specialisation: the constants 0, 1, ... of the shader.
ComputePipeline makeComputePipeline(const Device& device, std::span<const std::uint32_t> code,
                                    std::span<const VkDescriptorSetLayout> sets, std::uint32_t pushConstantBytes,
                                    std::span<const std::uint32_t> specialisation);

/// How a shader sees a buffer.
enum class Binding {
    storage, ///< as it is
    texels   ///< read only, as pairs of 32-bit numbers; software drivers gather these several times faster
};

/// Bindings 0, 1, ... of a set, for compute shaders.
DescriptorSetLayout makeSetLayout(const Device& device, std::span<const Binding> bindings);

/// Room for that many sets (at least one) with these bindings each.
DescriptorPool makeSetPool(const Device& device, std::size_t sets, std::span<const Binding> bindings);

/// A whole buffer at one binding; texels is its view where the binding wants texels.
struct Bound {
    VkBuffer buffer = VK_NULL_HANDLE;
    VkBufferView texels = VK_NULL_HANDLE;
};

/// A set with these buffers at bindings 0, 1, ... It lives as long as the pool.
VkDescriptorSet allocateSet(const Device& device, VkDescriptorPool pool, VkDescriptorSetLayout layout,
                            std::span<const Bound> buffers);

/// Puts another buffer at a binding of a set that nothing is using.
void rebind(const Device& device, VkDescriptorSet set, std::uint32_t binding, const Bound& buffer);

} // namespace render
