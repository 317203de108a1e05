#include "scene/plan/next_scan.h"

#include "scene/directions.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include <glm/geometric.hpp>

#include <tbb/parallel_for.h>

namespace scene {

namespace {

constexpr std::size_t kRays = 2048;        ///< from a candidate
constexpr std::size_t kDenseRays = 8192;   ///< from one that was chosen: they say what is seen of each voxel
constexpr double kNeighbourRadians = 0.25; ///< rays no farther apart may look at the same surface
constexpr double kVoxels = 4096;           ///< of unseen space
constexpr double kLeastVoxelMetres = 0.05;
constexpr int kMostAcross = 6;     ///< voxels that a ray speaks for, across
constexpr std::size_t kBatch = 16; ///< candidates that are looked from again at a time

/// The bounds in voxels: the chance that one of the chosen scans sees what is unseen in each.
class UnseenVoxels {
  public:
    UnseenVoxels(const UprightBounds& bounds, double unseenCubicMetres) {
        edge_ = std::max(kLeastVoxelMetres, std::cbrt(unseenCubicMetres / kVoxels));
        // A box of which hardly anything is unseen still must fit into memory.
        edge_ = std::max(edge_, std::cbrt(bounds.cubicMetres() / (64 * kVoxels)));
        std::size_t count = 1;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            counts_[axis] = static_cast<std::size_t>(std::ceil(bounds.size[static_cast<int>(axis)] / edge_));
            count *= counts_[axis];
        }
        taken_.resize(count, 0.0f);
    }

    double edge() const { return edge_; }
    std::size_t size() const { return taken_.size(); }
    std::size_t at(const glm::dvec3& pInBounds) const {
        std::size_t index = 0;
        for (std::size_t axis = 3; axis-- > 0;) {
            const double place = std::floor(pInBounds[static_cast<int>(axis)] / edge_);
            index = index * counts_[axis] +
                    static_cast<std::size_t>(std::clamp(place, 0.0, static_cast<double>(counts_[axis] - 1)));
        }
        return index;
    }
    double taken(std::size_t voxel) const { return static_cast<double>(taken_[voxel]); }
    /// The chance that a scan sees what is unseen in each voxel.
    void take(const std::vector<double>& chances) {
        for (std::size_t i = 0; i < taken_.size(); ++i)
            taken_[i] = std::max(taken_[i], static_cast<float>(chances[i]));
    }

