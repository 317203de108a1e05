#include "render/pipeline.h"

#include "render/check.h"
#include "render/device.h"

#include <utility>

namespace render {

PipelineLayout makePipelineLayout(VkDevice device, std::span<const VkDescriptorSetLayout> sets,
                                  const VkPushConstantRange& constants) {
    VkPipelineLayoutCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO;
    info.setLayoutCount = static_cast<std::uint32_t>(sets.size());
    info.pSetLayouts = sets.data();
    info.pushConstantRangeCount = 1;
    info.pPushConstantRanges = &constants;
    VkPipelineLayout layout = VK_NULL_HANDLE;
    check(vkCreatePipelineLayout(device, &info, nullptr, &layout));
    return {device, layout};
}

ShaderModule makeShaderModule(VkDevice device, std::span<const std::uint32_t> code) {
    VkShaderModuleCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO;
    info.codeSize = code.size_bytes();
    info.pCode = code.data();
    VkShaderModule module = VK_NULL_HANDLE;
    check(vkCreateShaderModule(device, &info, nullptr, &module));
    return {device, module};
}

namespace {

VkDescriptorType typeOf(Binding binding) {
    switch (binding) {
    case Binding::texels:
        return VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
    case Binding::sampled:
        return VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    default:
        return VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    }
}

} // namespace

Specialisation::Specialisation(std::span<const std::uint32_t> values) {
    for (std::uint32_t i = 0; i < values.size(); ++i)
        entries_.push_back({i, i * static_cast<std::uint32_t>(sizeof(std::uint32_t)), sizeof(std::uint32_t)});
    info_ = {static_cast<std::uint32_t>(entries_.size()), entries_.data(), values.size_bytes(), values.data()};
}

CompiledPipeline::CompiledPipeline(VkDevice device, std::span<const std::uint32_t> code,
                                   std::span<const VkDescriptorSetLayout> sets, std::uint32_t pushConstantBytes,
                                   std::span<const std::uint32_t> specialisation)
    : device_(device), code_(code), specialisation_(specialisation.begin(), specialisation.end()),
      layout_(makePipelineLayout(device, sets, {VK_SHADER_STAGE_COMPUTE_BIT, 0, pushConstantBytes})) {}

VkPipeline CompiledPipeline::handle() const {
    std::call_once(once_, [this] {
        const Specialisation constants(specialisation_);
        const ShaderModule module = makeShaderModule(device_, code_);
        VkComputePipelineCreateInfo info{};
        info.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO;
        info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
        info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
        info.stage.module = module;
        info.stage.pName = "main";
        info.stage.pSpecializationInfo = constants.info();
        info.layout = layout_;
        VkPipeline pipeline = VK_NULL_HANDLE;
        check(vkCreateComputePipelines(device_, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline));
        pipeline_ = {device_, pipeline};
    });
    return pipeline_;
}

void bind(VkCommandBuffer commands, const ComputePipeline& pipeline) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.handle());
}

ComputePipeline PipelineStore::pipeline(VkDevice device, std::span<const std::uint32_t> code,
                                        std::span<const VkDescriptorSetLayout> sets, std::uint32_t pushConstantBytes,
                                        std::span<const std::uint32_t> specialisation) {
    const std::scoped_lock lock(mutex_);
    PipelineKey key{
        code.data(), {sets.begin(), sets.end()}, pushConstantBytes, {specialisation.begin(), specialisation.end()}};
    return ComputePipeline(
        pipelines_.try_emplace(std::move(key), device, code, sets, pushConstantBytes, specialisation).first->second);
}

VkDescriptorSetLayout PipelineStore::setLayout(VkDevice device, std::span<const Binding> bindings,
                                               VkShaderStageFlags stages) {
    const std::scoped_lock lock(mutex_);
    SetKey key{{bindings.begin(), bindings.end()}, stages};
    if (const auto found = setLayouts_.find(key); found != setLayouts_.end()) return found->second;

    std::vector<VkDescriptorSetLayoutBinding> all;
    for (std::size_t i = 0; i < bindings.size(); ++i)
        all.push_back({static_cast<std::uint32_t>(i), typeOf(bindings[i]), 1, stages, nullptr});
    VkDescriptorSetLayoutCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO;
    info.bindingCount = static_cast<std::uint32_t>(all.size());
    info.pBindings = all.data();
    VkDescriptorSetLayout layout = VK_NULL_HANDLE;
    check(vkCreateDescriptorSetLayout(device, &info, nullptr, &layout));
    return setLayouts_.emplace(std::move(key), DescriptorSetLayout{device, layout}).first->second;
}

ComputePipeline makeComputePipeline(const Device& device, std::span<const std::uint32_t> code,
                                    std::span<const VkDescriptorSetLayout> sets, std::uint32_t pushConstantBytes,
                                    std::span<const std::uint32_t> specialisation) {
    const ComputePipeline pipeline = device.pipelines().pipeline(device, code, sets, pushConstantBytes, specialisation);
    if (!device.isProcessor()) pipeline.handle();
    return pipeline;
}

VkDescriptorSetLayout makeSetLayout(const Device& device, std::span<const Binding> bindings,
                                    VkShaderStageFlags stages) {
    return device.pipelines().setLayout(device, bindings, stages);
}

DescriptorPool makeSetPool(const Device& device, std::size_t sets, std::span<const Binding> bindings) {
    std::vector<VkDescriptorPoolSize> sizes;
    for (const Binding binding : bindings)
        sizes.push_back({typeOf(binding), static_cast<std::uint32_t>(sets)});
    VkDescriptorPoolCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO;
    info.maxSets = static_cast<std::uint32_t>(sets);
    info.poolSizeCount = static_cast<std::uint32_t>(sizes.size());
    info.pPoolSizes = sizes.data();
    VkDescriptorPool pool = VK_NULL_HANDLE;
    check(vkCreateDescriptorPool(device, &info, nullptr, &pool));
    return {device, pool};
}

void rebind(const Device& device, VkDescriptorSet set, std::uint32_t binding, const Bound& bound) {
    const VkDescriptorBufferInfo whole{bound.buffer, 0, VK_WHOLE_SIZE};
    const VkDescriptorImageInfo image{bound.sampler, bound.image, bound.imageLayout};
    VkWriteDescriptorSet write{};
    write.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
    write.dstSet = set;
    write.dstBinding = binding;
    write.descriptorCount = 1;
    write.descriptorType = typeOf(bound.image != VK_NULL_HANDLE    ? Binding::sampled
                                  : bound.texels != VK_NULL_HANDLE ? Binding::texels
                                                                   : Binding::storage);
    write.pBufferInfo = &whole;
    write.pTexelBufferView = &bound.texels;
    write.pImageInfo = &image;
    vkUpdateDescriptorSets(device, 1, &write, 0, nullptr);
}

VkDescriptorSet allocateSet(const Device& device, VkDescriptorPool pool, VkDescriptorSetLayout layout,
                            std::span<const Bound> bound) {
    VkDescriptorSetAllocateInfo allocate{};
    allocate.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO;
    allocate.descriptorPool = pool;
    allocate.descriptorSetCount = 1;
    allocate.pSetLayouts = &layout;
    VkDescriptorSet set = VK_NULL_HANDLE;
    check(vkAllocateDescriptorSets(device, &allocate, &set));

    for (std::size_t i = 0; i < bound.size(); ++i)
        rebind(device, set, static_cast<std::uint32_t>(i), bound[i]);
    return set;
}

} // namespace render
