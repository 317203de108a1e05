#include "render/post/rescale.h"

#include "render/device.h"
#include "render/shaders/shared/rescale.h"
#include "spirv/enlarge.comp.h"
#include "spirv/rescale.comp.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

namespace render {

namespace {

constexpr std::array kRescaleBindings{Binding::texels, Binding::texels, Binding::storage, Binding::storage};

} // namespace

RescalePass makeRescalePass(const Device& device) {
    RescalePass pass;
    pass.layout = makeSetLayout(device, kRescaleBindings);
    const std::uint32_t workgroupSize = device.workgroupSize(128);
    const std::array<VkDescriptorSetLayout, 1> sets{pass.layout};
    pass.any = makeComputePipeline(device, kRescaleCode, sets, sizeof(RescaleConstants), std::array{workgroupSize});
    const auto enlarging = [&](std::uint32_t byPlaces) {
        return makeComputePipeline(device, kEnlargeCode, sets, sizeof(RescaleConstants),
                                   std::array{workgroupSize, byPlaces});
    };
    pass.enlarge = enlarging(0);
    pass.enlargeByPlaces = enlarging(1);
    return pass;
}

ScaledTarget makeScaledTarget(const Device& device, const RescalePass& pass, VkDescriptorSetLayout eyeLayout,
                              const EyeTarget& eye, int width, int height) {
    ScaledTarget scaled;
    scaled.target = makeEyeTarget(device, eyeLayout, width, height);
    scaled.pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    scaled.pool = makeSetPool(device, 1, kRescaleBindings);
    scaled.colourTexels = makeTexelView(device, scaled.target.colours, VK_FORMAT_R32_UINT);
    scaled.depthTexels = makeTexelView(device, scaled.target.depths, VK_FORMAT_R32_SFLOAT);
    const std::array<Bound, kRescaleBindings.size()> bound{{{scaled.target.colours.handle(), scaled.colourTexels},
                                                            {scaled.target.depths.handle(), scaled.depthTexels},
                                                            {eye.colours.handle()},
                                                            {eye.depths.handle()}}};
    scaled.set = allocateSet(device, scaled.pool, pass.layout, bound);
    return scaled;
}

int scaledSide(int pixels, double scale) {
    return std::max(1, static_cast<int>(std::lround(pixels * scale)));
}

void recordRescale(VkCommandBuffer commands, const RescalePass& pass, const ScaledTarget& from, const Rescaling& sizes,
                   const std::optional<PlaceSteps>& places) {
    const RescaleConstants constants{static_cast<std::uint32_t>(sizes.fromWidth),
                                     static_cast<std::uint32_t>(sizes.fromHeight),
                                     static_cast<std::uint32_t>(sizes.toWidth),
                                     static_cast<std::uint32_t>(sizes.toHeight), places.value_or(PlaceSteps{})};
    const bool isEnlarged = sizes.isEnlarging();
    assert(isEnlarged || !places);
    const ComputePipeline& pipeline = !isEnlarged ? pass.any : places ? pass.enlargeByPlaces : pass.enlarge;
    const VkPipelineLayout layout = pipeline.layout();
    bind(commands, pipeline);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 1, &from.set, 0, nullptr);
    vkCmdPushConstants(commands, layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof constants, &constants);
    const std::uint32_t rows = isEnlarged ? kEnlargedRows : 1;
    vkCmdDispatch(commands, (constants.toHeight + rows - 1) / rows, 1, 1);
}

} // namespace render