  private:
    double edge_ = 1;
    std::array<std::size_t, 3> counts_{};
    std::vector<float> taken_;
};

/// Directions in the axes of the bounds, and which are beside which.
struct Rays {
    Rays(int count, const ScanRays& rays)
        : directions(spreadDirections(count, std::sin(rays.lowestRadians))),
          neighbours(neighboursOf(directions, kNeighbourRadians)) {}
    std::vector<glm::dvec3> directions;
    std::vector<std::vector<std::uint32_t>> neighbours;
};

struct Place {
    const Coverage& coverage;
    const UprightBounds& bounds;
    const SeenPlace& seen;
    const ScanRays& rays;
};

/// Walks the unseen parts of the rays about a place, in steps no longer than a voxel: visit(place in the
/// bounds, the ray's width there, cubic metres, chance that a scan sees them).
template <class Visit>
void lookRound(const Place& place, const glm::dvec3& from, const Rays& rays, const UnseenVoxels& voxels,
               Visit&& visit) {
    const glm::dmat3 worldFromBounds = inverse(place.bounds.boundsFromWorld).rotation;
    const glm::dvec3 origin = place.bounds.boundsFromWorld * from;
    const std::vector<glm::dvec3>& directions = rays.directions;
    const double third = solidAngleOf(place.rays) / static_cast<double>(directions.size()) / 3;
    const double width = std::sqrt(3 * third); // of a ray's share of the sphere
    std::vector<SightLine> lines(directions.size());
    for (std::size_t i = 0; i < lines.size(); ++i)
        follow(place.coverage, place.bounds, from, worldFromBounds * directions[i], place.rays.farthestMetres,
               lines[i]);
    continueSurfaces(lines, rays.neighbours);
    for (std::size_t i = 0; i < lines.size(); ++i) {
        const SightLine& line = lines[i];
        const glm::dvec3& direction = directions[i];
        if (line.unseen.empty()) continue;
        const SightChance chance(line, place.seen, std::asin(std::clamp(direction.y, -1.0, 1.0)));
        double passed = 0;
        for (const UnseenStretch& stretch : line.unseen) {
            const int steps = static_cast<int>(std::ceil((stretch.to - stretch.from) / voxels.edge()));
            const double step = (stretch.to - stretch.from) / std::max(1, steps);
            for (int k = 0; k < steps; ++k) {
                const double r = stretch.from + k * step, next = r + step, middle = r + 0.5 * step;
                visit(origin + middle * direction, middle * width, third * (next * next * next - r * r * r),
                      chance.after(passed + (k + 0.5) * step));
            }
            passed += stretch.to - stretch.from;
        }
    }
}

/// Cubic metres that a scan from there is expected to see beyond what the chosen ones see.
double gainOf(const Place& place, const glm::dvec3& from, const Rays& rays, const UnseenVoxels& voxels) {
    double gain = 0;
    lookRound(place, from, rays, voxels, [&](const glm::dvec3& p, double, double cubicMetres, double chance) {
        gain += cubicMetres * std::max(0.0, chance - voxels.taken(voxels.at(p)));
    });
    return gain;
}

/// The mean chance, over the rays that pass each voxel: far away, a ray speaks for all that it is wide.
std::vector<double> chancesOf(const Place& place, const glm::dvec3& from, const Rays& rays,
                              const UnseenVoxels& voxels) {
    std::vector<double> seen(voxels.size(), 0.0), passed(voxels.size(), 0.0);
    lookRound(place, from, rays, voxels, [&](const glm::dvec3& p, double width, double cubicMetres, double chance) {
        const int n = std::min(kMostAcross, 1 + static_cast<int>(width / voxels.edge()));
        for (int k = 0; k < n * n * n; ++k) {
            const glm::dvec3 share = (glm::dvec3(k % n, k / n % n, k / n / n) + 0.5) / static_cast<double>(n) - 0.5;
            const std::size_t voxel = voxels.at(p + width * share);
            seen[voxel] += cubicMetres * chance, passed[voxel] += cubicMetres;
        }
    });
    for (std::size_t i = 0; i < seen.size(); ++i)
        if (passed[i] > 0) seen[i] /= passed[i];
    return seen;
}

struct Floor {
    double metres = 0;     ///< above walk's
    double coarseness = 0; ///< it may lie so much lower
};

/// The floor under a place in walk space, looked for from the tripod's height down; nothing where it was not seen.
std::optional<Floor> floorUnder(const Coverage& coverage, const Pose& walkFromWorld, const glm::dvec3& fromInWalk,
                                const NextScanOptions& options) {
    SightLine line;
    const Pose worldFromWalk = inverse(walkFromWorld);
    follow(coverage, wholeCube(coverage), worldFromWalk * fromInWalk, worldFromWalk.rotation * glm::dvec3(0, -1, 0),
           fromInWalk.y + options.floorToleranceMetres, line);
    if (!line.endsAtSurface || !line.unseen.empty()) return std::nullopt;
    const double floor = fromInWalk.y - line.endMetres;
    // The cell's upper face; the floor is somewhere in the cell, and walk's own floor is known better.
    const auto cell = cellAt(coverage, worldFromWalk * glm::dvec3(fromInWalk.x, floor - 1e-6, fromInWalk.z));
    if (floor >= 0 && cell && floor <= cell->edgeMetres) return Floor{};
    if (std::abs(floor) > options.floorToleranceMetres) return std::nullopt;
    return Floor{floor, cell ? cell->edgeMetres : 0};
}

/// Whether space was seen empty all the way from a place to one beside it, walk.
bool isOpenTo(const Coverage& coverage, const Pose& walkFromWorld, const glm::dvec3& from, const glm::dvec3& to) {
    const Pose worldFromWalk = inverse(walkFromWorld);
    SightLine line;
    follow(coverage, wholeCube(coverage), worldFromWalk * from, worldFromWalk.rotation * glm::normalize(to - from),
           glm::distance(from, to), line);
    return !line.endsAtSurface && line.unseen.empty();
}

/// Whether what bears the tripod is raised above floor that was seen beside it, as seats, beds and tables are; what
/// lies behind a wall is not beside it.
bool isRaised(const Coverage& coverage, const Pose& walkFromWorld, const glm::dvec3& tripodInWalk, const Floor& floor,
              const NextScanOptions& options) {
    constexpr int kRings = 2, kSpokes = 12;
    for (int k = 0; k < kRings * kSpokes; ++k) {
        const double radius = options.besideMetres * (1 + k / kSpokes) / kRings;
        const double angle = 2 * 3.14159265358979323846 * k / kSpokes;
        const glm::dvec3 beside = tripodInWalk + radius * glm::dvec3(std::cos(angle), 0, std::sin(angle));
        const std::optional<Floor> other = floorUnder(coverage, walkFromWorld, beside, options);
        if (other && floor.metres - other->metres > options.mostRaisedMetres + floor.coarseness &&
            isOpenTo(coverage, walkFromWorld, tripodInWalk, beside))
            return true;
    }
    return false;
}

/// Whether an upright cylinder was seen empty, at points a hand apart.
bool isClear(const Coverage& coverage, const Pose& worldFromWalk, const glm::dvec3& floorInWalk,
             const NextScanOptions& options) {
    constexpr int kRings = 3, kSpokes = 12;
    constexpr double kStepMetres = 0.1;
    const int levels = 1 + static_cast<int>(std::ceil((options.clearToMetres - options.clearFromMetres) / kStepMetres));
    for (int level = 0; level < levels; ++level) {
        const double y = std::min(options.clearFromMetres + level * kStepMetres, options.clearToMetres);
        for (int k = 0; k <= kRings * kSpokes; ++k) {
            const double radius = options.clearanceMetres * ((k + kSpokes - 1) / kSpokes) / kRings;
            const double angle = 2 * 3.14159265358979323846 * k / kSpokes;
            const glm::dvec3 p =
                worldFromWalk * (floorInWalk + glm::dvec3(radius * std::cos(angle), y, radius * std::sin(angle)));
            if (observedAt(coverage, p) != Observed::empty) return false;
        }
    }
    return true;
}

} // namespace

