#pragma once
// The last step of every eye: its z-buffer becomes a picture, and holes in it are filled (shaders/shared/hole_fill.h,
// hole_words.h).

#include "render/pipeline.h"
#include "render/shaders/shared/hole_fill.h"

#include <array>

namespace render {

class Device;

struct ResolvePass {
    /// Make the picture; tell which pixels hold anything, too; each with samples as they are, and interpolated.
    std::array<ComputePipeline, 2> plain, marking;
    ComputePipeline listing, filling; ///< what of those that hold nothing may be filled; fills it
    bool isByRows = false;            ///< one workgroup for each row of pixels
};

ResolvePass makeResolvePass(const Device& device, VkDescriptorSetLayout eyeLayout);

/// What becomes of the places of samples: nothing, colours are interpolated by them, or they are kept in the picture
/// for whoever enlarges it (placeKept).
enum class PlaceUse { none, interpolated, kept };

/// From the z-buffer of eyeSet to its colours and depths. A radius of 0 fills nothing and costs nothing.
void recordResolve(VkCommandBuffer commands, const ResolvePass& pass, VkDescriptorSet eyeSet, int width, int height,
                   const HoleFill& holes, PlaceUse use, const PlaceSteps& places);

} // namespace render
