#pragma once
// Fusion: the sample that is kept takes the confidence-weighted mean of all images that agree with it, in colour and
// disparity. Beyond the papers: dropping the others then costs nothing, and noise falls. Samples of a scan without
// colours (kNoColour) take those of whoever has any, and are then no longer without.

#include "scene/image_store.h"
#include "scene/overlap.h"
#include "scene/refine/redundancy.h"
#include "scene/reprojection.h"

namespace scene {

struct FusionOptions {
    int maxPartners = 16;      ///< images that may contribute, those with the greatest overlap: more blur
    float angleRadians = 0.1f; ///< rays that differ so much count 1/e: appearance depends on direction
    float colourStep = 30.f;   ///< colours (0 to 255) that differ so much count 1/e: they show something else
    ComparisonOptions comparison;
};

/// The image with fused colour and disparity, for every sample that drawing needs: kept ones and those that share a
/// mesh square with one. The flags of the result say what is kept: kRedundant, kDirectional or neither. What is closed
/// (isClosed) is no longer so where this image measured the same surface within a pixel, or another one did.
DepthImage fuse(ImageStore& images, std::size_t index, const std::vector<Partner>& partners, const Image<Keep>& kept,
                const FusionOptions& options);

} // namespace scene
