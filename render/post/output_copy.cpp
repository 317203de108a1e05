#include "render/post/output_copy.h"

#include "render/command_streams.h"
#include "render/device.h"
#include "render/shaders/shared/eye_output.h"
#include "spirv/near_over_depth.comp.h"

#include <array>
#include <vector>

namespace render {

namespace {

constexpr std::array kDepthBindings{Binding::storage, Binding::storage};

/// The picture, and its last row and column again beyond it where there is room.
std::vector<VkBufferImageCopy> copiesOf(const OutputLayer& layer, const PictureSize& picture,
                                        const PictureSize& image) {
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

void recordCopyOf(VkCommandBuffer commands, VkBuffer from, const OutputLayer& to, const PictureSize& picture,
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

void recordNearOverDepth(VkCommandBuffer commands, const OutputCopy& copy, const PictureSize& picture,
                         float nearMetres) {
    record(commands, {kCompute, VK_ACCESS_SHADER_WRITE_BIT, kCompute, VK_ACCESS_SHADER_READ_BIT});
    const EyeOutputConstants constants{picture.width, picture.height, nearMetres};
    const VkPipelineLayout layout = copy.pipeline.layout();
    bind(commands, copy.pipeline);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 1, &copy.set, 0, nullptr);
    vkCmdPushConstants(commands, layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof constants, &constants);
    vkCmdDispatch(commands, static_cast<std::uint32_t>(picture.height), 1, 1);
    record(commands,
           {kCompute, VK_ACCESS_SHADER_WRITE_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_READ_BIT});
}

} // namespace

OutputCopy makeOutputCopy(const Device& device, const EyeTarget& target, bool hasDepth) {
    OutputCopy copy;
    copy.colours = target.colours.handle();
    if (!hasDepth) return copy;
    const VkDescriptorSetLayout layout = makeSetLayout(device, kDepthBindings);
    const std::uint32_t workgroupSize = device.workgroupSize(128);
    copy.pipeline = makeComputePipeline(device, kNearOverDepthCode, std::array<VkDescriptorSetLayout, 1>{layout},
                                        sizeof(EyeOutputConstants), std::array{workgroupSize});
    copy.nearOverDepth =
        Buffer(device, target.depths.size(), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT,
               MemoryUse::onDevice);
    copy.pool = makeSetPool(device, 1, kDepthBindings);
    const std::array<Bound, kDepthBindings.size()> bound{{{target.depths.handle()}, {copy.nearOverDepth.handle()}}};
    copy.set = allocateSet(device, copy.pool, layout, bound);
    return copy;
}

void recordCopy(VkCommandBuffer commands, const OutputCopy& copy, const PictureSize& picture, const PictureSize& image,
                const EyeOutput& output) {
    recordCopyOf(commands, copy.colours, colourOf(output), picture, image);
    if (output.depth == VK_NULL_HANDLE) return;
    recordNearOverDepth(commands, copy, picture, output.nearMetres);
    recordCopyOf(commands, copy.nearOverDepth.handle(), depthOf(output), picture, image);
}

} // namespace render
