#pragma once
// Which depth images see the same surfaces: the pairs that are laid on each other, evened and warped into each other.

#include "scene/image_store.h"

#include <vector>

namespace scene {

/// A coarse picture of one image: a grid of its samples, to guess overlaps without its pixels.
struct ImageOutline {
    Camera camera;
    Pose worldFromCamera;
    int columns = 0, rows = 0;
    std::vector<float> disparity; ///< row by row; 0 where there is no surface
};

ImageOutline outlineOf(const DepthImage& image);

/// Another image that sees part of this one.
struct Partner {
    std::uint32_t image = 0;
    float share = 0; ///< of this image's samples, how many lie in the partner's image about where it has its surface
};

/// For each image its partners, the greatest share first, none below minShare. Images whose bounds in the world do not
/// meet are never compared, so the time grows with the overlap and not with the square of the number of images.
std::vector<std::vector<Partner>> findPartners(const std::vector<ImageOutline>& outlines, float minShare = 0.02f);

} // namespace scene