std::vector<glm::dvec3> findStandingPlaces(const Coverage& coverage, const Pose& walkFromWorld,
                                           const UprightBounds& bounds, const NextScanOptions& options) {
    if (bounds.isEmpty()) return {};
    const Pose worldFromWalk = inverse(walkFromWorld), worldFromBounds = inverse(bounds.boundsFromWorld);
    const auto placesAt = [&](double spacing) {
        const auto columns = static_cast<std::size_t>(std::max(1.0, std::floor(bounds.size.x / spacing)));
        const auto rows = static_cast<std::size_t>(std::max(1.0, std::floor(bounds.size.z / spacing)));
        std::vector<std::vector<glm::dvec3>> found(rows);
        tbb::parallel_for(std::size_t{0}, rows, [&](std::size_t row) {
            for (std::size_t column = 0; column < columns; ++column) {
                const glm::dvec3 ground(
                    (static_cast<double>(column) + 0.5) / static_cast<double>(columns) * bounds.size.x, 0,
                    (static_cast<double>(row) + 0.5) / static_cast<double>(rows) * bounds.size.z);
                glm::dvec3 at = walkFromWorld * (worldFromBounds * ground);
                at.y = options.tripodMetres;
                const std::optional<Floor> floor = floorUnder(coverage, walkFromWorld, at, options);
                if (!floor || !isClear(coverage, worldFromWalk, {at.x, floor->metres, at.z}, options) ||
                    isRaised(coverage, walkFromWorld, at, *floor, options))
                    continue;
                found[row].push_back(worldFromWalk * glm::dvec3(at.x, floor->metres + options.tripodMetres, at.z));
            }
        });
        std::vector<glm::dvec3> places;
        for (const std::vector<glm::dvec3>& part : found)
            places.insert(places.end(), part.begin(), part.end());
        return places;
    };
    // A grid that is not much larger than what may be found on it is tried at all.
    double spacing = std::max(options.spacingMetres, std::sqrt(bounds.size.x * bounds.size.z /
                                                               (16.0 * static_cast<double>(options.mostCandidates))));
    std::vector<glm::dvec3> places = placesAt(spacing);
    while (places.size() > options.mostCandidates)
        places = placesAt(spacing *= 1.25);
    return places;
}

