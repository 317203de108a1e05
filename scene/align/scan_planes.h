#pragma once
// The planes of a scan: walls, floors, table tops. Regions of its panorama grow from the smoothest cells over
// neighbours with the same plane (Poppinga et al., "Fast plane detection and polygonalization in noisy 3D range
// images", 2008); each is then fitted again to all samples of the scan that lie on it.

#include "scene/align/panorama.h"
#include "scene/scan.h"

#include <array>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

namespace scene {

/// In the scanner's frame, metres. It is seen from the side that its normal points to.
struct ScanPlane {
    glm::dvec3 normal{0, 0, 1}; ///< unit, towards the scanner
    double offset = 0;          ///< dot(normal, p) of its points; negative
    glm::dvec3 middle{0.0};     ///< mean of its samples
    glm::dmat3 covariance{0.0}; ///< of its samples about the middle, square metres: its extent, and its noise
    double noiseMetres = 0;     ///< standard deviation of samples from it
    double areaSquareMetres = 0;
    std::int64_t samples = 0;
    int cells = 0; ///< of the panorama

    /// Standard deviation of the offset at the middle, and of the tilt about an axis in the plane along which the
    /// samples spread by spreadMetres.
    double offsetDeviation() const;
    double tiltDeviation(double spreadMetres) const;
};

struct ScanPlaneOptions {
    int leastCells = 40;     ///< of the panorama, if it is coarse; of so many coarse ones if it is finer
    double leastArea = 0.04; ///< square metres
    int most = 60;           ///< the largest by what they cover of the view and in metres are kept
};

/// The planes, largest first; cells of the panorama are given the index of theirs. `scan` is the one that the panorama
/// was made of.
std::vector<ScanPlane> planesOf(const Scan& scan, Panorama& panorama, const ScanPlaneOptions& options = {});

} // namespace scene
