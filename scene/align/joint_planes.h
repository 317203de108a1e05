#pragma once
// Poses of scans and the planes they see, adjusted together: the samples of each plane of each scan to one plane in the
// world, by least squares with a robust loss (Ceres). A scan's samples of a plane enter by their mean and covariance,
// which say the sum of their squared distances from any plane exactly, however many they are (Zhou et al., "Efficient
// second-order plane adjustment", 2023, reduce them alike).

#include "scene/align/scan_planes.h"
#include "scene/pose.h"

#include <array>
#include <vector>

namespace scene {

/// A plane of the world, seen by several scans: which, and what index it has among their planes.
struct SharedPlane {
    struct Seen {
        std::size_t scan = 0, plane = 0;
    };
    std::vector<Seen> seen;
};

/// How well a pose is known: standard deviations along and about the least certain direction, given the fixed scan.
struct PoseDeviation {
    double metres = 0, radians = 0;
    glm::dvec3 loosest{0.0}; ///< unit, in the world: the direction in which the place is least certain
};

struct JointResult {
    std::vector<Pose> worldFromScanners;
    std::vector<PoseDeviation> deviations; ///< zero for the fixed one
    double rmsMetres = 0;                  ///< of the planes' middles and of their spread, from the shared planes
    bool isHeld = false;                   ///< the shared planes hold every pose in all directions
};

/// planesOfScan: those of each scan. Scan `fixed` keeps its pose. Poses must be near: planes are matched already.
/// looseMetres: how far off the poses may still be; planes that are no farther apart all have their say.
JointResult adjustJointly(const std::vector<const std::vector<ScanPlane>*>& planesOfScan,
                          const std::vector<SharedPlane>& shared, std::vector<Pose> worldFromScanners,
                          std::size_t fixed, double looseMetres = 0);

} // namespace scene
