#pragma once
// Tints what was not measured in an eye's picture (Quality::marksUnmeasured, shaders/shared/mark.h). Classes and depths
// stay.

#include "render/pipeline.h"

namespace render {

ComputePipeline makeMarkPass(const Device& device, VkDescriptorSetLayout eyeLayout);

/// After the picture was resolved and has its size.
void recordMark(VkCommandBuffer commands, const ComputePipeline& pass, VkDescriptorSet eyeSet, int width, int height);

} // namespace render