NextScanPlan planNextScans(const Coverage& coverage, const Pose& walkFromWorld, std::span<const glm::dvec3> stood,
                           const NextScanOptions& options) {
    NextScanPlan plan;
    plan.bounds = findUprightBounds(coverage, walkFromWorld);
    if (plan.bounds.isEmpty()) return plan;
    plan.unseenCubicMetres = unseenWithin(coverage, plan.bounds);
    plan.seen = learnFromSeen(coverage, plan.bounds, stood, options.rays);
    const std::vector<glm::dvec3> places = findStandingPlaces(coverage, walkFromWorld, plan.bounds, options);
    plan.candidates = places.size();
    if (places.empty() || plan.unseenCubicMetres <= 0) return plan;

    UnseenVoxels voxels(plan.bounds, plan.unseenCubicMetres);
    const Place place{coverage, plan.bounds, plan.seen, options.rays};
    const Rays rays(kRays, options.rays), dense(kDenseRays, options.rays);
    struct Candidate {
        std::size_t place = 0;
        double gain = 0;
        std::size_t chosenThen = 0; ///< when the gain was looked at, so many were chosen
    };
    std::vector<Candidate> candidates(places.size());
    tbb::parallel_for(std::size_t{0}, candidates.size(), [&](std::size_t i) {
        candidates[i] = {i, gainOf(place, places[i], rays, voxels), 0};
    });
    const auto isBetter = [](const Candidate& a, const Candidate& b) {
        return a.gain != b.gain ? a.gain > b.gain : a.place < b.place;
    };
    while (plan.scans.size() < static_cast<std::size_t>(std::max(0, options.count)) && !candidates.empty()) {
        const std::size_t chosen = plan.scans.size();
        while (true) {
            std::sort(candidates.begin(), candidates.end(), isBetter);
            if (candidates.front().chosenThen == chosen) break;
            tbb::parallel_for(std::size_t{0}, std::min(kBatch, candidates.size()), [&](std::size_t i) {
                Candidate& candidate = candidates[i];
                if (candidate.chosenThen == chosen) return;
                candidate = {candidate.place, gainOf(place, places[candidate.place], rays, voxels), chosen};
            });
        }
        const glm::dvec3& best = places[candidates.front().place];
        const double gain = gainOf(place, best, dense, voxels); // the best of many looks is one that erred upwards
        if (gain < options.leastShare * plan.unseenCubicMetres ||
            gain < options.leastShareOfBox * plan.bounds.cubicMetres())
            break;
        plan.scans.push_back({best, walkFromWorld * best, gain, std::min(1.0, gain / plan.unseenCubicMetres)});
        voxels.take(chancesOf(place, best, dense, voxels));
        candidates.erase(candidates.begin());
    }
    return plan;
}

} // namespace scene
