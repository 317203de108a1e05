#pragma once
// Two scans registered without a person: candidates from planes, each made exact, then judged by what both scans saw,
// surfaces and free space. Where several survive, the pair is ambiguous, and says so.

#include "scene/align/joint_planes.h"
#include "scene/align/panorama.h"
#include "scene/align/plane_candidates.h"
#include "scene/align/pose_check.h"
#include "scene/image.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

namespace scene {

/// A cell of the panorama that lies on a plane.
struct CellOnPlane {
    glm::vec3 point{0.0f}; ///< metres, the scanner's frame
    std::int32_t plane = 0;
};

/// What registration keeps of a scan.
struct ScanView {
    std::string name;
    Pose givenWorldFromScanner;
    Panorama panorama;
    std::vector<ScanPlane> planes;
    double medianRangeMetres = 0;

    // What the panorama says of planes once more and close together, since it is asked for every pose that is tried.
    std::vector<CellOnPlane> cellsOnPlanes; ///< of every so many rows and columns
    Image<std::int32_t> planeAt;            ///< as PanoramaCell::plane
};

ScanView viewOf(const Scan& scan);

/// After the panorama or its planes have changed.
void listPlanes(ScanView& view);

enum class PairVerdict {
    registered,   ///< one pose fits, and nothing else does
    ambiguous,    ///< several poses fit
    contradicted, ///< the best pose that was found has surfaces where the other scan saw through
    loose,        ///< what the scans share leaves the pose open in some direction
    apart,        ///< no pose fits: too little in common
};

struct PairOptions {
    CandidateOptions candidates;
    double leastOverlap = 0.12; ///< of what either saw
    /// Of PoseEvidence::againstShare. True poses of simulated scans seldom have more than 0.002, wrong ones more than
    /// 0.004, but in corridors once 0.0026: better one pose too few than one that is wrong;
    /// where somebody says that the scans stand about so, people who walked by may have left traces.
    double mostAgainstShare = 0.002, mostAgainstShareGiven = 0.02;
    /// A second pose makes the pair ambiguous if it has no more than this against it.
    double mostAgainstShareRival = 0.004;
    int leastSharedPlanes = 3;
};

struct PairFit {
    Pose aFromB;
    PoseEvidence evidence;
    std::vector<PlaneMatch> matches; ///< by what was seen: a plane may match several pieces
    double rmsMetres = 0;
    PoseDeviation deviation; ///< directions in a's frame
    bool isHeld = false;
};

struct PairResult {
    PairVerdict verdict = PairVerdict::apart;
    PairFit best;                 ///< also where it is not believed
    std::optional<PairFit> rival; ///< the next best that stands elsewhere
    std::vector<Pose> plausible;  ///< aFromB of all that fit, the best first
    bool isDecidedByGivenPose = false;
};

/// Whether the two are different answers, not one answer found less exactly.
bool areElsewhere(const Pose& a, const Pose& b);

/// Planes of both that lie on each other as a pose has it, by what stands in the same direction at the same range.
std::vector<PlaneMatch> planesThatMeet(const ScanView& a, const ScanView& b, const Pose& aFromB, double metres);

/// From near a pose to the one that lays planes on each other best; none where too few meet. Not checked yet.
std::optional<PairFit> settleOnPlanes(const ScanView& a, const ScanView& b, const Pose& aFromB,
                                      const PairOptions& options);

/// The same, and then by all that both saw (joint_surfaces.h); with what speaks for it and against it.
std::optional<PairFit> settlePair(const ScanView& a, const ScanView& b, const Pose& aFromB, const PairOptions& options);

/// roughAFromB: where somebody says they stand, if anybody does: one of several poses that fit is then taken if it is
/// the only one about there.
PairResult registerPair(const ScanView& a, const ScanView& b, const std::optional<Pose>& roughAFromB,
                        const PairOptions& options = {});

} // namespace scene
