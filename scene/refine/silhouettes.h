#pragma once
// Silhouettes where the photographs have them: depth cameras see the edge of a thing some pixels beside its edge in the
// photograph, for range is taken from another place, at a lower resolution, and mixes near and far there.
//
//   range         near near near | far far far          A sample beside a jump of range belongs to the surface on one
//   photograph    near near | far  far far far          side or on the other: that at which other photographs show
//                             ^                         the same colours. Laid on the wrong one it is smeared over
//                        far is right here              whatever stands there, differently from each place.
//
// A choice between two surfaces that were measured nearby, by the colours of several photographs: of plane sweeping
// (Collins, "A space-sweep approach to true multi-image matching", 1996) what a capture with range requires; patches
// count what is like their middle in colour (Yoon and Kweon, "Adaptive support-weight approach for correspondence
// search", 2006). Beyond the four articles.

#include "scene/image_store.h"
#include "scene/overlap.h"
#include "scene/reprojection.h"

namespace scene {

struct SilhouetteOptions {
    int radius = 10;           ///< how far beside a jump of range a sample may be on the wrong side, pixels
    float jump = 0.08f;        ///< relative difference of disparity between the two surfaces
    int maxPartners = 16;      ///< photographs that are asked
    float leastParallax = 2;   ///< pixels between near and far in a photograph that can tell them apart
    float mostParallax = 48;   ///< beyond, things look too different
    int patchRadius = 2;       ///< of what is compared, pixels
    int step = 2;              ///< every so many pixels are compared, in both directions; those between ask them
    float colourStep = 20;     ///< what differs so much from the patch's middle counts 1/e (of 255, mean of channels)
    float mostDifference = 40; ///< colours that differ more count as this: something else stands there
    float leastGain = 1;       ///< mean difference by which the other side must fit better for each pixel off, of 255
    int rounds = 2;            ///< each begins with what the one before found: 0.2 dB of a real capture
    /// A capture stays as it is if the other side's advantages, where it has any, sum to no more than this share of the
    /// own side's. Exact range: 0.02 to 0.03 (view-dependent colours), 0.15 among leaves that look alike; that of a
    /// depth camera: 0.18.
    float rightShare = 0.06f;
    /// It stays, too, if more photographs saw through the near sides than agree with them for no more than this share
    /// of their samples. Exact range: 0.00 to 0.01; that of a depth camera: 0.14.
    float rightSeenThrough = 0.05f;
    int judged = 24; ///< images that are looked at for that, spread evenly
    ComparisonOptions comparison;
};

/// What other images say of measured samples beside silhouettes.
struct SilhouetteVerdict {
    std::int64_t samples = 0;               ///< of which photographs had something to say
    double forOwn = 0, forOther = 0;        ///< sums of the mean differences by which one side's colours fit better
    std::int64_t near = 0, seenThrough = 0; ///< samples on near sides; those that more saw through than agree with

    double doubt() const { return forOwn > 0 ? forOther / forOwn : 0; }
    double seenThroughShare() const {
        return near > 0 ? static_cast<double>(seenThrough) / static_cast<double>(near) : 0;
    }
    bool areRight(const SilhouetteOptions& options) const {
        return doubt() <= options.rightShare || seenThroughShare() <= options.rightSeenThrough;
    }
};

/// Whether the capture's range and photographs agree where silhouettes are. The same on any number of threads.
SilhouetteVerdict judgeSilhouettes(ImageStore& images, const std::vector<std::vector<Partner>>& partners,
                                   const SilhouetteOptions& options);

/// Of one round, or summed over rounds.
struct SilhouetteFigures {
    std::int64_t contested = 0; ///< samples and pixels without range beside a jump
    std::int64_t moved = 0;     ///< samples that went to the surface on the other side
    std::int64_t guessed = 0;   ///< pixels without range that got a guess, or another one

    bool areChanged() const { return moved + guessed > 0; }
};

/// The image after one round: samples beside silhouettes on the surface at which the partners' photographs agree. Those
/// moved are flagged kInterpolated, and what had no range has a guess (isGuess) at most. The same on any number of
/// threads.
DepthImage settleSilhouettes(ImageStore& images, std::size_t index, const std::vector<Partner>& partners,
                             const SilhouetteOptions& options, SilhouetteFigures& figures);

} // namespace scene
