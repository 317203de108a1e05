#pragma once
// Between batches of tiles, near to far: those behind what is drawn already are left out (shaders/shared/occlusion.h).

#include "render/pipeline.h"
#include "render/shaders/shared/occlusion.h"
#include "render/target.h"
#include "render/warp/warp_pass.h"

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace render {

struct OcclusionPass {
    ComputePipeline occluders, cull;
    std::uint32_t cullSize = 1; ///< of its workgroup
};

OcclusionPass makeOcclusionPass(const Device& device, VkDescriptorSetLayout eyeLayout);

/// Between two batches: sets the counts of what passes to none, finds what the z-buffers of the eyes hide, and has
/// `recordTest` pass on what is not, ready to be dispatched indirectly.
void recordPassing(VkCommandBuffer commands, const OcclusionPass& pass, std::span<const VkDescriptorSet> eyeSets,
                   const OccluderConstants& constants, const Buffer& passedRuns, std::span<const PassedRun> none,
                   const std::function<void()>& recordTest);

/// The runs of the first batch, which are taken off the front.
std::span<const DrawRun> takeBatch(std::span<const DrawRun>& runs);

/// What recordPassing begins a batch with.
std::vector<PassedRun> nonePassed(std::span<const DrawRun> batch, bool closesGaps);

/// Draws the runs, batch after batch. The z-buffer must be clear, and is finished behind the caller's next barrier.
/// closesGaps: what is behind gaps of one pixel within a surface is left out, too.
void recordWarpInBatches(VkCommandBuffer commands, const OcclusionPass& pass, const WarpPasses& warps,
                         const GpuScene& scene, VkDescriptorSet eyeSet, const EyeTarget& target,
                         std::span<const DrawRun> runs, int width, int height, bool closesGaps);

} // namespace render
