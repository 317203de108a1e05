#include "render/depth_pass.h"

#include "render/command_streams.h"
#include "render/device.h"
#include "render/shaders/shared/eye_depth.h"
#include "spirv/near_over_depth.comp.h"

#include <array>

namespace render {

namespace {

constexpr std::array kDepthBindings{Binding::storage, Binding::storage};

} // namespace

DepthPass makeDepthPass(const Device& device) {
    DepthPass pass;
    pass.layout = makeSetLayout(device, kDepthBindings);
    const std::uint32_t workgroupSize = device.workgroupSize(128);
    pass.pipeline = makeComputePipeline(device, kNearOverDepthCode, std::array<VkDescriptorSetLayout, 1>{pass.layout},
                                        sizeof(EyeDepthConstants), std::array{workgroupSize});
    return pass;
}

DepthBuffers makeDepthBuffers(const Device& device, const DepthPass& pass, const EyeTarget& target) {
    DepthBuffers buffers;
    buffers.nearOverDepth =
        Buffer(device, target.depths.size(), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT,
               MemoryUse::onDevice);
    buffers.pool = makeSetPool(device, 1, kDepthBindings);
    const std::array<Bound, kDepthBindings.size()> bound{{{target.depths.handle()}, {buffers.nearOverDepth.handle()}}};
    buffers.set = allocateSet(device, buffers.pool, pass.layout, bound);
    return buffers;
}

void recordDepth(VkCommandBuffer commands, const DepthPass& pass, const DepthBuffers& buffers, int width, int height,
                 float nearMetres) {
    record(commands, {kCompute, VK_ACCESS_SHADER_WRITE_BIT, kCompute, VK_ACCESS_SHADER_READ_BIT});
    const EyeDepthConstants constants{static_cast<std::uint32_t>(width), nearMetres};
    const VkPipelineLayout layout = pass.pipeline.layout;
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pass.pipeline.pipeline);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 1, &buffers.set, 0, nullptr);
    vkCmdPushConstants(commands, layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof constants, &constants);
    vkCmdDispatch(commands, static_cast<std::uint32_t>(height), 1, 1);
    record(commands,
           {kCompute, VK_ACCESS_SHADER_WRITE_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_READ_BIT});
}

} // namespace render
