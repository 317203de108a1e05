#include "scene/align/pose_check.h"

#include <cassert>
#include <cmath>

#include <glm/geometric.hpp>

namespace scene {

namespace {

constexpr double kSameNormal = 0.8;  ///< cosine
constexpr double kMixedShare = 0.04; ///< of range: cells whose samples spread more lie at a silhouette, and say nothing

struct Tally {
    double all = 0, agreeing = 0, against = 0, cells = 0, squares = 0;
};

bool isMixed(const PanoramaCell& cell) {
    return cell.farthest - cell.nearest > 0.05f + static_cast<float>(kMixedShare) * cell.farthest;
}

/// What `from` saw, in the panorama of `to`.
void compare(const Panorama& from, const Panorama& to, const Pose& toFromFrom, const PoseCheckOptions& options,
             Tally& tally) {
    assert(to.about.size() == to.cells.size());
    const int stride = options.stride * from.finerThanCoarse();
    for (int y = 0; y < from.height(); y += stride) {
        const double weight = from.weightOf(y);
        for (int x = 0; x < from.width(); x += stride) {
            const PanoramaCell& cell = from.cells(x, y);
            if (cell.samples == 0 || cell.normal == glm::vec3(0) || isMixed(cell)) continue;
            tally.all += weight;
            const glm::dvec3 p = toFromFrom * glm::dvec3(cell.point);
            const auto place = to.placeOf(p);
            if (!place) continue;
            const PanoramaAbout& about = to.about((*place)[0], (*place)[1]);
            if (!about.isSeen) continue;
            const double range = glm::length(p), tolerance = options.toleranceMetres + options.toleranceShare * range;
            if (range < double{about.nearest} - tolerance) {
                if (about.isWhole) tally.against += weight;
            } else if (range <= double{about.farthest} + tolerance) {
                const PanoramaCell& seen = to.cells((*place)[0], (*place)[1]);
                if (seen.normal == glm::vec3(0)) continue;
                const glm::dvec3 normal = toFromFrom.rotation * glm::dvec3(cell.normal);
                const double off = glm::dot(glm::dvec3(seen.normal), p - glm::dvec3(seen.point));
                if (glm::dot(glm::dvec3(seen.normal), normal) < kSameNormal || std::abs(off) > tolerance) continue;
                tally.agreeing += weight;
                tally.cells += 1;
                tally.squares += off * off;
            }
        }
    }
}

} // namespace

PoseEvidence checkPose(const Panorama& a, const Panorama& b, const Pose& aFromB, const PoseCheckOptions& options) {
    Tally tally;
    compare(b, a, aFromB, options, tally);
    compare(a, b, inverse(aFromB), options, tally);
    PoseEvidence evidence;
    if (tally.all > 0) {
        evidence.agreeing = tally.agreeing / tally.all;
        evidence.against = tally.against / tally.all;
    }
    evidence.sharedCells = tally.cells;
    evidence.rmsMetres = tally.cells > 0 ? std::sqrt(tally.squares / tally.cells) : 0;
    return evidence;
}

} // namespace scene
