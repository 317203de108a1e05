#pragma once
// A scan's grid as a mesh, drawn onto a face of the cube: the triangle that is seen at each pixel centre.

#include "scene/image.h"
#include "scene/project/colour_mean.h"
#include "scene/project/cube_layout.h"
#include "scene/project/scan_grid.h"
#include "scene/scan.h"

#include <array>
#include <bit>
#include <cstdint>

namespace scene {

/// What the mesh shows at a pixel: the bits of its disparity (float, 1/m) above the number of its triangle,
/// so that of two the nearer is the larger number and the order in which they are drawn does not matter. 0:
/// nothing.
using MeshPixel = std::uint64_t;

inline MeshPixel meshPixel(float disparity, std::uint32_t triangle) {
    return MeshPixel{std::bit_cast<std::uint32_t>(disparity)} << 32 | triangle;
}
inline float disparityOf(MeshPixel pixel) {
    return std::bit_cast<float>(static_cast<std::uint32_t>(pixel >> 32));
}
inline std::uint32_t triangleOf(MeshPixel pixel) {
    return static_cast<std::uint32_t>(pixel);
}

/// Draws every triangle of neighbouring cells that are linked along both of its sides. Disparity is
/// interpolated as an affine function of the image, which is exact for planes.
Image<MeshPixel> drawGrid(const Scan& scan, const ScanGrid& grid, const CubeFrame& frame, int face,
                          const Camera& camera);

/// The points at a triangle's corners.
std::array<std::int32_t, 3> cornersOf(const ScanGrid& grid, std::uint32_t triangle);

/// The triangle's colour at a place of the image, between those of its corners.
ColourMean colourAt(const Scan& scan, const std::array<std::int32_t, 3>& corners, const CubeFrame& frame, int face,
                    const Camera& camera, double x, double y);

} // namespace scene
