#pragma once
// The quality end: what is shown at a pixel is the mean of all samples that mean its surface, each with its confidence.
//
// Two passes. The first finds the front surface of every pixel (scene/warp.h). The second warps the samples of all
// images that look from about there once more, and adds those that stand at the front surface's depth. Sums are whole
// numbers, so that they do not depend on the order of adding.
//
// A sample is an elliptical spot that falls off smoothly from its centre (Heckbert: "Fundamentals of texture mapping
// and image warping", 1989, section 3.5, elliptical weighted averages; Zwicker, Pfister, van Baar, Gross: "Surface
// splatting", 2001): its pixel's outline as the eye sees it, wide enough that neighbours overlap, and never narrower
// than the eye's own pixels. A spot counts by its area, so that each image counts alike however densely it samples;
// what makes images count differently is where they were taken from (Buehler, Bosse, McMillan, Gortler, Cohen:
// "Unstructured lumigraph rendering", 2001, section 4: angle first).

#include "scene/footprint.h"
#include "scene/preference.h"
#include "scene/warp.h"

#include <cstddef>
#include <optional>

namespace scene {

struct BlendOptions {
    /// Images taken from farther from the eye than this share of the eye's distance to the surface are left out.
    float baseline = 0.25f;
    /// At this share of the distance an image counts a quarter of one taken from where the eye is.
    float quarterBaseline = 0.05f;
    /// A sample means the front surface if it would be seen, at that surface's depth, less than this angle (radians,
    /// about) beside where it is: so images from near the eye are believed about silhouettes, whose depth nobody
    /// measured well, and images from far away only where depths agree.
    float parallax = 0.01f;
    float depthTolerance = 0.05f; ///< relative difference of disparity up to which it always does
    /// Of a spot, in samples of its image; and what that is widened by, in the eye's pixels. Their squares are less
    /// than 1 together, so that an eye of its resolution gets an image back exactly where it was taken.
    float samplesRadius = 0.75f, pixelsRadius = 0.65f;
    float maxRadius = 16.f; ///< spots that reach farther, pixels, are left out: the front surface is shown alone
    friend bool operator==(const BlendOptions&, const BlendOptions&) = default;
};

/// The spot that every sample of a tile becomes. At an offset (x, y) from its centre, pixels, it counts
/// weight (1 - q)^2 where q = xx x^2 + xy x y + yy y^2 is less than 1.
struct BlendSpot {
    float xx = 0, xy = 0, yy = 0; ///< 1 / pixels^2
    float reachX = 0, reachY = 0; ///< half the sides of the box around it, pixels
    float weight = 0;             ///< greater than 0; at most 1
    float tolerance = 0;          ///< relative difference of disparity up to which a sample means the front surface
};

/// What a tile's samples become for an eye that stands eyeFromCamera (metres, in the world) away from its camera; none
/// if they are left out. box: where its samples lie.
std::optional<BlendSpot> blendSpotOf(const glm::dmat4& eyeImageFromSourceImage, const SampleBox& box,
                                     const TileMiddle& middle, const glm::dvec3& eyeFromCamera,
                                     const BlendOptions& options);

/// What weight 1 is as a whole number: as fine as the sums allow that 32 bits hold, if so many images were all taken
/// from where the eye is and eight samples of each fell where one is expected.
float blendUnitOf(std::size_t images);

/// Sums of a pixel: over all samples, weight times channel, and weight, as whole numbers.
struct BlendSums {
    std::uint32_t red = 0, green = 0, blue = 0, weight = 0;
    friend bool operator==(const BlendSums&, const BlendSums&) = default;
};

/// Adds the samples of all tiles that stand at the front surface of zBuffer (of the eye's size) and have its class.
/// Parallel; the sums do not depend on the number of threads.
Image<BlendSums> warpBlend(std::span<const TileBlock> blocks, const View& eye, const BlendOptions& options,
                           const ZBuffer& zBuffer);

/// As resolve of the z-buffer alone, with the mean colour wherever anything was added.
EyeImage resolve(const ZBuffer& zBuffer, const Image<BlendSums>& sums);

} // namespace scene
