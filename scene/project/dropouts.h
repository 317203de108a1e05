#pragma once
// Small drop-outs of range inside a surface are filled from the samples around them, never across a silhouette.
// Nyland et al. 1999, section 4.3: samples are splatted with bilinear support into lists for each pixel, each list is
// clustered, and the heaviest cluster gives the pixel its range; the size of the splat says which drop-outs are filled.
// Unlike there, a gap wider than that is not filled in its middle, where both its rims are in reach: it may be a dark
// pole before a wall.

#include "scene/depth_image.h"

namespace scene {

struct DropoutOptions {
    int radius = 3;            ///< support of a sample in pixels: drop-outs as wide are filled; 0: none
    float sameSurface = 0.03f; ///< relative difference of disparity within a cluster
    int minSamples = 3;        ///< a cluster of fewer samples fills nothing
};

/// Gives pixels without range the disparity of the plane through the heaviest cluster of samples about them, if those
/// surround it (none is extrapolated); they are flagged kInterpolated. Measured samples stay as they are. Returns how
/// many were filled.
std::int64_t fillDropouts(DepthImage& image, const DropoutOptions& options = {});

struct GuessOptions {
    int radius = 16;           ///< of the window about a pixel, in pixels; 0: nothing is guessed
    int step = 2;              ///< of the window's pixels every so many are looked at, in both directions
    float colourStep = 25;     ///< a sample counts 1/e if its colour differs by so much (Euclidean, of 255 a channel)
    float sameSurface = 0.03f; ///< relative difference of disparity within a cluster
    int minSamples = 6;        ///< a cluster of fewer samples suggests nothing
};

/// Gives pixels that still have no range the one that the samples about them suggest, those of like colour most:
/// black, shining and transparent things return no range, but the photograph shows how far they reach. They become
/// guesses (isGuess), for other images to confirm or to refute (refine/skins.h). Returns how many.
std::int64_t guessRange(DepthImage& image, const GuessOptions& options = {});

} // namespace scene
