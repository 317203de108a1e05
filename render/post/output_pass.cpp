#include "render/post/output_pass.h"

#include "render/device.h"

namespace render {

namespace {

OutputKind kindOf(const EyeOutput& output) {
    return {output.format, output.layout, output.depth != VK_NULL_HANDLE};
}

} // namespace

bool isFor(const std::optional<OutputPass>& pass, const EyeOutput& output) {
    return pass && pass->kind == kindOf(output);
}

OutputPass makeOutputPass(const Device& device, const EyeTarget& target, const EyeOutput& output) {
    const OutputKind kind = kindOf(output);
    if (device.isProcessor()) return {kind, makeOutputCopy(device, target, kind.hasDepth)};
    return {kind, makeOutputDrawing(device, target, kind)};
}

void recordOutput(VkCommandBuffer commands, const Device& device, OutputPass& pass, std::size_t slot,
                  const PictureSize& picture, const PictureSize& image, const EyeOutput& output) {
    if (OutputDrawing* const drawing = std::get_if<OutputDrawing>(&pass.way))
        recordDrawing(commands, device, *drawing, slot, picture, image, output);
    else
        recordCopy(commands, std::get<OutputCopy>(pass.way), picture, image, output);
}

} // namespace render
