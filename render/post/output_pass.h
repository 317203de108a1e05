#pragma once
// A finished eye becomes part of somebody else's images (render/output.h). Processors copy it; cards draw it, since
// they copy buffers into images at a small part of the speed of their memory (docs/performance.md).

#include "render/post/output_copy.h"
#include "render/post/output_drawing.h"

#include <optional>
#include <variant>

namespace render {

/// One eye's.
struct OutputPass {
    OutputKind kind;
    std::variant<OutputDrawing, OutputCopy> way;
};

/// Whether it is there, and was made for such images.
bool isFor(const std::optional<OutputPass>& pass, const EyeOutput& output);

OutputPass makeOutputPass(const Device& device, const EyeTarget& target, const EyeOutput& output);

/// After all else that is done with the picture is finished and visible to transfers. The picture goes into the images'
/// first rows and columns; where they are larger (`image`), its last row and column are repeated once: who enlarges it
/// linearly reads half a pixel beyond its edge. The last byte of each pixel is its class. The frame that used this slot
/// before must have finished.
void recordOutput(VkCommandBuffer commands, const Device& device, OutputPass& pass, std::size_t slot,
                  const PictureSize& picture, const PictureSize& image, const EyeOutput& output);

} // namespace render
