#pragma once
// How two scans might stand to each other, from their planes alone and with nothing known: pairs of directions that
// planes face give rotations (closed form: Kabsch, "A solution for the best rotation to relate two sets of vectors",
// 1976), triples of planes in three directions give a place, and each votes. What repeats gives several candidates.

#include "scene/align/scan_planes.h"
#include "scene/pose.h"

#include <vector>

namespace scene {

struct PlaneMatch {
    std::size_t a = 0, b = 0;
};

struct PoseCandidate {
    Pose aFromB;
    std::vector<PlaneMatch> matches;
    double votes = 0;
};

struct CandidateOptions {
    int most = 60;              ///< that are returned
    double sameRadians = 0.05;  ///< between directions of one plane in both scans
    double sameMetres = 0.08;   ///< between offsets of one plane in both scans
    double farthestMetres = 60; ///< between the two scanners
};

/// Best first; none where the planes of either face less than three directions. A function of its input alone.
std::vector<PoseCandidate> findCandidates(const std::vector<ScanPlane>& a, const std::vector<ScanPlane>& b,
                                          const CandidateOptions& options = {});

/// The pose that lays matched planes of b on those of a best; false where they leave it open.
bool poseFromMatches(const std::vector<ScanPlane>& a, const std::vector<ScanPlane>& b,
                     const std::vector<PlaneMatch>& matches, Pose& aFromB);

} // namespace scene
