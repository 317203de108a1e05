#include "render/post/mark_pass.h"

#include "render/device.h"
#include "render/shaders/shared/mark.h"
#include "spirv/mark_unmeasured.comp.h"

#include <array>

namespace render {

ComputePipeline makeMarkPass(const Device& device, VkDescriptorSetLayout eyeLayout) {
    return makeComputePipeline(device, kMarkUnmeasuredCode, std::array{eyeLayout}, sizeof(MarkConstants),
                               std::array{device.workgroupSize(128)});
}

void recordMark(VkCommandBuffer commands, const ComputePipeline& pass, VkDescriptorSet eyeSet, int width, int height) {
    const MarkConstants constants{static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height)};
    bind(commands, pass);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pass.layout(), 0, 1, &eyeSet, 0, nullptr);
    vkCmdPushConstants(commands, pass.layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof constants, &constants);
    vkCmdDispatch(commands, constants.height, 1, 1);
}

} // namespace render
