#pragma once
// Where photographs with range stood, found by what they have in common, all of them at once. The poses they come with
// are those of odometry or of another program's reconstruction, and off by millimetres: that is pixels, and surfaces
// that several images show are seen twice. Each sample of an image goes to the surface that another saw there, along
// its normal (Chen and Medioni, "Object modelling by registration of multiple range images", 1992), and to the grey
// that the other has there (Kerl, Sturm, Cremers: "Dense visual SLAM for RGB-D cameras", 2013, for two at a time), by
// Gauss and Newton's steps with weights that let outliers go (Geman and McClure, 1985), from coarse greys to fine.

#include "scene/align/image_sketch.h"
#include "scene/overlap.h"
#include "scene/reprojection.h"

#include <cstdint>
#include <functional>
#include <vector>

namespace scene {

struct JointImagesOptions {
    int maxPartners = 24;      ///< of each image, evenly from those that see much of it to those that see little
    int samplesPerPair = 1200; ///< looked at
    int leastAgreeing = 60;    ///< samples of a pair: fewer tell nothing
    int passes = 20;           ///< over each size of greys, at most
    double damping = 0.05;     ///< of the range and in radians: what overlaps leave open takes no longer steps
    double mostMoved = 0.15;   ///< of the range, or radians: an image that goes so far has strayed,
    double mostAgainst = 0.15; ///< or if others saw through so much of it
    double leastPixels = 0.25; ///< a capture is right if 19 of 20 pairs move by less: then only images move half of
                               ///< whose own pairs move by more
    ComparisonOptions comparison;
};

/// How well images lie on each other: medians over all samples that two images saw.
struct Apartness {
    double range = 0;          ///< distance of surfaces, of the range
    double grey = 0;           ///< difference of logarithms of light, fine detail alone
    double against = 0;        ///< share of samples that the other saw through
    std::int64_t agreeing = 0; ///< samples on the same surface
};

enum class ImagePlace : std::uint8_t {
    given, ///< as it was: it is right, or nothing that others have in common with it says otherwise
    adjusted,
    loose,  ///< too little holds it to say where it belongs: as it was
    strayed ///< went too far, or away from the others, and was put back where it was
};

struct JointImages {
    std::vector<Pose> worldFromCameras;
    std::vector<ImagePlace> places;
    Apartness before, after; ///< of all but the followers
    double movedPixels = 0;  ///< against each other, of the photograph: 19 of 20 pairs by less
    bool isWorse = false;    ///< what was found does not fit better than what was given, which was kept
};

/// sketches: all made with the same shrink. partners: of each (scene/overlap.h), the greatest overlap first.
/// isFollower: images that are laid on the others, which know nothing of them; none if empty. onPass is called after
/// each pass with a share of the work, from this thread. The same on any number of threads.
JointImages layImagesOnEachOther(const std::vector<ImageSketch>& sketches, int shrink,
                                 const std::vector<std::vector<Partner>>& partners,
                                 const std::vector<std::uint8_t>& isFollower, const JointImagesOptions& options = {},
                                 const std::function<void()>& onPass = {});

} // namespace scene
