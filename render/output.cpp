#include "render/output.h"

#include "render/command_streams.h"
#include "render/resources.h"

#include <algorithm>
#include <utility>

namespace render {

OutputLayer colourOf(const EyeOutput& output) {
    return {output.image, output.layer, VK_IMAGE_ASPECT_COLOR_BIT, output.layout};
}

OutputLayer depthOf(const EyeOutput& output) {
    return {output.depth, output.depthLayer, VK_IMAGE_ASPECT_DEPTH_BIT,
            VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL};
}

VkImageMemoryBarrier barrierOf(const OutputLayer& layer) {
    VkImageMemoryBarrier barrier{};
    barrier.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER;
    barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.image = layer.image;
    barrier.subresourceRange = {layer.aspect, 0, 1, layer.index, 1};
    return barrier;
}

VkBufferImageCopy copyOf(const OutputLayer& layer, int width, int height) {
    VkBufferImageCopy copy{};
    copy.imageSubresource = {layer.aspect, 0, layer.index, 1};
    copy.imageExtent = {static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height), 1};
    return copy;
}

namespace {

/// Four bytes a pixel.
Buffer read(const Device& device, const OutputLayer& layer, int width, int height) {
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

scene::Image<float> readDepthOutput(const Device& device, const EyeOutput& output, int width, int height) {
    const Buffer buffer = read(device, depthOf(output), width, height);
    scene::Image<float> image(width, height);
    std::copy_n(buffer.as<const float>().begin(), image.size(), image.pixels().begin());
    return image;
}

scene::Image<scene::Rgba8> readOutputAndClasses(const Device& device, const EyeOutput& output, int width, int height) {
    const Buffer buffer = read(device, colourOf(output), width, height);
    scene::Image<scene::Rgba8> picture(width, height);
    const auto bytes = buffer.as<std::uint8_t>();
    for (std::size_t i = 0; i < picture.size(); ++i)
        picture.pixels()[i] = {bytes[4 * i], bytes[4 * i + 1], bytes[4 * i + 2], bytes[4 * i + 3]};
    return picture;
}

scene::Image<scene::Rgb8> readOutput(const Device& device, const EyeOutput& output, int width, int height) {
    const scene::Image<scene::Rgba8> read = readOutputAndClasses(device, output, width, height);
    scene::Image<scene::Rgb8> picture(width, height);
    std::ranges::transform(read.pixels(), picture.pixels().begin(), [](const scene::Rgba8& pixel) {
        return scene::Rgb8{pixel.r, pixel.g, pixel.b};
    });
    return picture;
}

} // namespace render
