#pragma once
// How an eye stands to the images of a scene, and of which of them it may see anything: of the others a frame asks
// nothing but whether the sphere about a captured image is in the eye's view, and whether open ways lead to the box
// about its samples.

#include "render/quality.h"
#include "render/scene_index.h"
#include "scene/open_ways.h"
#include "scene/view.h"

#include <cstdint>
#include <span>
#include <vector>

namespace render {

/// How an eye stands to an image of the scene, or to a coarser level of one.
struct SourceView {
    glm::dmat4 eyeImageFromSource{1.0}; ///< C
    glm::dvec3 eyeFromCamera{0};        ///< how far the eye stands from the camera, metres in the world
    double pixelsPerSample = 1;         ///< how wide the eye sees a sample from where it was taken
    std::uint32_t captured = 0, level = 0;
    float share = 1; ///< of its samples, that are drawn
    bool hasCoarser = false;
    bool isNear = true; ///< the camera stands near the eye, by what it mostly sees: all levels of an image alike
};

/// Kept from frame to frame: of a large site it is megabytes.
struct SourceViews {
    std::vector<SourceView> of; ///< by image; of those that are not seen it is from some other frame
    /// The images of which anything may be seen, each captured one before its coarser levels.
    std::vector<std::uint32_t> seen;
    std::uint32_t behindUnseen = 0; ///< captured images in view that unseen space hides
};

/// Metres for each metre of distance: by so much the ray of a pixel may pass beside a sample that is seen there.
double besideRay(const scene::View& eye, const Quality& quality);

/// Passes over what lies beside the eye's picture or behind it (as far outside as marginPixels counts as within), and
/// what no open way leads to. shares: of the captured images' samples, as many as are drawn; or none: all.
void findSourceViews(const SceneIndex& scene, const scene::View& eye, const Quality& quality, double marginPixels,
                     std::span<const float> shares, const scene::OpenWays& ways, SourceViews& views);

/// To each of these images, captured ones before their levels, as if all could be seen.
std::vector<SourceView> sourceViewsOf(std::span<const ResidentImage> images, const scene::View& eye,
                                      const Quality& quality);

} // namespace render
