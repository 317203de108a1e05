#include "render/warp/occlusion_pass.h"

#include "render/command_streams.h"
#include "render/device.h"
#include "render/gpu_scene.h"
#include "spirv/occluders.comp.h"
#include "spirv/occlusion.comp.h"

#include <algorithm>
#include <array>
#include <vector>

namespace render {

namespace {

constexpr Barrier kAfterOccludersWarp{kCompute, kRead | kWrite, kCompute, kRead | kWrite};
constexpr Barrier kBeforeSizes{kCompute | VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT,
                               kRead | kWrite | VK_ACCESS_INDIRECT_COMMAND_READ_BIT, kTransfer,
                               VK_ACCESS_TRANSFER_WRITE_BIT};
constexpr Barrier kAfterOccluders{kCompute | kTransfer, kRead | kWrite | VK_ACCESS_TRANSFER_WRITE_BIT, kCompute,
                                  kRead | kWrite};
constexpr Barrier kAfterCull{kCompute, kRead | kWrite, kCompute | VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT,
                             kRead | kWrite | VK_ACCESS_INDIRECT_COMMAND_READ_BIT};

} // namespace

OcclusionPass makeOcclusionPass(const Device& device, VkDescriptorSetLayout eyeLayout) {
    OcclusionPass pass;
    pass.cullSize = device.workgroupSize(64);
    const std::array<VkDescriptorSetLayout, 1> sets{eyeLayout};
    const std::array size{pass.cullSize};
    pass.occluders = makeComputePipeline(device, kOccludersCode, sets, sizeof(OccluderConstants), size);
    pass.cull = makeComputePipeline(device, kOcclusionCode, sets, sizeof(OcclusionConstants), size);
    return pass;
}

void recordPassing(VkCommandBuffer commands, const OcclusionPass& pass, std::span<const VkDescriptorSet> eyeSets,
                   const OccluderConstants& constants, const Buffer& passedRuns, std::span<const PassedRun> none,
                   const std::function<void()>& recordTest) {
    record(commands, kBeforeSizes);
    vkCmdUpdateBuffer(commands, passedRuns.handle(), 0, none.size_bytes(), none.data());
    record(commands, kAfterOccludersWarp);
    const VkPipelineLayout layout = pass.occluders.layout();
    bind(commands, pass.occluders);
    vkCmdPushConstants(commands, layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof constants, &constants);
    for (const VkDescriptorSet& eyeSet : eyeSets) {
        vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 1, &eyeSet, 0, nullptr);
        vkCmdDispatch(commands, static_cast<std::uint32_t>(occludersAlong(constants.height)), 1, 1);
    }
    record(commands, kAfterOccluders);
    recordTest();
    record(commands, kAfterCull);
}

std::span<const DrawRun> takeBatch(std::span<const DrawRun>& runs) {
    const auto end =
        std::find_if(runs.begin(), runs.end(), [&](const DrawRun& run) { return run.batch != runs.front().batch; });
    const std::span<const DrawRun> batch = runs.first(static_cast<std::size_t>(end - runs.begin()));
    runs = runs.subspan(batch.size());
    return batch;
}

std::vector<PassedRun> nonePassed(std::span<const DrawRun> batch, bool closesGaps) {
    std::vector<PassedRun> none;
    for (const DrawRun& run : batch)
        none.push_back({0, 1, 1,
                        run.first | (run.warp == Warp::splats ? kSplatRun : 0) |
                            (closesGaps || run.warp == Warp::adaptive ? kWholeRun : 0)});
    return none;
}

void recordWarpInBatches(VkCommandBuffer commands, const OcclusionPass& pass, const WarpPasses& warps,
                         const GpuScene& scene, VkDescriptorSet eyeSet, const EyeTarget& target,
                         std::span<const DrawRun> runs, int width, int height, bool closesGaps) {
    bool hasLooked = false;
    const std::span<const DrawRun> all = runs;
    while (!runs.empty()) {
        const std::span<const DrawRun> now = takeBatch(runs);
        if (now.front().batch == 0 || now.size() > kMostTestedRuns) {
            recordWarp(commands, warps, scene, eyeSet, now, width, height);
            continue;
        }
        const std::vector<PassedRun> none = nonePassed(now, closesGaps);
        const std::uint32_t tiles = now.back().first + now.back().count - now.front().first;
        const OccluderConstants occluders{width, height, closesGaps ? 1 : 0, hasLooked ? 1 : 0};
        hasLooked = true;
        recordPassing(commands, pass, std::span(&eyeSet, 1), occluders, target.passedRuns, none, [&] {
            const VkPipelineLayout layout = pass.cull.layout();
            bind(commands, pass.cull);
            vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 1, &eyeSet, 0, nullptr);
            const std::uint32_t atOnce = kMaxWorkgroups * pass.cullSize;
            for (std::uint32_t done = 0; done < tiles; done += atOnce) {
                const OcclusionConstants constants{now[0].first + done, std::min(tiles - done, atOnce), width, height};
                vkCmdPushConstants(commands, layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof constants, &constants);
                vkCmdDispatch(commands, (constants.count + pass.cullSize - 1) / pass.cullSize, 1, 1);
            }
        });
        recordPassed(commands, warps, scene, eyeSet, target, now, width, height);
    }
    recordListed(commands, warps, scene, eyeSet, target, all, width, height);
}

} // namespace render
