#pragma once
// Scattered samples of a scan -> the range image of a planar camera that stands at, or near, the scanner: a
// photograph's. Nyland et al. 1999, section 4.3 (planar projection): samples are splatted with bilinear support into a
// list for each pixel, each list is clustered by range, and the heaviest cluster gives the pixel its range. So no
// sample hangs between foreground and background, whatever the scanner's aperture averaged, and small drop-outs are
// closed.
//
//      o o o o       x: ranges averaged over both surfaces, each in a cluster of its own, of one sample
//             x
//              x o o o o o
//
// What we changed. The pixel takes the plane through its cluster's samples (in disparity, where planes are affine)
// instead of their weighted mean, which would be drawn to the side where more of them stand. A pixel without a sample
// near by takes no range, so that silhouettes before the sky do not grow by the width of the support. And where a
// silhouette runs along the scan's rows or columns, a whole line of samples is averaged alike and would be the heaviest
// cluster of the pixels along it: the scan's grid says which samples belong to neither of their neighbours and lie
// between them, or behind the one where the other gave no echo. Among leaves and rails a few samples agree by chance:
// where there are five about a pixel, two are no surface, nor are three or four between others before and behind,
// unless all of them lie on one plane, as on a far floor.

#include "scene/depth_image.h"
#include "scene/project/cube_layout.h"
#include "scene/scan.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace scene {

struct PlanarOptions {
    double support = 1.5;       ///< half of a splat's width, in the scan's spacings
    double sameSurface = 0.015; ///< neighbours in a sorted list that differ by more, relatively, are two clusters
    double noiseMetres = 0.002; ///< standard deviation of range; clusters are at least six times as wide
    double reach = 0.55;        ///< a pixel takes no range if no sample of its cluster is so near, in spacings
};

/// What must be known of a scan before it is projected.
struct ScanTraits {
    AngularSteps steps;                   ///< the scan's angular density, radians
    std::vector<std::uint8_t> isAveraged; ///< one for each point; empty where the scan has no grid to tell by

    double spacingRadians() const { return std::max(steps.horizontal, steps.vertical); }
};
ScanTraits traitsOf(const Scan& scan);

/// What the scan says about each of the camera's pixels: disparity and, from the same samples, colour (its own, or its
/// intensity: then kNoColour). Name and pose are left to the caller. Pixels that it says nothing about are kNoSurface.
/// The same bytes on any number of threads.
DepthImage projectToCamera(const Scan& scan, const ScanTraits& traits, const Pose& cameraFromScanner,
                           const Camera& camera, const PlanarOptions& options = {});

/// The standard deviation of range, metres, as the scan itself shows it: by how much samples leave the line between
/// their neighbours in the grid, on most surfaces. 0 where it has no grid.
double rangeNoiseOf(const Scan& scan);

} // namespace scene
