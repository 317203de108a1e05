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

/// code: SPIR-V. specialisation: the constants 0, 1, ... of the shader.
ComputePipeline makeComputePipeline(const Device& device, std::span<const std::uint32_t> code,
                                    std::span<const VkDescriptorSetLayout> sets,
                                    std::uint32_t pushConstantBytes,
                                    std::span<const std::uint32_t> specialisation);

/// bindings storage buffers, numbered from 0, for compute shaders.
DescriptorSetLayout makeStorageLayout(const Device& device, int bindings);

/// Room for that many sets with that many storage buffers in all (both at least one).
DescriptorPool makeStoragePool(const Device& device, std::size_t sets, std::size_t buffers);

/// A set whose binding i is the whole of buffers[i]. It lives as long as the pool.
VkDescriptorSet allocateStorageSet(const Device& device, VkDescriptorPool pool, VkDescriptorSetLayout layout,
                                   std::span<const VkBuffer> buffers);

} // namespace render
