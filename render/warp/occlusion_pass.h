#pragma once
// Between batches of tiles, near to far: those behind what is drawn already are left out (shaders/shared/occlusion.h).

#include "render/pipeline.h"
#include "render/target.h"
#include "render/warp/warp_pass.h"

#include <cstdint>
#include <span>

namespace render {

struct OcclusionPass {
    ComputePipeline occluders, cull;
    std::uint32_t cullSize = 1; ///< of its workgroup
};

OcclusionPass makeOcclusionPass(const Device& device, VkDescriptorSetLayout eyeLayout);

/// Draws the runs, batch after batch. The z-buffer must be clear, and is finished behind the caller's next barrier.
/// closesGaps: what is behind gaps of one or two pixels is left out, too.
void recordWarpInBatches(VkCommandBuffer commands, const OcclusionPass& pass, const WarpPasses& warps,
                         const GpuScene& scene, VkDescriptorSet eyeSet, const EyeTarget& target,
                         std::span<const DrawRun> runs, int width, int height, bool closesGaps);

} // namespace render
