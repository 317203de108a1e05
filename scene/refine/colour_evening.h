#pragma once
// Exposure and white balance drift from picture to picture, light changes while a site is scanned: where two images
// show the same surface, the one is a little brighter or warmer than the other, and a seam is seen. Here each image
// gets a factor for red, green and blue, solved over all overlaps (Brown and Lowe, "Automatic panoramic image stitching
// using invariant features", 2007, section 6, solve gains of panoramas alike).

#include "scene/image_store.h"
#include "scene/overlap.h"
#include "scene/reprojection.h"

#include <functional>
#include <vector>

#include <glm/vec3.hpp>

namespace scene {

struct ColourEveningOptions {
    int maxPartners = 12;      ///< of each image, those with the greatest overlap
    int samplesPerPair = 4000; ///< looked at
    int leastSamples = 60;     ///< that agree: fewer tell nothing
    double priorStops = 0.5;   ///< how far exposures drift: what overlaps leave open stays near 1 by so much
    double mostStops = 1.0;    ///< by which an image may be brightened: beyond, noise is what would be seen
    double leastChange = 0.01; ///< capture is even, and stays as it is, if no factor differs from 1 by more
    ComparisonOptions comparison;
};

struct ColourEvening {
    std::vector<glm::dvec3> factors;       ///< of linear light, for each image; all 1 where the capture is even
    std::int64_t pairs = 0;                ///< overlaps that had a say
    double seamBefore = 0, seamAfter = 0;  ///< mean relative difference of colour across overlaps, linear light
    std::int64_t changed = 0, limited = 0; ///< images; limited: would have to be brightened more than mostStops
};

/// onImage is called after each image, from any thread. Images without colours (kNoColour) neither say anything nor are
/// changed. The same on any number of threads.
ColourEvening evenColours(ImageStore& images, const std::vector<std::vector<Partner>>& partners,
                          const ColourEveningOptions& options = {}, const std::function<void()>& onImage = {});

/// Multiplies linear light and writes it back as sRGB.
void applyFactors(Image<Rgb8>& colour, const glm::dvec3& factors);

} // namespace scene
