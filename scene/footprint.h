#pragma once
// How large a point is drawn: one rule for the warp on the processor and on the device.
// Nyland et al. 1999, section 5.1, draws points by the projected size of a sample.

#include "scene/tile.h"

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

namespace scene {

/// Where the samples of a tile lie, (x, y, disparity), x and y at sample centres, border included.
struct SampleBox {
    glm::dvec3 least{0}, most{0};
};

SampleBox boxOf(const Tile& tile, const Camera& camera);

/// What of a tile's box says how wide its samples are seen: all of it; of scraps, which stand here and there in a box
/// of hundreds of samples and any disparity, the middle. Hardly one of them is near a corner of it, and the nearest
/// corner is often behind an eye that sees them small.
SampleBox typicalOf(const SampleBox& box, std::uint32_t placeBits);

/// How the samples of a box look from an eye, at the worst of its corners. All infinite if it reaches behind the eye.
struct BoxInEye {
    /// How wide, in pixels, squares must be so that no hole opens between neighbouring samples of one disparity: the
    /// larger side of the box around a projected source pixel (a parallelogram). The projected area alone would not do:
    /// at the same area, turned or sheared pixels leave holes.
    double sampleWidth = 0;
    /// Pixels by which neighbouring samples stand farther apart than that where the surface slopes and their
    /// disparities differ by the box' whole extent; for a share of it, that share of these.
    double slopeStep = 0;
    /// Square pixels of the rectangle about all that the samples, and what lies between them, cover in the eye's plane,
    /// beyond the edges of its image, too.
    double area = 0;
};
BoxInEye boxInEye(const glm::dmat4& eyeImageFromSourceImage, const SampleBox& box);

/// The same at the worst of what is typical of it (typicalOf); of slopeStep, for the disparities of the whole box.
BoxInEye typicalInEye(const glm::dmat4& eyeImageFromSourceImage, const SampleBox& box, std::uint32_t placeBits);

/// Square pixels that a source pixel covers in the eye's image at the middle of the box: the determinant of the warp's
/// Jacobian at constant disparity. Infinite behind the eye.
double sampleAreaInEye(const glm::dmat4& eyeImageFromSourceImage, const SampleBox& box);

/// No splat is smaller, pixels: so every sample reaches the centre of a pixel. Half a pixel's diagonal, rounded up.
inline constexpr float kLeastSplat = 0.7071068f;

/// Radius, pixels, of the circles that close the holes between the samples of a box, from kLeastSplat to maxRadius.
/// Nyland et al. 1999, section 5.4: the cube root of the determinant of C's 3 x 3 principal submatrix (the viewport's
/// scale is in ours) over a sample's w. We take the square root, since submatrix and viewport scale two axes of the
/// three: so it is right where camera and eye differ in focal length, too; and the least w of the box, once for all.
float splatRadiusOf(const glm::dmat4& eyeImageFromSourceImage, const SampleBox& box, double scale, int maxRadius);

/// Side of the square of pixels for samples of some width (BoxInEye): scale times that, rounded up, from 1 to
/// maxFootprint.
int footprintOf(double sampleWidth, double scale, int maxFootprint);

} // namespace scene
