#include "render/warp/warp_pass.h"

#include "render/device.h"
#include "render/gpu_scene.h"
#include "spirv/warp_facets.comp.h"
#include "spirv/warp_mesh.comp.h"
#include "spirv/warp_points.comp.h"
#include "spirv/warp_splats.comp.h"

#include <algorithm>
#include <array>

namespace render {

namespace {

struct WarpRow {
    std::span<const std::uint32_t> code;
    std::uint32_t workgroupSize;
};

/// A processor runs a workgroup vector by vector, and starts each anew: one vector that loops is cheapest.
WarpRow rowOf(const Device& device, Warp warp) {
    const auto vectorWidth = static_cast<std::uint32_t>(device.subgroupSize());
    switch (warp) {
    case Warp::adaptive:
        return {kWarpFacetsCode, device.isProcessor() ? vectorWidth : 64};
    case Warp::mesh:
        return {kWarpMeshCode, device.isProcessor() ? vectorWidth : 64};
    case Warp::splats:
        return {kWarpSplatsCode, device.isProcessor() ? vectorWidth : 128};
    default:
        return {kWarpPointsCode, device.isProcessor() ? vectorWidth : 128};
    }
}

} // namespace

WarpPass makeWarpPass(const Device& device, Warp warp, VkDescriptorSetLayout pageLayout,
                      VkDescriptorSetLayout eyeLayout) {
    const WarpRow row = rowOf(device, warp);
    return {makeComputePipeline(device, row.code, std::array{pageLayout, eyeLayout}, sizeof(WarpConstants),
                                std::array{row.workgroupSize})};
}

void recordRun(VkCommandBuffer commands, VkPipelineLayout layout, const GpuScene& scene, const DrawRun& run, int width,
               int height) {
    const VkDescriptorSet page = scene.pageSet(run.page);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 1, &page, 0, nullptr);
    for (std::uint32_t done = 0; done < run.count; done += kMaxWorkgroups) {
        const WarpConstants constants{run.first + done, width, height};
        vkCmdPushConstants(commands, layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof constants, &constants);
        vkCmdDispatch(commands, std::min(run.count - done, kMaxWorkgroups), 1, 1);
    }
}

void recordRuns(VkCommandBuffer commands, VkPipelineLayout layout, const GpuScene& scene, std::span<const DrawRun> runs,
                int width, int height) {
    for (const DrawRun& run : runs)
        recordRun(commands, layout, scene, run, width, height);
}

void recordWarp(VkCommandBuffer commands, const WarpPasses& passes, const GpuScene& scene, VkDescriptorSet eyeSet,
                std::span<const DrawRun> runs, int width, int height) {
    const WarpPass* bound = nullptr;
    for (const DrawRun& run : runs) {
        const WarpPass& pass = passes[static_cast<std::size_t>(run.warp)];
        if (&pass != bound) {
            vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pass.pipeline.pipeline);
            vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pass.pipeline.layout, 1, 1, &eyeSet, 0,
                                    nullptr);
            bound = &pass;
        }
        recordRun(commands, pass.pipeline.layout, scene, run, width, height);
    }
}

} // namespace render
