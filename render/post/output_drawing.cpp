#include "render/post/output_drawing.h"

#include "render/device.h"
#include "render/shaders/shared/eye_output.h"
#include "spirv/output.frag.h"
#include "spirv/output.vert.h"

#include <algorithm>

namespace render {

namespace {

constexpr std::array kPictureBindings{Binding::storage, Binding::storage};

RenderPass makeOutputRenderPass(const Device& device, const OutputKind& kind) {
    constexpr VkPipelineStageFlags kDrawing =
        VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT | VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT |
        VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT;
    constexpr VkAccessFlags kWrites = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT |
                                      VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_READ_BIT |
                                      VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
    // All of what is drawn over is written.
    const auto written = [](VkFormat format, VkImageLayout layout) {
        return attachmentOf(format, VK_SAMPLE_COUNT_1_BIT, VK_ATTACHMENT_LOAD_OP_DONT_CARE, layout);
    };
    RasterTargets targets{.colour = written(kind.format, kind.layout)};
    if (kind.hasDepth) targets.depth = written(VK_FORMAT_D32_SFLOAT, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL);
    // After whatever the owner did with the images before we were given them.
    targets.before.srcStageMask = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
    targets.before.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT;
    targets.before.dstStageMask = targets.after.srcStageMask = kDrawing;
    targets.before.dstAccessMask = kWrites | VK_ACCESS_SHADER_READ_BIT;
    targets.after.srcAccessMask = kWrites;
    targets.after.dstStageMask = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
    targets.after.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT;
    return makeRenderPass(device, targets);
}

OutputDrawing::Views viewsOf(const Device& device, VkRenderPass renderPass, const PictureSize& image,
                             const EyeOutput& output) {
    const bool hasDepth = output.depth != VK_NULL_HANDLE;
    OutputDrawing::Views views;
    views.colour = makeImageView(device, output.image, output.format, VK_IMAGE_ASPECT_COLOR_BIT, 1, output.layer);
    if (hasDepth)
        views.depth =
            makeImageView(device, output.depth, VK_FORMAT_D32_SFLOAT, VK_IMAGE_ASPECT_DEPTH_BIT, 1, output.depthLayer);
    const std::array<VkImageView, 2> both{views.colour, views.depth};
    views.framebuffer =
        makeFramebuffer(device, renderPass, std::span(both).first(hasDepth ? 2 : 1), image.width, image.height);
    return views;
}

} // namespace

OutputDrawing makeOutputDrawing(const Device& device, const EyeTarget& target, const OutputKind& kind) {
    OutputDrawing drawing;
    drawing.renderPass = makeOutputRenderPass(device, kind);
    const VkDescriptorSetLayout set = makeSetLayout(device, kPictureBindings, VK_SHADER_STAGE_FRAGMENT_BIT);
    drawing.layout =
        makePipelineLayout(device, std::array{set}, {VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof(EyeOutputConstants)});
    const std::array specialisation{std::uint32_t{kind.format == VK_FORMAT_R8G8B8A8_SRGB},
                                    std::uint32_t{kind.hasDepth}};
    drawing.pipeline = makeRasterPipeline(device, {.vertexCode = kOutputVertexCode,
                                                   .fragmentCode = kOutputFragmentCode,
                                                   .specialisation = specialisation,
                                                   .layout = drawing.layout,
                                                   .pass = drawing.renderPass});
    drawing.pool = makeSetPool(device, 1, kPictureBindings);
    drawing.set = allocateSet(device, drawing.pool, set,
                              std::array<Bound, 2>{{{target.colours.handle()}, {target.depths.handle()}}});
    return drawing;
}

void recordDrawing(VkCommandBuffer commands, const Device& device, OutputDrawing& drawing, std::size_t slot,
                   const PictureSize& picture, const PictureSize& image, const EyeOutput& output) {
    OutputDrawing::Views& views = drawing.views[slot];
    views = {};
    views = viewsOf(device, drawing.renderPass, image, output);
    beginRaster(commands, drawing.renderPass, views.framebuffer, drawing.pipeline,
                std::min(picture.width + 1, image.width), std::min(picture.height + 1, image.height));
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, drawing.layout, 0, 1, &drawing.set, 0, nullptr);
    const EyeOutputConstants constants{picture.width, picture.height, output.nearMetres};
    vkCmdPushConstants(commands, drawing.layout, VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof constants, &constants);
    vkCmdDraw(commands, 3, 1, 0, 0);
    vkCmdEndRenderPass(commands);
}

} // namespace render
