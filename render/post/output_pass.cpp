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
    OutputPass pass{.kind = kindOf(output), .drawing = {}, .copy = {}};
    if (device.isProcessor())
        pass.copy = makeOutputCopy(device, target, pass.kind.hasDepth);
    else
        pass.drawing = makeOutputDrawing(device, target, pass.kind);
    return pass;
}

void recordOutput(VkCommandBuffer commands, const Device& device, OutputPass& pass, std::size_t slot,
                  const PictureSize& picture, const PictureSize& image, const EyeOutput& output) {
    if (pass.drawing)
        recordDrawing(commands, device, *pass.drawing, slot, picture, image, output);
    else
        recordCopy(commands, *pass.copy, picture, image, output);
}

} // namespace render
