#pragma once
// Where the next scans should stand: places on the floor at a tripod's height from which a scan would see most of the
// space that nobody has seen yet.
//
// Candidates are places over a grid above floor that was seen, with room for a tripod and the person beside it that was
// seen empty. Each is worth the unseen cubic metres that a scan from it may be expected to see (scene/plan/scan_sight.h
// has the rule), inside the upright box about all surfaces: outside nothing is known, and what lies behind walls that
// were seen attracts nobody, since rays end there. Several are chosen one after another, each for what it sees beyond
// those before it. What is gained falls as more is chosen, so that this greedy choice is worth at least 1 - 1/e of the
// best one (Nemhauser, Wolsey, Fisher: "An analysis of approximations for maximizing submodular set functions", 1978),
// and old gains bound new ones, which saves most looks (Minoux: "Accelerated greedy algorithms", 1978).
//
// Foretold against what simulated scans then revealed, first proposals after one scan (tests/scene/plan): 0.94 of it
// for a hidden corner, 1.10 behind a pillar, 0.80 in a furnished room, 0.98 in a corridor. Second ones are rougher.
//
// Limits. What stands in unseen space is guessed from how crowded the seen part is; a closed door that was never seen
// looks like open space. Rooms beyond the box about what was seen do not count. Whether one can get to a candidate is
// not asked: seen through a window, the other side of a street is a place like any other.

#include "scene/coverage.h"
#include "scene/plan/scan_sight.h"
#include "scene/plan/upright_bounds.h"
#include "scene/pose.h"

#include <span>
#include <vector>

#include <glm/vec3.hpp>

namespace scene {

struct NextScanOptions {
    int count = 3;
    double tripodMetres = 1.5;  ///< of the scanner above its floor
    double spacingMetres = 0.4; ///< between candidates; wider where there would be more than mostCandidates
    std::size_t mostCandidates = 600;
    double clearanceMetres = 0.3;                      ///< about the tripod
    double clearFromMetres = 0.3, clearToMetres = 1.8; ///< above the floor
    double floorToleranceMetres = 0.5;                 ///< a floor may lie so far above or below walk's Y = 0
    /// Nothing may bear a tripod that is so much higher than a floor that near it: kerbs may, seats and beds may not.
    double mostRaisedMetres = 0.25, besideMetres = 1.0;
    double leastShare = 0.005;       ///< of all that is unseen; what would see less is not proposed
    double leastShareOfBox = 0.0015; ///< of the whole box: slivers along surfaces are unseen in every scene
    ScanRays rays;
};

struct NextScan {
    glm::dvec3 positionInWorld{0.0}, positionInWalk{0.0};
    double revealsCubicMetres = 0; ///< expected, beyond those proposed before
    double revealsShare = 0;       ///< of all that is unseen within the bounds
};

struct NextScanPlan {
    UprightBounds bounds;
    double unseenCubicMetres = 0; ///< within the bounds, before any of the proposals
    std::size_t candidates = 0;   ///< places where a scanner could stand
    SeenPlace seen;
    std::vector<NextScan> scans; ///< options.count or fewer: worth most first
};

/// Places (world) where a scanner could stand. Parallel.
std::vector<glm::dvec3> findStandingPlaces(const Coverage& coverage, const Pose& walkFromWorld,
                                           const UprightBounds& bounds, const NextScanOptions& options);

/// stood: where scanners or cameras stood, world. A function of its arguments alone, on any number of
/// threads.
NextScanPlan planNextScans(const Coverage& coverage, const Pose& walkFromWorld, std::span<const glm::dvec3> stood,
                           const NextScanOptions& options = {});

} // namespace scene
