#pragma once
// Draws an eye's overlay into its resolved picture.

#include "render/overlay_list.h"
#include "render/pipeline.h"
#include "render/resources.h"

namespace render {

struct OverlayPass {
    VkDescriptorSetLayout listLayout = VK_NULL_HANDLE; ///< 0 strokes, 1 entries, 2 bins
    ComputePipeline pipeline;
};

OverlayPass makeOverlayPass(const Device& device, VkDescriptorSetLayout eyeLayout);

/// One eye's list of one frame in flight, where the device reads it; mapped.
struct OverlayBuffers {
    Buffer strokes, entries, bins;
    DescriptorPool pool;
    VkDescriptorSet set = VK_NULL_HANDLE;
};

/// Room for any list of pictures of that size.
OverlayBuffers makeOverlayBuffers(const Device& device, const OverlayPass& pass, int width, int height);

/// The device must have finished with them.
void write(const OverlayList& list, const OverlayBuffers& buffers);

void recordOverlay(VkCommandBuffer commands, const OverlayPass& pass, const OverlayList& list,
                   const OverlayBuffers& buffers, VkDescriptorSet eyeSet);

} // namespace render
