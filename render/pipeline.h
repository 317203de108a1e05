#pragma once
// Compute pipelines, and the sets of buffers and images that shaders read and write.

#include "render/handle.h"

#include <compare>
#include <cstdint>
#include <map>
#include <mutex>
#include <span>
#include <vector>

namespace render {

class Device;
class Buffer;

/// What a pipeline is made of, and the pipeline once somebody has wanted it. Belongs to the device.
class CompiledPipeline {
  public:
    CompiledPipeline(VkDevice device, std::span<const std::uint32_t> code, std::span<const VkDescriptorSetLayout> sets,
                     std::uint32_t pushConstantBytes, std::span<const std::uint32_t> specialisation);
    VkPipelineLayout layout() const { return layout_; }
    /// Compiled by now. For any number of threads.
    VkPipeline handle() const;

  private:
    VkDevice device_;
    std::span<const std::uint32_t> code_;
    std::vector<std::uint32_t> specialisation_;
    PipelineLayout layout_;
    mutable std::once_flag once_;
    mutable Pipeline pipeline_;
};

/// One of the device's pipelines, or none.
class ComputePipeline {
  public:
    ComputePipeline() = default;
    explicit ComputePipeline(const CompiledPipeline& of) : of_(&of) {}
    explicit operator bool() const { return of_ != nullptr; }
    VkPipelineLayout layout() const { return of_->layout(); }
    VkPipeline handle() const { return of_->handle(); }
    friend bool operator==(const ComputePipeline&, const ComputePipeline&) = default;

  private:
    const CompiledPipeline* of_ = nullptr;
};

void bind(VkCommandBuffer commands, const ComputePipeline& pipeline);

/// What every device allows in one direction of a dispatch.
inline constexpr std::uint32_t kMaxWorkgroups = 65535;

/// code: SPIR-V, which stays where it is. specialisation: the constants 0, 1, ... of the shader. Whoever asks for the
/// same again is given the same: drivers take a while to compile. A card's has compiled when this returns, lest a frame
/// wait for it; a driver for the processor, which compiles what it runs when it first runs it, however early it was
/// asked, does not begin before the pipeline is bound: few runs bind all that a renderer might need.
ComputePipeline makeComputePipeline(const Device& device, std::span<const std::uint32_t> code,
                                    std::span<const VkDescriptorSetLayout> sets, std::uint32_t pushConstantBytes,
                                    std::span<const std::uint32_t> specialisation);

/// The constants 0, 1, ... of a shader; values must outlive it.
class Specialisation {
  public:
    explicit Specialisation(std::span<const std::uint32_t> values);
    Specialisation(const Specialisation&) = delete;
    Specialisation& operator=(const Specialisation&) = delete;
    const VkSpecializationInfo* info() const { return &info_; }

  private:
    std::vector<VkSpecializationMapEntry> entries_;
    VkSpecializationInfo info_{};
};

/// How a shader sees a buffer.
enum class Binding {
    storage, ///< as it is
    texels,  ///< read only, as pairs of 32-bit numbers; software drivers gather these several times faster
    sampled  ///< an image through a sampler
};

/// Bindings 0, 1, ... of a set, for these shaders. Belongs to the device; the same again for whoever asks for it again.
VkDescriptorSetLayout makeSetLayout(const Device& device, std::span<const Binding> bindings,
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

PipelineLayout makePipelineLayout(VkDevice device, std::span<const VkDescriptorSetLayout> sets,
                                  const VkPushConstantRange& constants);

ShaderModule makeShaderModule(VkDevice device, std::span<const std::uint32_t> code);

/// What makeComputePipeline and makeSetLayout have made for a device. For any number of threads.
class PipelineStore {
  public:
    ComputePipeline pipeline(VkDevice device, std::span<const std::uint32_t> code,
                             std::span<const VkDescriptorSetLayout> sets, std::uint32_t pushConstantBytes,
                             std::span<const std::uint32_t> specialisation);
    VkDescriptorSetLayout setLayout(VkDevice device, std::span<const Binding> bindings, VkShaderStageFlags stages);

  private:
    struct PipelineKey {
        const std::uint32_t* code;
        std::vector<VkDescriptorSetLayout> sets;
        std::uint32_t pushConstantBytes;
        std::vector<std::uint32_t> specialisation;
        auto operator<=>(const PipelineKey&) const = default;
    };
    struct SetKey {
        std::vector<Binding> bindings;
        VkShaderStageFlags stages;
        auto operator<=>(const SetKey&) const = default;
    };
    std::mutex mutex_;
    std::map<SetKey, DescriptorSetLayout> setLayouts_;
    std::map<PipelineKey, CompiledPipeline> pipelines_;
};

} // namespace render
