#include "scene/align/pose_check.h"

#include "scene/align/panorama_places.h"

#include <cassert>
#include <cmath>
#include <vector>

#include <glm/geometric.hpp>

namespace scene {

namespace {

constexpr double kComparableNormal = 0.8; ///< cosine
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
    PanoramaPlaces places;
    std::vector<const PanoramaCell*> asked;
    for (int y = 0; y < from.height(); y += stride) {
        const double weight = from.weightOf(y);
        places.clear(), asked.clear();
        for (int x = 0; x < from.width(); x += stride) {
            const PanoramaCell& cell = from.cells(x, y);
            if (cell.samples == 0 || cell.normal == glm::vec3(0) || isMixed(cell)) continue;
            tally.all += weight;
            places.add(cell.point), asked.push_back(&cell);
        }
        places.find(toFromFrom, to.height());
        for (int i = 0; i < places.count(); ++i) {
            if (places.cell(i) < 0) continue;
            const auto at = static_cast<std::size_t>(places.cell(i));
            const PanoramaAbout& about = to.about.pixels()[at];
            if (!about.isSeen) continue;
            const glm::dvec3 p = places.point(i);
            const double range = glm::length(p), tolerance = options.toleranceMetres + options.toleranceShare * range;
            if (range < double{about.nearest} - tolerance) {
                if (about.isWhole) tally.against += weight;
            } else if (range <= double{about.farthest} + tolerance) {
                const PanoramaCell& seen = to.cells.pixels()[at];
                if (seen.normal == glm::vec3(0)) continue;
                const glm::dvec3 normal = toFromFrom.rotation * glm::dvec3(asked[static_cast<std::size_t>(i)]->normal);
                const double off = glm::dot(glm::dvec3(seen.normal), p - glm::dvec3(seen.point));
                if (glm::dot(glm::dvec3(seen.normal), normal) < kComparableNormal || std::abs(off) > tolerance)
                    continue;
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
