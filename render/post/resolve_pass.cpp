#include "render/post/resolve_pass.h"

#include "render/command_streams.h"
#include "render/device.h"

#include "spirv/fill_holes.comp.h"
#include "spirv/hole_words.comp.h"
#include "spirv/resolve.comp.h"

#include <array>
#include <cassert>

namespace render {

namespace {

constexpr VkPipelineStageFlags kCompute = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT;
constexpr Barrier kBetween{kCompute, VK_ACCESS_SHADER_WRITE_BIT, kCompute,
                           VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT};

std::uint32_t workgroupSize(const Device& device, std::uint32_t onCards) {
    return device.isProcessor() ? static_cast<std::uint32_t>(device.subgroupSize()) : onCards;
}

void dispatch(VkCommandBuffer commands, const ComputePipeline& pipeline, VkDescriptorSet eyeSet,
              const ResolveConstants& constants, int rows) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.pipeline);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.layout, 0, 1, &eyeSet, 0, nullptr);
    vkCmdPushConstants(commands, pipeline.layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof constants, &constants);
    vkCmdDispatch(commands, static_cast<std::uint32_t>(rows), 1, 1);
}

} // namespace

ResolvePass makeResolvePass(const Device& device, VkDescriptorSetLayout eyeLayout) {
    const std::array<VkDescriptorSetLayout, 1> sets{eyeLayout};
    const std::uint32_t size = workgroupSize(device, 128);
    constexpr std::uint32_t kPlain = 0, kListing = 1;
    return {makeComputePipeline(device, kHoleWordsCode, sets, sizeof(ResolveConstants),
                                std::array{workgroupSize(device, 32)}),
            makeComputePipeline(device, kResolveCode, sets, sizeof(ResolveConstants), std::array{size, kPlain}),
            makeComputePipeline(device, kResolveCode, sets, sizeof(ResolveConstants), std::array{size, kListing}),
            makeComputePipeline(device, kFillHolesCode, sets, sizeof(ResolveConstants),
                                std::array{workgroupSize(device, 64)})};
}

void recordResolve(VkCommandBuffer commands, const ResolvePass& pass, VkDescriptorSet eyeSet, int width, int height,
                   const HoleFill& holes) {
    assert(holes.radius <= kMostHoleRadius);
    const ResolveConstants constants{width, height, holes};
    if (holes.radius <= 0) {
        dispatch(commands, pass.plain, eyeSet, constants, height);
        return;
    }
    dispatch(commands, pass.holeWords, eyeSet, constants, height);
    record(commands, kBetween);
    dispatch(commands, pass.listing, eyeSet, constants, height);
    record(commands, kBetween);
    dispatch(commands, pass.filling, eyeSet, constants, height);
}

} // namespace render
