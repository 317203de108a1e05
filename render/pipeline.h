#pragma once
// Compute pipelines, and the sets of buffers and images that shaders read and write.

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
    texels,  ///< read only, as pairs of 32-bit numbers; software drivers gather these several times faster
    sampled  ///< an image through a sampler
};

/// Bindings 0, 1, ... of a set, for these shaders.
DescriptorSetLayout makeSetLayout(const Device& device, std::span<const Binding> bindings,
                                  VkShaderStageFlags stages = VK_SHADER_STAGE_COMPUTE_BIT);

/// Room for that many sets (at least one) with these bindings each.
DescriptorPool makeSetPool(const Device& device, std::size_t sets, std::span<const Binding> bindings);

/// A whole buffer at one binding, texels being its view where the binding wants texels; or an image that is ready to be
/// sampled.
struct Bound {
    VkBuffer buffer = VK_NULL_HANDLE;
    VkBufferView texels = VK_NULL_HANDLE;
    VkImageView image = VK_NULL_HANDLE;
    VkSampler sampler = VK_NULL_HANDLE;
    VkImageLayout imageLayout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
};

/// A set with these at bindings 0, 1, ... It lives as long as the pool.
VkDescriptorSet allocateSet(const Device& device, VkDescriptorPool pool, VkDescriptorSetLayout layout,
                            std::span<const Bound> bound);

/// Puts another at a binding of a set that nothing is using.
void rebind(const Device& device, VkDescriptorSet set, std::uint32_t binding, const Bound& bound);

PipelineLayout makePipelineLayout(const Device& device, std::span<const VkDescriptorSetLayout> sets,
                                  const VkPushConstantRange& constants);

ShaderModule makeShaderModule(const Device& device, std::span<const std::uint32_t> code);

} // namespace render
