#pragma once
// A finished eye is copied into somebody else's images; its depth becomes what displays' runtimes take first
// (shaders/shared/eye_output.h).

#include "render/output.h"
#include "render/pipeline.h"
#include "render/target.h"

namespace render {

/// One eye's; one for all frames in flight, as its picture is.
struct OutputCopy {
    VkBuffer colours = VK_NULL_HANDLE; ///< the target's
    ComputePipeline pipeline;
    Buffer nearOverDepth; ///< float per pixel; none where depth is not wanted
    DescriptorPool pool;
    VkDescriptorSet set = VK_NULL_HANDLE; ///< 0 depths, 1 near over depths
};

OutputCopy makeOutputCopy(const Device& device, const EyeTarget& target, bool hasDepth);

/// After all else that is done with the picture.
void recordCopy(VkCommandBuffer commands, const OutputCopy& copy, const PictureSize& picture, const PictureSize& image,
                const EyeOutput& output);

} // namespace render
