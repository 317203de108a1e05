#pragma once
// A finished eye is drawn into somebody else's images of colour and depth (shaders/shared/eye_output.h).

#include "render/images.h"
#include "render/output.h"
#include "render/pipeline.h"
#include "render/raster.h"
#include "render/target.h"

#include <array>

namespace render {

/// What is made for images of some kind.
struct OutputKind {
    VkFormat format = VK_FORMAT_UNDEFINED;
    VkImageLayout layout = VK_IMAGE_LAYOUT_UNDEFINED; ///< in which colours are left
    bool hasDepth = false;
    friend bool operator==(const OutputKind&, const OutputKind&) = default;
};

/// One eye's.
struct OutputDrawing {
    RenderPass renderPass;
    PipelineLayout layout;
    Pipeline pipeline;
    DescriptorPool pool;
    VkDescriptorSet set = VK_NULL_HANDLE; ///< 0 colours, 1 depths
    /// Of the images that a frame in flight is drawn into. Made for each frame: whose the images are may make others in
    /// their place.
    struct Views {
        ImageView colour, depth; // freed after the framebuffer
        Framebuffer framebuffer;
    };
    std::array<Views, kFramesInFlight> views;
};

OutputDrawing makeOutputDrawing(const Device& device, const EyeTarget& target, const OutputKind& kind);

/// After all else that is done with the picture: it waits for that, and makes wait what comes next. The frame that used
/// this slot before must have finished.
void recordDrawing(VkCommandBuffer commands, const Device& device, OutputDrawing& drawing, std::size_t slot,
                   const PictureSize& picture, const PictureSize& image, const EyeOutput& output);

} // namespace render
