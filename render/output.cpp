#include "render/output.h"

#include "render/command_streams.h"
#include "render/target.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace render {

namespace {

/// A layer of somebody's image, and how it is to be left.
struct Layer {
    VkImage image;
    std::uint32_t index;
    VkImageAspectFlags aspect;
    VkImageLayout layout;
};

Layer colourOf(const EyeOutput& output) {
    return {output.image, output.layer, VK_IMAGE_ASPECT_COLOR_BIT, output.layout};
}

Layer depthOf(const EyeOutput& output) {
    return {output.depth, output.depthLayer, VK_IMAGE_ASPECT_DEPTH_BIT,
            VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL};
}

VkImageMemoryBarrier barrierOf(const Layer& layer) {
    VkImageMemoryBarrier barrier{};
    barrier.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER;
    barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.image = layer.image;
    barrier.subresourceRange = {layer.aspect, 0, 1, layer.index, 1};
    return barrier;
}

VkBufferImageCopy copyOf(const Layer& layer, int width, int height) {
    VkBufferImageCopy copy{};
    copy.imageSubresource = {layer.aspect, 0, layer.index, 1};
    copy.imageExtent = {static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height), 1};
    return copy;
}

/// The picture, and its last row and column again beyond it where there is room.
std::vector<VkBufferImageCopy> copiesOf(const Layer& layer, const PictureSize& picture, const PictureSize& image) {
    const auto part = [&](int x, int y, int width, int height, int toX, int toY) {
        VkBufferImageCopy copy = copyOf(layer, width, height);
        copy.bufferOffset = 4 * (static_cast<VkDeviceSize>(y) * static_cast<VkDeviceSize>(picture.width) +
                                 static_cast<VkDeviceSize>(x));
        copy.bufferRowLength = static_cast<std::uint32_t>(picture.width);
        copy.imageOffset = {toX, toY, 0};
        return copy;
    };
    const auto [width, height] = picture;
    const bool isWider = image.width > width, isHigher = image.height > height;
    std::vector<VkBufferImageCopy> copies{part(0, 0, width, height, 0, 0)};
    if (isWider) copies.push_back(part(width - 1, 0, 1, height, width, 0));
    if (isHigher) copies.push_back(part(0, height - 1, width, 1, 0, height));
    if (isWider && isHigher) copies.push_back(part(width - 1, height - 1, 1, 1, width, height));
    return copies;
}

void recordCopy(VkCommandBuffer commands, VkBuffer from, const Layer& to, const PictureSize& picture,
                const PictureSize& image) {
    VkImageMemoryBarrier barrier = barrierOf(to);
    barrier.oldLayout = VK_IMAGE_LAYOUT_UNDEFINED;
    barrier.newLayout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
    barrier.dstAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
    // After whatever the owner did with the image before we were given it.
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 0, nullptr, 0,
                         nullptr, 1, &barrier);

    const std::vector<VkBufferImageCopy> copies = copiesOf(to, picture, image);
    vkCmdCopyBufferToImage(commands, from, to.image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                           static_cast<std::uint32_t>(copies.size()), copies.data());

    barrier.oldLayout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
    barrier.newLayout = to.layout;
    barrier.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
    barrier.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT;
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 0, nullptr, 0,
                         nullptr, 1, &barrier);
}

/// Four bytes a pixel.
Buffer read(const Device& device, const Layer& layer, int width, int height) {
    const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    Buffer buffer(device, pixels * 4, VK_BUFFER_USAGE_TRANSFER_DST_BIT, MemoryUse::hostReads);
    VkImageMemoryBarrier barrier = barrierOf(layer);
    runAndWait(device, [&](VkCommandBuffer commands) {
        barrier.oldLayout = layer.layout;
        barrier.newLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
        barrier.srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT;
        barrier.dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT;
        vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 0,
                             nullptr, 0, nullptr, 1, &barrier);
        const VkBufferImageCopy copy = copyOf(layer, width, height);
        vkCmdCopyImageToBuffer(commands, layer.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, buffer.handle(), 1, &copy);
        std::swap(barrier.oldLayout, barrier.newLayout);
        barrier.srcAccessMask = VK_ACCESS_TRANSFER_READ_BIT;
        barrier.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT;
        vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 0,
                             nullptr, 0, nullptr, 1, &barrier);
        record(commands, {VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_HOST_BIT,
                          VK_ACCESS_HOST_READ_BIT});
    });
    return buffer;
}

} // namespace

void recordOutput(VkCommandBuffer commands, const EyeTarget& target, const PictureSize& picture,
                  const PictureSize& image, const EyeOutput& output) {
    recordCopy(commands, target.colours.handle(), colourOf(output), picture, image);
}

void recordDepthOutput(VkCommandBuffer commands, VkBuffer nearOverDepth, const PictureSize& picture,
                       const PictureSize& image, const EyeOutput& output) {
    recordCopy(commands, nearOverDepth, depthOf(output), picture, image);
}

scene::Image<float> readDepthOutput(const Device& device, const EyeOutput& output, int width, int height) {
    const Buffer buffer = read(device, depthOf(output), width, height);
    scene::Image<float> image(width, height);
    std::copy_n(buffer.as<const float>().begin(), image.size(), image.pixels().begin());
    return image;
}

scene::Image<scene::Rgb8> readOutput(const Device& device, const EyeOutput& output, int width, int height) {
    const Buffer buffer = read(device, colourOf(output), width, height);
    scene::Image<scene::Rgb8> picture(width, height);
    const auto bytes = buffer.as<std::uint8_t>();
    for (std::size_t i = 0; i < picture.size(); ++i)
        picture.pixels()[i] = {bytes[4 * i], bytes[4 * i + 1], bytes[4 * i + 2]};
    return picture;
}

} // namespace render
