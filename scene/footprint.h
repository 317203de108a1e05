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

/// Side of the square of pixels for the samples of a box: scale times their width, rounded up, from 1 to maxFootprint.
int footprintOf(const glm::dmat4& eyeImageFromSourceImage, const SampleBox& box, double scale, int maxFootprint);

} // namespace scene
