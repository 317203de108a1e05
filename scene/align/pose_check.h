#pragma once
// Whether two scans can stand as a pose has it: each is looked at from where the other stood. A scan says where
// surfaces are, and that there is nothing between them and the scanner (Nyland et al. 1999, section 4.4, asks images
// the same; Curless and Levoy, "A volumetric method for building complex models from range images", 1996).

#include "scene/align/panorama.h"
#include "scene/pose.h"

namespace scene {

/// Shares of what was compared, by the solid angle it has in its own scan.
struct PoseEvidence {
    double agreeing = 0;    ///< of all that either scan saw: what the other saw there as well. The overlap
    double against = 0;     ///< of all: what stands where the other saw through
    double sharedCells = 0; ///< how many cells agree
    double rmsMetres = 0;   ///< between surfaces that agree, along their normals

    /// Of what both scans speak of, the share that cannot be.
    double againstShare() const { return against > 0 ? against / (agreeing + against) : 0; }
    /// What is agreed on counts for, what cannot be counts that many times against.
    double score(double timesAgainst) const { return agreeing - timesAgainst * against; }
};

struct PoseCheckOptions {
    int stride = 1; ///< of the cells that are looked up, each way; in the coarsest panorama's
    double toleranceMetres = 0.04, toleranceShare = 0.01; ///< of range
};

/// aFromB: what is judged.
PoseEvidence checkPose(const Panorama& a, const Panorama& b, const Pose& aFromB, const PoseCheckOptions& options = {});

} // namespace scene
