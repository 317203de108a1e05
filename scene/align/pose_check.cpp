#include "scene/align/pose_check.h"

#include <algorithm>
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

/// What was seen about a place of the panorama: 3 x 3 cells.
struct Surroundings {
    double nearest = 1e30, farthest = 0;
    bool isWhole = true; ///< each of the cells saw something
};

Surroundings lookAbout(const Panorama& panorama, const std::array<int, 2>& place) {
    Surroundings about;
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
            const int y = std::clamp(place[1] + dy, 0, panorama.height() - 1);
            const PanoramaCell& cell = panorama.cells((place[0] + dx + panorama.width()) % panorama.width(), y);
            if (cell.samples == 0) {
                about.isWhole = false;
                continue;
            }
            about.nearest = std::min(about.nearest, static_cast<double>(cell.nearest));
            about.farthest = std::max(about.farthest, static_cast<double>(cell.farthest));
        }
    return about;
}

/// What `from` saw, in the panorama of `to`.
void compare(const Panorama& from, const Panorama& to, const Pose& toFromFrom, const PoseCheckOptions& options,
             Tally& tally) {
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
            const PanoramaCell& seen = to.cells((*place)[0], (*place)[1]);
            if (seen.samples == 0) continue;
            const double range = glm::length(p), tolerance = options.toleranceMetres + options.toleranceShare * range;
            const Surroundings about = lookAbout(to, *place);
            if (range < about.nearest - tolerance) {
                if (about.isWhole) tally.against += weight;
            } else if (range <= about.farthest + tolerance && seen.normal != glm::vec3(0)) {
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
