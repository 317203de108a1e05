#pragma once
// The scene drawn at another resolution than the eye's: fewer pixels cost less, more of them smooth edges
// (supersampling; Quality::resolutionScale). shaders/shared/rescale.h says how one becomes the other.

#include "render/pipeline.h"
#include "render/shaders/shared/sample_place.h"
#include "render/target.h"

#include <optional>

namespace render {

struct RescalePass {
    VkDescriptorSetLayout layout = VK_NULL_HANDLE; ///< 0 and 1 colours and depths as warped, 2 and 3 the eye's
    ComputePipeline any;
    /// To a picture that is nowhere smaller, as any does it, but faster; and by the places of the old pixels' samples.
    ComputePipeline enlarge, enlargeByPlaces;
};

RescalePass makeRescalePass(const Device& device);

/// What an eye's scene is warped into where that is not the eye's own target. Any size fits of no more pixels than
/// it was made for, so that the scale may change from frame to frame.
struct ScaledTarget {
    EyeTarget target;
    BufferView colourTexels, depthTexels; ///< of the target, to be read
    std::size_t pixels = 0;
    DescriptorPool pool;
    VkDescriptorSet set = VK_NULL_HANDLE;
};

/// eye: where the picture goes in the end. Throws scene::Failure as makeEyeTarget does.
ScaledTarget makeScaledTarget(const Device& device, const RescalePass& pass, VkDescriptorSetLayout eyeLayout,
                              const EyeTarget& eye, int width, int height);

/// Pixels along a side of `pixels` at that scale; at least one.
int scaledSide(int pixels, double scale);

struct Rescaling {
    int fromWidth = 0, fromHeight = 0, toWidth = 0, toHeight = 0; ///< pixels
    bool isEnlarging() const { return fromWidth <= toWidth && fromHeight <= toHeight; }
};

/// After the scaled picture was resolved. places: of the samples, where the picture is enlarged and keeps them.
void recordRescale(VkCommandBuffer commands, const RescalePass& pass, const ScaledTarget& from, const Rescaling& sizes,
                   const std::optional<PlaceSteps>& places);

} // namespace render
