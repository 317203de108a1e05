#include "scene/capture/spread_positions.h"

#include "scene/capture/free_space.h"
#include "scene/directions.h"
#include "scene/errors.h"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <string>

#include <glm/geometric.hpp>
#include <tbb/parallel_for.h>

namespace scene {

namespace {

constexpr int kMostFloors = 32; ///< over each other
constexpr int kMiddleSteps = 16;
constexpr int kLooks = 256;
constexpr double kMostBacks = 0.1;  ///< share of looks that end at backs: one stands behind open geometry
constexpr double kFloorShare = 0.2; ///< of the eye's height: half of the least width of a floor
constexpr double kStepShare = 0.15; ///< of the eye's height: a step that is still the same floor
constexpr double kLevel = 0.7;      ///< cosine of the slope up to which one can stand
constexpr double kFlatShare = 0.02; ///< of its width: what is no higher is ground without anything on it

struct Candidate {
    glm::dvec3 position{0.0};
    Surroundings about;
};

/// Eye height over each floor below a place at the top of the scene; a place on a floor alone, whatever its back.
/// turned: how many would be floors if their faces were not turned away.
std::vector<glm::dvec3> standsBelow(const PolygonTracer& tracer, glm::dvec3 from, double eyeMetres,
                                    std::atomic<int>& turned) {
    std::vector<glm::dvec3> stands;
    for (int floor = 0; floor < kMostFloors; ++floor) {
        const std::optional<PolygonHit> hit = tracer.cast(from, {0, -1, 0});
        if (!hit) break;
        const TriangleInWorld triangle = tracer.triangleOf(*hit);
        const double y = from.y - hit->t;
        const bool isFloor = !hit->isBack && triangle.across.y > kLevel * glm::length(triangle.across);
        if (hit->isBack && triangle.across.y < -kLevel * glm::length(triangle.across)) ++turned;
        if (isFloor && hit->t > eyeMetres) stands.emplace_back(from.x, y + eyeMetres, from.z);
        from.y = y - 2 * tracer.skinMetres();
    }
    return stands;
}

/// What one stands on is a floor and no vase: it is as low a little to all sides.
bool isFloorWide(const PolygonTracer& tracer, const glm::dvec3& place, double eyeMetres) {
    for (const auto& [x, z] : {std::pair(-1, 0), std::pair(1, 0), std::pair(0, -1), std::pair(0, 1)}) {
        const glm::dvec3 aside = place + glm::dvec3(x, 0, z) * (kFloorShare * eyeMetres);
        const std::optional<PolygonHit> hit = tracer.cast(aside, {0, -1, 0});
        if (!hit || std::abs(hit->t - eyeMetres) > kStepShare * eyeMetres) return false;
    }
    return true;
}

double squaredDistance(const glm::dvec3& a, const glm::dvec3& b) {
    return glm::dot(a - b, a - b);
}

std::size_t nearestOf(const std::vector<glm::dvec3>& positions, const glm::dvec3& p) {
    return static_cast<std::size_t>(
        std::min_element(positions.begin(), positions.end(),
                         [&](const auto& a, const auto& b) { return squaredDistance(a, p) < squaredDistance(b, p); }) -
        positions.begin());
}

/// Number of the triangles that looks from a place end on.
std::vector<std::uint64_t> trianglesSeen(const PolygonTracer& tracer, const glm::dvec3& position) {
    std::vector<std::uint64_t> seen;
    for (const glm::dvec3& direction : spreadDirections(kLooks))
        if (const std::optional<PolygonHit> hit = tracer.cast(position, direction))
            seen.push_back(static_cast<std::uint64_t>(hit->instance) << 32 | hit->triangle);
    return seen;
}

/// For each candidate the first of those that one gets to from it, from neighbour to neighbour in straight lines.
std::vector<std::size_t> roomsOf(const PolygonTracer& tracer, const std::vector<Candidate>& candidates, double step) {
    std::vector<std::size_t> first(candidates.size());
    std::iota(first.begin(), first.end(), std::size_t{0});
    const auto rootOf = [&](std::size_t i) {
        while (first[i] != i)
            i = first[i] = first[first[i]];
        return i;
    };
    // Candidates come column by column, row by row: what is near lies in a window that is not long.
    std::vector<std::vector<std::size_t>> sees(candidates.size());
    tbb::parallel_for(std::size_t{0}, candidates.size(), [&](std::size_t i) {
        const glm::dvec3& from = candidates[i].position;
        for (std::size_t j = i + 1; j < candidates.size(); ++j) {
            const glm::dvec3 way = candidates[j].position - from;
            if (way.z > 1.5 * step) break;
            if (std::abs(way.x) <= 1.5 * step && std::abs(way.y) <= step && !tracer.isBlocked(from, way, 1.0))
                sees[i].push_back(j);
        }
    });
    for (std::size_t i = 0; i < sees.size(); ++i)
        for (const std::size_t j : sees[i])
            first[std::max(rootOf(i), rootOf(j))] = std::min(rootOf(i), rootOf(j));
    for (std::size_t i = 0; i < first.size(); ++i)
        first[i] = rootOf(i);
    return first;
}

/// Leaves out the rooms from which little is to be seen.
void dropPoorRooms(const PolygonTracer& tracer, double step, double richShare, std::vector<Candidate>& candidates) {
    const std::vector<std::size_t> rooms = roomsOf(tracer, candidates, step);
    std::vector<std::vector<std::uint64_t>> seen(candidates.size());
    tbb::parallel_for(std::size_t{0}, candidates.size(),
                      [&](std::size_t i) { seen[i] = trianglesSeen(tracer, candidates[i].position); });
    std::map<std::size_t, std::vector<std::uint64_t>> seenFrom;
    for (std::size_t i = 0; i < candidates.size(); ++i)
        seenFrom[rooms[i]].insert(seenFrom[rooms[i]].end(), seen[i].begin(), seen[i].end());
    std::map<std::size_t, double> riches;
    double most = 0;
    for (auto& [room, triangles] : seenFrom) {
        std::sort(triangles.begin(), triangles.end());
        triangles.erase(std::unique(triangles.begin(), triangles.end()), triangles.end());
        riches[room] = static_cast<double>(triangles.size());
        most = std::max(most, riches[room]);
    }
    std::vector<Candidate> kept;
    for (std::size_t i = 0; i < candidates.size(); ++i)
        if (riches[rooms[i]] >= richShare * most) kept.push_back(candidates[i]);
    candidates = std::move(kept);
}

/// What a failure is about.
std::string nameOf(const PolygonTracer& tracer) {
    return tracer.scene().files.empty() ? std::string("scene") : tracer.scene().files.front().string();
}

std::vector<Candidate> findCandidates(const PolygonTracer& tracer, const SpreadOptions& options) {
    const PolygonBounds& bounds = tracer.bounds();
    const glm::dvec3 extent = bounds.high - bounds.low;
    const double wide = std::max(extent.x, extent.z), step = wide / options.gridAcross;
    // Of bare ground the height says nothing; else what is highest is a roof, and nobody stands on it.
    const bool isBare = extent.y < kFlatShare * wide;
    const double eye = std::min(options.eyeMetres, isBare ? wide / 4 : extent.y / 2);
    const double topmost = bounds.high.y + (isBare ? 2 : 1) * eye;
    const int columns = std::max(1, static_cast<int>(extent.x / step)),
              rows = std::max(1, static_cast<int>(extent.z / step));
    std::atomic<int> turned = 0;
    std::vector<std::vector<Candidate>> found(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
    tbb::parallel_for(std::size_t{0}, found.size(), [&](std::size_t cell) {
        const auto column = static_cast<int>(cell) % columns, row = static_cast<int>(cell) / columns;
        // Half a grid's width beside the middle, so that columns do not run along the edges of a symmetric scene.
        const glm::dvec3 top(bounds.low.x + (column + 0.5) / columns * extent.x, topmost,
                             bounds.low.z + (row + 0.5) / rows * extent.z);
        for (const glm::dvec3& place : standsBelow(tracer, top, eye, turned)) {
            const Surroundings about = lookRound(tracer, place);
            if (about.nearestMetres < std::min(options.clearanceMetres, eye / 4) || about.backShare > kMostBacks)
                continue;
            if (!isFloorWide(tracer, place, eye)) continue;
            found[cell].push_back({place, about});
        }
    });
    std::vector<Candidate> candidates;
    for (const auto& cell : found)
        candidates.insert(candidates.end(), cell.begin(), cell.end());
    double most = 0;
    for (const Candidate& candidate : candidates)
        most = std::max(most, candidate.about.levelShare);
    std::erase_if(candidates, [&](const Candidate& c) { return c.about.levelShare < options.seenShare * most; });
    dropPoorRooms(tracer, step, options.richShare, candidates);
    if (candidates.empty() && turned > 0)
        throw Failure("has no floor at which one could stand: what would be one shows its back, since it is solid or "
                      "its faces are turned the wrong way",
                      nameOf(tracer), "turn them round where the model was made, or give a file of positions");
    if (candidates.empty())
        throw Failure("has no floor at which one could stand", nameOf(tracer), "give a file of positions");
    return candidates;
}

/// Farthest-point choice from the first.
std::vector<glm::dvec3> takeFarthest(const std::vector<Candidate>& candidates, std::size_t first, int count) {
    std::vector<glm::dvec3> taken;
    std::vector<double> away(candidates.size(), std::numeric_limits<double>::infinity());
    for (std::size_t next = first; taken.size() < static_cast<std::size_t>(count);
         next = static_cast<std::size_t>(std::max_element(away.begin(), away.end()) - away.begin())) {
        taken.push_back(candidates[next].position);
        for (std::size_t i = 0; i < candidates.size(); ++i)
            away[i] = std::min(away[i], squaredDistance(candidates[i].position, taken.back()));
    }
    return taken;
}

/// Each position to the candidate next to the mean of those that are nearest to it.
std::vector<glm::dvec3> moveToMiddles(const std::vector<Candidate>& candidates, std::vector<glm::dvec3> positions) {
    for (int step = 0; step < kMiddleSteps; ++step) {
        std::vector<glm::dvec3> sums(positions.size(), glm::dvec3(0));
        std::vector<int> counts(positions.size(), 0);
        for (const Candidate& candidate : candidates) {
            const std::size_t nearest = nearestOf(positions, candidate.position);
            sums[nearest] += candidate.position;
            ++counts[nearest];
        }
        std::vector<glm::dvec3> next = positions;
        for (std::size_t i = 0; i < positions.size(); ++i) {
            if (counts[i] == 0) continue;
            const glm::dvec3 middle = sums[i] / static_cast<double>(counts[i]);
            const auto closest =
                std::min_element(candidates.begin(), candidates.end(), [&](const auto& a, const auto& b) {
                    return squaredDistance(a.position, middle) < squaredDistance(b.position, middle);
                });
            // Never onto another one: positions stay as many as were asked for.
            if (std::find(next.begin(), next.end(), closest->position) == next.end()) next[i] = closest->position;
        }
        if (next == positions) break;
        positions = std::move(next);
    }
    return positions;
}

std::size_t widestOf(const std::vector<Candidate>& candidates) {
    return static_cast<std::size_t>(
        std::max_element(candidates.begin(), candidates.end(),
                         [](const auto& a, const auto& b) { return a.about.meanMetres < b.about.meanMetres; }) -
        candidates.begin());
}

} // namespace

std::vector<glm::dvec3> standingPlaces(const PolygonTracer& tracer, const SpreadOptions& options) {
    std::vector<Candidate> candidates = findCandidates(tracer, options);
    std::swap(candidates.front(), candidates[widestOf(candidates)]);
    std::vector<glm::dvec3> places;
    for (const Candidate& candidate : candidates)
        places.push_back(candidate.position);
    return places;
}

std::vector<glm::dvec3> spreadPositions(const PolygonTracer& tracer, int count, const SpreadOptions& options) {
    assert(count > 0);
    const std::vector<Candidate> candidates = findCandidates(tracer, options);
    if (candidates.size() < static_cast<std::size_t>(count))
        throw Failure("has room for " + std::to_string(candidates.size()) + " positions at eye height, not " +
                          std::to_string(count),
                      nameOf(tracer), "ask for fewer, or give a file of positions");
    const std::size_t widest = widestOf(candidates);
    std::vector<glm::dvec3> positions = moveToMiddles(candidates, takeFarthest(candidates, widest, count));
    // The walk begins at the first: the one nearest to the widest look.
    std::swap(positions.front(), positions[nearestOf(positions, candidates[widest].position)]);
    return positions;
}

} // namespace scene
