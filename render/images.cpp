#include "render/images.h"

#include "render/check.h"
#include "render/command_streams.h"
#include "render/device.h"
#include "render/resources.h"

#include <algorithm>
#include <bit>
#include <cstring>

namespace render {

namespace {

VkImageMemoryBarrier barrierOf(VkImage image, std::uint32_t level, std::uint32_t levels, VkImageLayout from,
                               VkImageLayout to, VkAccessFlags fromAccess, VkAccessFlags toAccess) {
    VkImageMemoryBarrier barrier{};
    barrier.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER;
    barrier.srcAccessMask = fromAccess, barrier.dstAccessMask = toAccess;
    barrier.oldLayout = from, barrier.newLayout = to;
    barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.image = image;
    barrier.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, level, levels, 0, 1};
    return barrier;
}

void recordLayout(VkCommandBuffer commands, VkPipelineStageFlags from, VkPipelineStageFlags to,
                  const VkImageMemoryBarrier& barrier) {
    vkCmdPipelineBarrier(commands, from, to, 0, 0, nullptr, 0, nullptr, 1, &barrier);
}

VkOffset3D cornerOf(const DeviceImage& image, std::uint32_t level) {
    return {std::max(1, image.width >> level), std::max(1, image.height >> level), 1};
}

Sampler makeSampler(const Device& device, VkFilter filter, VkSamplerMipmapMode levels) {
    VkSamplerCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO;
    info.magFilter = info.minFilter = filter;
    info.mipmapMode = levels;
    info.maxLod = VK_LOD_CLAMP_NONE;
    VkSampler sampler = VK_NULL_HANDLE;
    check(vkCreateSampler(device, &info, nullptr, &sampler));
    return {device, sampler};
}

/// From level to level, each half as wide; the last one ends as all others do.
void recordLevels(VkCommandBuffer commands, const DeviceImage& image, std::uint32_t levels) {
    for (std::uint32_t level = 1; level < levels; ++level) {
        recordLayout(commands, kTransfer, kTransfer,
                     barrierOf(image.image, level - 1, 1, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                               VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_ACCESS_TRANSFER_WRITE_BIT,
                               VK_ACCESS_TRANSFER_READ_BIT));
        VkImageBlit blit{};
        blit.srcSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, level - 1, 0, 1};
        blit.srcOffsets[1] = cornerOf(image, level - 1);
        blit.dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, level, 0, 1};
        blit.dstOffsets[1] = cornerOf(image, level);
        vkCmdBlitImage(commands, image.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, image.image,
                       VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &blit, VK_FILTER_LINEAR);
    }
    recordLayout(commands, kTransfer, kTransfer,
                 barrierOf(image.image, levels - 1, 1, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                           VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_ACCESS_TRANSFER_WRITE_BIT,
                           VK_ACCESS_TRANSFER_READ_BIT));
    recordLayout(commands, kTransfer, VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT,
                 barrierOf(image.image, 0, levels, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                           VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, VK_ACCESS_TRANSFER_READ_BIT,
                           VK_ACCESS_SHADER_READ_BIT));
}

} // namespace

DeviceImage makeImage(const Device& device, int width, int height, VkFormat format, VkImageUsageFlags usage,
                      VkImageAspectFlags aspect, std::uint32_t levels, VkSampleCountFlagBits samples) {
    DeviceImage made;
    made.width = width, made.height = height;
    VkImageCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO;
    info.imageType = VK_IMAGE_TYPE_2D;
    info.format = format;
    info.extent = {static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height), 1};
    info.mipLevels = levels;
    info.arrayLayers = 1;
    info.samples = samples;
    info.usage = usage;
    VkImage image = VK_NULL_HANDLE;
    check(vkCreateImage(device, &info, nullptr, &image));
    made.image = {device, image};

    VkMemoryRequirements needs{};
    vkGetImageMemoryRequirements(device, image, &needs);
    VkMemoryAllocateInfo allocate{};
    allocate.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
    allocate.allocationSize = needs.size;
    allocate.memoryTypeIndex = device.memoryType(needs.memoryTypeBits, 0, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
    VkDeviceMemory memory = VK_NULL_HANDLE;
    check(vkAllocateMemory(device, &allocate, nullptr, &memory));
    made.memory = {device, memory};
    check(vkBindImageMemory(device, image, memory, 0));

    made.view = makeImageView(device, image, format, aspect, levels);
    return made;
}

ImageView makeImageView(const Device& device, VkImage image, VkFormat format, VkImageAspectFlags aspect,
                        std::uint32_t levels, std::uint32_t layer) {
    VkImageViewCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO;
    info.image = image;
    info.viewType = VK_IMAGE_VIEW_TYPE_2D;
    info.format = format;
    info.subresourceRange = {aspect, 0, levels, layer, 1};
    VkImageView view = VK_NULL_HANDLE;
    check(vkCreateImageView(device, &info, nullptr, &view));
    return {device, view};
}

DeviceImage uploadTexture(const Device& device, const scene::Image<scene::Rgba8>& pixels, const std::string& name) {
    const auto most = static_cast<int>(device.limits().maxImageDimension2D);
    if (pixels.width() > most || pixels.height() > most)
        throw scene::Failure("is larger than the " + std::to_string(most) + " pixels a side that " + device.name() +
                                 " can show",
                             name, "make the picture smaller");
    const auto levels =
        static_cast<std::uint32_t>(std::bit_width(static_cast<unsigned>(std::max(pixels.width(), pixels.height()))));
    DeviceImage texture =
        makeImage(device, pixels.width(), pixels.height(), VK_FORMAT_R8G8B8A8_SRGB,
                  VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                  VK_IMAGE_ASPECT_COLOR_BIT, levels);
    const std::span<const scene::Rgba8> all = pixels.pixels();
    const Buffer staging(device, all.size_bytes(), VK_BUFFER_USAGE_TRANSFER_SRC_BIT, MemoryUse::hostWrites);
    std::memcpy(staging.mapped(), all.data(), all.size_bytes());
    runAndWait(device, [&](VkCommandBuffer commands) {
        recordLayout(commands, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT,
                     barrierOf(texture.image, 0, levels, VK_IMAGE_LAYOUT_UNDEFINED,
                               VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 0, VK_ACCESS_TRANSFER_WRITE_BIT));
        VkBufferImageCopy copy{};
        copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
        copy.imageExtent = {static_cast<std::uint32_t>(pixels.width()), static_cast<std::uint32_t>(pixels.height()), 1};
        vkCmdCopyBufferToImage(commands, staging.handle(), texture.image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1,
                               &copy);
        recordLevels(commands, texture, levels);
    });
    return texture;
}

Sampler makeTextureSampler(const Device& device) {
    return makeSampler(device, VK_FILTER_LINEAR, VK_SAMPLER_MIPMAP_MODE_LINEAR);
}

Sampler makePixelSampler(const Device& device) {
    return makeSampler(device, VK_FILTER_NEAREST, VK_SAMPLER_MIPMAP_MODE_NEAREST);
}

} // namespace render
