#pragma once
// Small drop-outs of range inside a surface are filled from the samples around them, never across a silhouette.
// Nyland et al. 1999, section 4.3: samples are splatted with bilinear support into lists for each pixel, each list is
// clustered, and the heaviest cluster gives the pixel its range; the size of the splat says which drop-outs are filled.

#include "scene/depth_image.h"

namespace scene {

struct DropoutOptions {
    int radius = 3;            ///< support of a sample in pixels: drop-outs up to twice as wide are filled
    float sameSurface = 0.03f; ///< relative difference of disparity within a cluster
    int minSamples = 3;        ///< a cluster of fewer samples fills nothing
};

/// Gives pixels without range the disparity of the plane through the heaviest cluster of samples about them, if those
/// surround it (none is extrapolated); they are flagged kInterpolated. Measured samples stay as they are. Returns how
/// many were filled.
std::int64_t fillDropouts(DepthImage& image, const DropoutOptions& options = {});

} // namespace scene
