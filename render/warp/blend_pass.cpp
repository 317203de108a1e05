#include "render/warp/blend_pass.h"

#include "render/command_streams.h"
#include "render/device.h"
#include "render/gpu_scene.h"
#include "render/warp/warp_pass.h"
#include "spirv/blend.comp.h"
#include "spirv/blend_resolve.comp.h"

#include <algorithm>

namespace render {

namespace {

constexpr std::array kBlendBindings{Binding::storage, Binding::storage};
constexpr std::size_t kSumBytes = 16; // of a pixel

constexpr Barrier kAfterClearedSums{VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
                                    VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                                    VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT};

} // namespace

BlendPass makeBlendPass(const Device& device, VkDescriptorSetLayout pageLayout, VkDescriptorSetLayout eyeLayout,
                        std::uint32_t mostPoints) {
    constexpr std::uint32_t kMostAddedInTurn = 48; // of the widest spots, 33 pixels across
    const std::uint32_t size = device.workgroupSize(128);
    const std::uint32_t addSize = togetherFor(device, 128, mostPoints, kMostAddedInTurn);
    BlendPass pass;
    pass.layout = makeSetLayout(device, kBlendBindings);
    pass.add = makeComputePipeline(device, kBlendCode,
                                   std::array<VkDescriptorSetLayout, 3>{pageLayout, eyeLayout, pass.layout},
                                   sizeof(WarpConstants), std::array{addSize});
    pass.resolve =
        makeComputePipeline(device, kBlendResolveCode, std::array<VkDescriptorSetLayout, 2>{eyeLayout, pass.layout},
                            sizeof(BlendResolveConstants), std::array{size});
    return pass;
}

BlendTarget makeBlendTarget(const Device& device, const BlendPass& pass, std::size_t pixels, std::size_t maxDraws) {
    const std::size_t sumBytes = kSumBytes * pixels;
    const std::size_t drawBytes = std::max<std::size_t>(maxDraws, 1) * sizeof(BlendDraw);
    requireRange(device, sumBytes, "the sums of the blended warp", "choose a smaller image or another --warp");
    requireRange(device, drawBytes, "the list of tiles", "build the scene with larger tiles");
    BlendTarget target;
    target.pixels = pixels;
    target.mostDraws = maxDraws;
    target.sums = Buffer(device, sumBytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                         MemoryUse::onDevice);
    target.pool = makeSetPool(device, kFramesInFlight, kBlendBindings);
    for (std::size_t frame = 0; frame < kFramesInFlight; ++frame) {
        target.draws[frame] = Buffer(device, drawBytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, MemoryUse::hostFeeds);
        const std::array<Bound, kBlendBindings.size()> bound{{{target.draws[frame].handle()}, {target.sums.handle()}}};
        target.sets[frame] = allocateSet(device, target.pool, pass.layout, bound);
    }
    return target;
}

void recordBlend(VkCommandBuffer commands, const BlendPass& pass, const GpuScene& scene, VkDescriptorSet eyeSet,
                 const BlendTarget& target, std::size_t slot, std::span<const DrawRun> runs, int width, int height) {
    vkCmdFillBuffer(commands, target.sums.handle(), 0,
                    kSumBytes * static_cast<VkDeviceSize>(width) * static_cast<VkDeviceSize>(height), 0);
    record(commands, kAfterClearedSums);
    const VkPipelineLayout layout = pass.add.layout();
    const std::array sets{eyeSet, target.sets[slot]};
    bind(commands, pass.add);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 1, 2, sets.data(), 0, nullptr);
    recordRuns(commands, layout, scene, runs, width, height);
}

void recordBlendResolve(VkCommandBuffer commands, const BlendPass& pass, VkDescriptorSet eyeSet,
                        const BlendTarget& target, std::size_t slot, int width, int height) {
    const VkPipelineLayout layout = pass.resolve.layout();
    const std::array sets{eyeSet, target.sets[slot]};
    const BlendResolveConstants constants{width};
    bind(commands, pass.resolve);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 2, sets.data(), 0, nullptr);
    vkCmdPushConstants(commands, layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof constants, &constants);
    vkCmdDispatch(commands, static_cast<std::uint32_t>(height), 1, 1);
}

} // namespace render
