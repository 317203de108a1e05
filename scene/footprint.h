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

/// How wide, in pixels, squares must be so that no hole opens between neighbouring samples of one disparity: the larger
/// side of the box around a projected source pixel (a parallelogram), at the worst corner of the samples' box. The
/// projected area alone would not do: at the same area, turned or sheared pixels leave holes. Infinite if the box
/// reaches behind the eye.
double sampleWidthInEye(const glm::dmat4& eyeImageFromSourceImage, const SampleBox& box);

/// Pixels by which neighbouring samples stand farther apart than that where the surface slopes, if their disparities
/// differ by a share of the box' extent, at the worst corner of the box. Infinite if it reaches behind the eye.
double slopeStepInEye(const glm::dmat4& eyeImageFromSourceImage, const SampleBox& box, double share);

/// Square pixels of the rectangle about all that the samples of a box, and what lies between them, cover in the eye's
/// plane, beyond the edges of its image, too. Infinite if the box reaches behind the eye.
double boxAreaInEye(const glm::dmat4& eyeImageFromSourceImage, const SampleBox& box);

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

/// Side of the square of pixels for the samples of a box: scale times their width, rounded up, from 1 to maxFootprint.
int footprintOf(const glm::dmat4& eyeImageFromSourceImage, const SampleBox& box, double scale, int maxFootprint);

} // namespace scene
