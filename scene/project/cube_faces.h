#pragma once
// A scan around a scanner -> planar depth images on the six faces of a cube about it, at the scan's own
// angular density. Nyland et al. 1999, section 4.3 (planar projection), for scans on a regular grid and for
// loose points.

#include "scene/cube.h"
#include "scene/depth_image.h"
#include "scene/scan.h"

#include <functional>
#include <vector>

namespace scene {

struct CubeFaceOptions {
    int maxFaceSize = 16384;            ///< pixels; a denser scan is projected at this size and the report says so
    double sameSurface = 0.02;          ///< relative range difference up to which neighbours are one surface
    int maxLayers = kMostFurtherLayers; ///< further images of a face for points that share a pixel but not a surface
    bool opensSky = false; ///< the scan was taken under the open sky (scene/project/open_sky.h): isOpenSky samples
};

/// What became of the points.
struct CubeFaceReport {
    std::int64_t points = 0;  ///< in the scan
    std::int64_t held = 0;    ///< stand as a sample of some face: the sample of their pixel is on their surface
    std::int64_t dropped = 0; ///< at the scanner's origin, or deeper than maxLayers
    std::int64_t pixels = 0;  ///< with points of their own; between them lies the mesh of the scan's grid
    double columnStepRadians = 0, rowStepRadians = 0; ///< the scan's angular density
    bool coarserThanScan = false;                     ///< that density was not allowed: pixels hold several points
    double skyShare = 0;                              ///< of the grid's cells that are open sky, where it was asked for
    bool isFromElsewhere = false; ///< not seen from the scanner's place: faces look from one amid the points
};

/// Is given the images of one face, its further layers after the first.
using TakeFace = std::function<void(std::vector<DepthImage>)>;

/// One face after the other, in the calling thread, none of which is held once it is taken: those of a dense scan take
/// as much memory together as the scan itself, or more. Images are named SCAN-front, -left, ...; layers get -2, -3,
/// ...; faces without a point and without sky are left out.
CubeFaceReport projectToCubeFaces(const Scan& scan, const CubeFaceOptions& options, const TakeFace& take);

struct CubeFaces {
    std::vector<DepthImage> faces; ///< with their layers
    CubeFaceReport report;
};

/// All of them at once.
CubeFaces projectToCubeFaces(const Scan& scan, const CubeFaceOptions& options = {});

} // namespace scene
