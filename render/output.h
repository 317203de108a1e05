#pragma once
// Where a finished eye goes besides its own buffers: a layer of somebody else's image, of a headset's or a window's
// swapchain.

#include "scene/polygon_scene.h"

#include <volk.h>

#include <cstdint>

namespace render {

class Device;

struct PictureSize {
    int width = 0, height = 0; ///< pixels
    friend bool operator==(const PictureSize&, const PictureSize&) = default;
};

/// An image of four bytes a pixel in the order r, g, b, a, as large as the eye, made to be drawn into
/// (a colour attachment) and copied to (a transfer destination). Nothing is done if it is null.
struct EyeOutput {
    VkImage image = VK_NULL_HANDLE;
    VkFormat format = VK_FORMAT_R8G8B8A8_SRGB; ///< or UNORM: its bytes are the picture's either way
    std::uint32_t layer = 0;
    VkImageLayout layout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL; ///< in which it is left; what it held is lost

    /// Of the format D32_SFLOAT, a depth attachment and transfer destination; left in DEPTH_STENCIL_ATTACHMENT_OPTIMAL.
    /// It is given nearMetres / z: 1 there and nearer, 0 infinitely far and where there is nothing. Null: no depth is
    /// wanted.
    VkImage depth = VK_NULL_HANDLE;
    std::uint32_t depthLayer = 0;
    float nearMetres = 0;
};

/// One of its two images, and how it is to be left.
struct OutputLayer {
    VkImage image;
    std::uint32_t index;
    VkImageAspectFlags aspect;
    VkImageLayout layout;
};
OutputLayer colourOf(const EyeOutput& output);
OutputLayer depthOf(const EyeOutput& output);
VkImageMemoryBarrier barrierOf(const OutputLayer& layer);
/// Of its first rows and columns, four bytes a pixel.
VkBufferImageCopy copyOf(const OutputLayer& layer, int width, int height);

/// What such an image's first rows and columns hold once all that was submitted to it is done; it must be made to be a
/// transfer source as well. Waits: for pictures of single frames.
scene::Image<scene::Rgb8> readOutput(const Device& device, const EyeOutput& output, int width, int height);
/// The same with each pixel's class as its fourth byte.
scene::Image<scene::Rgba8> readOutputAndClasses(const Device& device, const EyeOutput& output, int width, int height);
scene::Image<float> readDepthOutput(const Device& device, const EyeOutput& output, int width, int height);

} // namespace render
