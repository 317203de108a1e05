#pragma once
// Images on the device: what is drawn into, and textures.

#include "render/handle.h"
#include "scene/image.h"
#include "scene/polygon_scene.h"

namespace render {

class Device;

using ImageHandle = Handle<VkImage, &vkDestroyImage>;
using ImageView = Handle<VkImageView, &vkDestroyImageView>;
using Sampler = Handle<VkSampler, &vkDestroySampler>;

struct DeviceImage {
    Memory memory; // freed after the image
    ImageHandle image;
    ImageView view;
    int width = 0, height = 0;
};

/// One layer; aspect: colour or depth. Of several samples a pixel it has one level.
DeviceImage makeImage(const Device& device, int width, int height, VkFormat format, VkImageUsageFlags usage,
                      VkImageAspectFlags aspect, std::uint32_t levels = 1,
                      VkSampleCountFlagBits samples = VK_SAMPLE_COUNT_1_BIT);

/// One layer of somebody's image.
ImageView makeImageView(const Device& device, VkImage image, VkFormat format, VkImageAspectFlags aspect,
                        std::uint32_t levels = 1, std::uint32_t layer = 0);

/// sRGB, with all coarser levels, to be sampled. Waits until it is there. Throws scene::Failure if the device has no
/// textures of that size; `name` says which it is.
DeviceImage uploadTexture(const Device& device, const scene::Image<scene::Rgba8>& pixels, const std::string& name);

/// Linear between pixels and levels, repeating.
Sampler makeTextureSampler(const Device& device);

/// Of single pixels.
Sampler makePixelSampler(const Device& device);

} // namespace render
