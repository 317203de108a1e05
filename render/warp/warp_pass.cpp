#include "render/warp/warp_pass.h"

#include "render/command_streams.h"
#include "render/device.h"
#include "render/gpu_scene.h"
#include "render/shaders/shared/large_part.h"
#include "render/shaders/shared/occlusion.h"
#include "render/target.h"
#include "spirv/warp_facets.comp.h"
#include "spirv/warp_mesh.comp.h"
#include "spirv/warp_points.comp.h"
#include "spirv/warp_splats.comp.h"

#include <algorithm>
#include <array>
#include <cassert>

namespace render {

namespace {

struct WarpRow {
    std::span<const std::uint32_t> code;
    std::uint32_t workgroupSize;
    std::uint32_t largePixels = 0; ///< pieces of more are drawn by a subgroup; 0: none are
};

/// So many workgroups take parts from the list of large pieces. Most frames have none.
constexpr std::uint32_t kListedTogether = 1024;

/// Of workgroups a card does well with large ones, where tiles have that many squares; they have fewer facets
/// (docs/performance.md).
WarpRow rowOf(const Device& device, Warp warp) {
    switch (warp) {
    case Warp::adaptive:
        return {kWarpFacetsCode, device.workgroupSize(128), 24};
    case Warp::mesh:
        return {kWarpMeshCode, device.workgroupSize(256), 256};
    case Warp::splats:
        return {kWarpSplatsCode, device.workgroupSize(128)};
    default:
        return {kWarpPointsCode, device.workgroupSize(128)};
    }
}

} // namespace

WarpPass makeWarpPass(const Device& device, Warp warp, VkDescriptorSetLayout pageLayout,
                      VkDescriptorSetLayout eyeLayout) {
    constexpr std::uint32_t kSharingLanes = 8; // as in shaders/read_draw.glsl
    const WarpRow row = rowOf(device, warp);
    const bool sharesReading = device.isProcessor() && row.workgroupSize == kSharingLanes;
    const auto pipelineFor = [&](bool isPlain, std::uint32_t largePieces) {
        return makeComputePipeline(device, row.code, std::array{pageLayout, eyeLayout}, sizeof(WarpConstants),
                                   std::array{row.workgroupSize, std::uint32_t{sharesReading}, std::uint32_t{isPlain},
                                              largePieces, row.largePixels});
    };
    // A processor has no more workers than tiles.
    if (row.largePixels == 0 || device.isProcessor())
        return {pipelineFor(false, kDrawsLarge), pipelineFor(true, kDrawsLarge), {}};
    return {pipelineFor(false, kListsLarge), pipelineFor(true, kListsLarge), pipelineFor(false, kDrawsListed)};
}

void bindPage(VkCommandBuffer commands, VkPipelineLayout layout, const GpuScene& scene, const DrawRun& run) {
    const VkDescriptorSet page = scene.pageSet(run.page);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 1, &page, 0, nullptr);
}

void push(VkCommandBuffer commands, VkPipelineLayout layout, const WarpConstants& constants) {
    vkCmdPushConstants(commands, layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof constants, &constants);
}

void recordRun(VkCommandBuffer commands, VkPipelineLayout layout, const GpuScene& scene, const DrawRun& run, int width,
               int height) {
    bindPage(commands, layout, scene, run);
    for (std::uint32_t done = 0; done < run.count; done += kMaxWorkgroups) {
        push(commands, layout, {run.first + done, width, height, 0});
        vkCmdDispatch(commands, std::min(run.count - done, kMaxWorkgroups), 1, 1);
    }
}

void recordRuns(VkCommandBuffer commands, VkPipelineLayout layout, const GpuScene& scene, std::span<const DrawRun> runs,
                int width, int height) {
    for (const DrawRun& run : runs)
        recordRun(commands, layout, scene, run, width, height);
}

namespace {

/// Binds for each run the warp that draws it, and the eye's set, and lets `recordOne` do the rest.
template <class RecordOne>
void recordEach(VkCommandBuffer commands, const WarpPasses& passes, VkDescriptorSet eyeSet,
                std::span<const DrawRun> runs, RecordOne&& recordOne) {
    VkPipeline bound = VK_NULL_HANDLE;
    for (std::size_t i = 0; i < runs.size(); ++i) {
        const ComputePipeline& of = passes[static_cast<std::size_t>(runs[i].warp)].of(runs[i]);
        if (of.pipeline != bound) {
            vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, of.pipeline);
            vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, of.layout, 1, 1, &eyeSet, 0, nullptr);
            bound = of.pipeline;
        }
        recordOne(of.layout, i);
    }
}

} // namespace

void recordWarp(VkCommandBuffer commands, const WarpPasses& passes, const GpuScene& scene, VkDescriptorSet eyeSet,
                std::span<const DrawRun> runs, int width, int height) {
    recordEach(commands, passes, eyeSet, runs, [&](VkPipelineLayout layout, std::size_t i) {
        recordRun(commands, layout, scene, runs[i], width, height);
    });
}

void recordPassed(VkCommandBuffer commands, const WarpPasses& passes, const GpuScene& scene, VkDescriptorSet eyeSet,
                  const EyeTarget& target, std::span<const DrawRun> runs, int width, int height) {
    recordEach(commands, passes, eyeSet, runs, [&](VkPipelineLayout layout, std::size_t i) {
        assert(runs[i].count <= kMaxWorkgroups);
        bindPage(commands, layout, scene, runs[i]);
        push(commands, layout, {runs[i].first | kAmongPassed, width, height, 0});
        vkCmdDispatchIndirect(commands, target.passedRuns.handle(), i * sizeof(PassedRun));
    });
}

void recordListed(VkCommandBuffer commands, const WarpPasses& passes, const GpuScene& scene, VkDescriptorSet eyeSet,
                  std::span<const DrawRun> runs, int width, int height) {
    constexpr VkAccessFlags kBoth = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT;
    constexpr VkPipelineStageFlags kCompute = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT;
    bool isFirst = true;
    for (const DrawRun& run : runs) {
        const ComputePipeline& listed = passes[static_cast<std::size_t>(run.warp)].listed;
        const bool hasNone = run.isPlain && run.warp == Warp::mesh;
        if (listed.pipeline == VK_NULL_HANDLE || hasNone) continue;
        if (isFirst) record(commands, {kCompute, kBoth, kCompute, kBoth});
        isFirst = false;
        vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, listed.pipeline);
        vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, listed.layout, 1, 1, &eyeSet, 0, nullptr);
        bindPage(commands, listed.layout, scene, run);
        push(commands, listed.layout, {run.first, width, height, run.count});
        vkCmdDispatch(commands, kListedTogether, 1, 1);
    }
}

} // namespace render
