#pragma once
// The last word on poses: all that scans have in common, plane or not, laid on each other at once. Each cell of one
// scan's panorama to the surface that the other saw in the same direction, along its normal (Chen and Medioni, "Object
// modelling by registration of multiple range images", 1992; many scans at once as Pulli, "Multiview registration for
// large data sets", 1999), by Gauss-Newton with Cauchy's weights. Planes alone are not exact enough: a rug, a skirting
// board, a picture on a wall belong to one plane from here and to another from there.

#include "scene/align/joint_planes.h"
#include "scene/align/panorama.h"
#include "scene/pose.h"

#include <utility>
#include <vector>

namespace scene {

struct SurfaceOptions {
    int passes = 12;
    int stride = 1;                ///< of the cells that are compared, each way; in the coarsest panorama's
    double widestMetres = 0.08;    ///< how far surfaces may be apart at first
    double narrowestMetres = 0.01; ///< and at last, where noise is less than a third of it
};

/// pairs: which scans are compared. Scan `fixed` keeps its pose; every other must be joined to it by pairs.
JointResult layOnSurfaces(const std::vector<const Panorama*>& panoramas,
                          const std::vector<std::pair<std::size_t, std::size_t>>& pairs,
                          std::vector<Pose> worldFromScanners, std::size_t fixed, const SurfaceOptions& options = {});

} // namespace scene
