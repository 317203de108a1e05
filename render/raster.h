#pragma once
// What the device's own rasteriser draws with: render passes, framebuffers, pipelines of a vertex and a fragment
// shader.

#include "render/handle.h"

#include <cstdint>
#include <span>

namespace render {

class Device;

using RenderPass = Handle<VkRenderPass, &vkDestroyRenderPass>;
using Framebuffer = Handle<VkFramebuffer, &vkDestroyFramebuffer>;

/// What it held is lost; its pixels are kept.
VkAttachmentDescription attachmentOf(VkFormat format, VkSampleCountFlagBits samples, VkAttachmentLoadOp atFirst,
                                     VkImageLayout finalLayout);

/// One subpass. colour and depth are attachments 0 and 1; depth's format may be undefined: then there is none.
struct RasterTargets {
    VkAttachmentDescription colour{}, depth{};
    VkSubpassDependency before{}, after{}; ///< from what comes before it, and to what comes after
};
RenderPass makeRenderPass(const Device& device, const RasterTargets& targets);

/// views: as many as the pass has attachments, each of that size or larger.
Framebuffer makeFramebuffer(const Device& device, VkRenderPass pass, std::span<const VkImageView> views, int width,
                            int height);

/// Triangles, seen from both sides; viewport and scissor are set when they are drawn.
struct RasterPipeline {
    std::span<const std::uint32_t> vertexCode{}, fragmentCode{};
    std::span<const std::uint32_t> specialisation{}; ///< constants 0, 1, ... of the fragment shader
    std::span<const VkVertexInputBindingDescription> bindings{};
    std::span<const VkVertexInputAttributeDescription> attributes{};
    VkSampleCountFlagBits samples = VK_SAMPLE_COUNT_1_BIT;
    VkCompareOp depthCompare = VK_COMPARE_OP_ALWAYS; ///< depth is written where it holds
    VkPipelineLayout layout = VK_NULL_HANDLE;
    VkRenderPass pass = VK_NULL_HANDLE;
};
Pipeline makeRasterPipeline(const Device& device, const RasterPipeline& wanted);

/// Of these first pixels; sets viewport and scissor, and clears with zeros what the pass clears.
void beginRaster(VkCommandBuffer commands, VkRenderPass pass, VkFramebuffer framebuffer, VkPipeline pipeline, int width,
                 int height);

} // namespace render
