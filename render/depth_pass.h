#pragma once
// An eye's depth in metres becomes what displays' runtimes take (shaders/shared/eye_depth.h).

#include "render/pipeline.h"
#include "render/target.h"

namespace render {

struct DepthPass {
    VkDescriptorSetLayout layout = VK_NULL_HANDLE; ///< 0 depths, 1 near over depths
    ComputePipeline pipeline;
};

DepthPass makeDepthPass(const Device& device);

/// One eye's; one for all frames in flight, as its depths are.
struct DepthBuffers {
    Buffer nearOverDepth; ///< float per pixel
    DescriptorPool pool;
    VkDescriptorSet set = VK_NULL_HANDLE;
};

DepthBuffers makeDepthBuffers(const Device& device, const DepthPass& pass, const EyeTarget& target);

/// After the depths were written, and before nearOverDepth is copied.
void recordDepth(VkCommandBuffer commands, const DepthPass& pass, const DepthBuffers& buffers, int width, int height,
                 float nearMetres);

} // namespace render
