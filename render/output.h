#pragma once
// Where a finished eye goes besides its own buffers: a layer of somebody else's image, of a headset's or a window's
// swapchain.

#include "scene/image.h"

#include <volk.h>

#include <cstdint>

namespace render {

class Device;
struct EyeTarget;

struct PictureSize {
    int width = 0, height = 0; ///< pixels
    friend bool operator==(const PictureSize&, const PictureSize&) = default;
};

/// An image of four bytes a pixel in the order r, g, b, a (UNORM or SRGB: bytes are copied as they are), as large as
/// the eye, made to be a transfer destination. Nothing is copied if image is null.
struct EyeOutput {
    VkImage image = VK_NULL_HANDLE;
    std::uint32_t layer = 0;
    VkImageLayout layout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL; ///< in which it is left; what it held is lost

    /// Of the format D32_SFLOAT, else as image; left in DEPTH_STENCIL_ATTACHMENT_OPTIMAL. It is given nearMetres / z: 1
    /// there and nearer, 0 infinitely far and where there is nothing. Null: no depth is wanted.
    VkImage depth = VK_NULL_HANDLE;
    std::uint32_t depthLayer = 0;
    float nearMetres = 0;
};

/// Copies the eye's resolved picture into the image's first rows and columns; the last byte of each pixel is its class.
/// Where the image is larger, the picture's last row and column are repeated once: who enlarges it linearly reads half
/// a pixel beyond its edge.
void recordOutput(VkCommandBuffer commands, const EyeTarget& target, const PictureSize& picture,
                  const PictureSize& image, const EyeOutput& output);
/// Likewise output's depth, from a buffer of what stands in it (DepthPass).
void recordDepthOutput(VkCommandBuffer commands, VkBuffer nearOverDepth, const PictureSize& picture,
                       const PictureSize& image, const EyeOutput& output);

/// What such an image's first rows and columns hold once all that was submitted to it is done; it must be made to be a
/// transfer source as well. Waits: for pictures of single frames.
scene::Image<scene::Rgb8> readOutput(const Device& device, const EyeOutput& output, int width, int height);
scene::Image<float> readDepthOutput(const Device& device, const EyeOutput& output, int width, int height);

} // namespace render
