#include "scene/plan/scan_sight.h"

#include "scene/directions.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

#include <tbb/parallel_for.h>

namespace scene {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kLearnRays = 2048;
constexpr std::size_t kMostPlaces = 64; ///< to learn from
/// Nearer to a side of the bounds a surface is taken for the wall, floor or ceiling there: share of the side's length,
/// and at most so many metres.
constexpr double kShellShare = 0.03, kShellMetres = 0.1;

std::size_t bandOf(double elevationRadians) {
    const double band = std::floor((elevationRadians / kPi + 0.5) * kElevationBands);
    return static_cast<std::size_t>(std::clamp(band, 0.0, kElevationBands - 1.0));
}

/// Metres along a ray until it leaves a box of the ray's own axes; less than 0: it does not meet it.
double exitOf(const glm::dvec3& least, const glm::dvec3& most, const glm::dvec3& origin, const glm::dvec3& direction) {
    double exit = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
        if (direction[axis] > 0) exit = std::min(exit, (most[axis] - origin[axis]) / direction[axis]);
        if (direction[axis] < 0) exit = std::min(exit, (least[axis] - origin[axis]) / direction[axis]);
    }
    return exit;
}

/// Not at the shell, nor outside.
bool isInside(const UprightBounds& bounds, const glm::dvec3& pInWorld) {
    const glm::dvec3 p = bounds.boundsFromWorld * pInWorld;
    for (int axis = 0; axis < 3; ++axis) {
        const double margin = std::min(kShellMetres, kShellShare * bounds.size[axis]);
        if (p[axis] < margin || p[axis] > bounds.size[axis] - margin) return false;
    }
    return true;
}

struct RayEnds {
    double metres = 0, things = 0;
    std::array<double, kElevationBands> rays{}, echoes{};
};

} // namespace

void follow(const Coverage& coverage, const UprightBounds& bounds, const glm::dvec3& origin,
            const glm::dvec3& direction, double farthestMetres, SightLine& line) {
    line.unseen.clear();
    line.endsAtSurface = false;
    const double end =
        std::min({farthestMetres,
                  exitOf(glm::dvec3(0), bounds.size, bounds.boundsFromWorld * origin,
                         bounds.boundsFromWorld.rotation * direction),
                  exitOf(coverage.cornerInWorld, coverage.cornerInWorld + coverage.edgeMetres, origin, direction)});
    line.endMetres = std::max(end, 0.0);
    const double ahead = 1e-7 * coverage.edgeMetres; // into the next cell
    double t = 0;
    while (t < end) {
        const std::optional<CoverageCell> cell = cellAt(coverage, origin + (t + ahead) * direction);
        if (!cell) break;
        if (cell->observed == Observed::surface) {
            line.endsAtSurface = true;
            line.endMetres = t;
            return;
        }
        const double exit = exitOf(cell->cornerInWorld, cell->cornerInWorld + cell->edgeMetres, origin, direction);
        const double next = std::min(end, std::max(exit, t + ahead));
        if (cell->observed == Observed::unseen) {
            if (!line.unseen.empty() && line.unseen.back().to == t)
                line.unseen.back().to = next;
            else
                line.unseen.push_back({t, next});
        }
        t = next;
    }
}

double solidAngleOf(const ScanRays& rays) {
    return 2 * kPi * (1 - std::sin(rays.lowestRadians));
}

SeenPlace learnFromSeen(const Coverage& coverage, const UprightBounds& bounds, std::span<const glm::dvec3> stood,
                        const ScanRays& rays) {
    std::vector<glm::dvec3> places;
    const std::size_t step = std::max<std::size_t>(1, (stood.size() + kMostPlaces - 1) / kMostPlaces);
    for (std::size_t i = 0; i < stood.size(); i += step)
        if (bounds.holds(stood[i])) places.push_back(stood[i]);
    const std::vector<glm::dvec3> directions = spreadDirections(kLearnRays, std::sin(rays.lowestRadians));
    const glm::dmat3 worldFromBounds = inverse(bounds.boundsFromWorld).rotation;
    const UprightBounds cube = wholeCube(coverage);
    std::vector<RayEnds> ends(places.size());
    tbb::parallel_for(std::size_t{0}, places.size(), [&](std::size_t i) {
        SightLine line;
        for (const glm::dvec3& direction : directions) {
            const glm::dvec3 ray = worldFromBounds * direction;
            const std::size_t band = bandOf(std::asin(std::clamp(direction.y, -1.0, 1.0)));
            follow(coverage, cube, places[i], ray, rays.farthestMetres, line);
            const double seen = line.unseen.empty() ? line.endMetres : line.unseen.front().from;
            ends[i].metres += seen;
            ends[i].rays[band] += 1;
            if (!line.endsAtSurface || !line.unseen.empty()) continue;
            ends[i].echoes[band] += 1;
            ends[i].things += isInside(bounds, places[i] + line.endMetres * ray) ? 1 : 0;
        }
    });
    RayEnds all;
    for (const RayEnds& part : ends) {
        all.metres += part.metres, all.things += part.things;
        for (std::size_t band = 0; band < kElevationBands; ++band)
            all.rays[band] += part.rays[band], all.echoes[band] += part.echoes[band];
    }
    SeenPlace seen;
    seen.freePathMetres = all.things > 0 ? all.metres / all.things : std::numeric_limits<double>::infinity();
    for (std::size_t band = 0; band < kElevationBands; ++band)
        seen.echo[band] = all.rays[band] > 0 ? all.echoes[band] / all.rays[band] : 1;
    return seen;
}

std::vector<std::vector<std::uint32_t>> neighboursOf(const std::vector<glm::dvec3>& directions, double mostRadians) {
    std::vector<std::vector<std::uint32_t>> neighbours(directions.size());
    tbb::parallel_for(std::size_t{0}, directions.size(), [&](std::size_t i) {
        std::vector<std::pair<double, std::uint32_t>> away;
        for (std::size_t j = 0; j < directions.size(); ++j)
            if (j != i && std::abs(directions[i].y - directions[j].y) < mostRadians)
                away.emplace_back(-glm::dot(directions[i], directions[j]), static_cast<std::uint32_t>(j));
        const double least = -std::cos(mostRadians);
        const auto end = std::partition(away.begin(), away.end(), [&](const auto& a) { return a.first <= least; });
        std::sort(away.begin(), end);
        for (auto at = away.begin(); at != end; ++at)
            neighbours[i].push_back(at->second);
    });
    return neighbours;
}

void continueSurfaces(std::vector<SightLine>& lines, const std::vector<std::vector<std::uint32_t>>& neighbours) {
    std::vector<double> ends(lines.size(), -1);
    for (std::size_t i = 0; i < lines.size(); ++i) {
        if (lines[i].endsAtSurface || lines[i].unseen.empty()) continue;
        for (const std::uint32_t j : neighbours[i])
            if (lines[j].endsAtSurface && lines[j].endMetres > lines[i].unseen.front().from) {
                ends[i] = lines[j].endMetres;
                break;
            }
    }
    for (std::size_t i = 0; i < lines.size(); ++i) {
        SightLine& line = lines[i];
        if (ends[i] < 0 || ends[i] >= line.endMetres) continue;
        line.endMetres = ends[i]; // a guess: whether there is an echo stays open
        while (line.unseen.back().from >= ends[i])
            line.unseen.pop_back();
        line.unseen.back().to = std::min(line.unseen.back().to, ends[i]);
    }
}

SightChance::SightChance(const SightLine& line, const SeenPlace& seen, double elevationRadians)
    : freePath_(seen.freePathMetres), lost_(0) {
    if (line.endsAtSurface) return;
    double unseen = 0;
    for (const UnseenStretch& stretch : line.unseen)
        unseen += stretch.to - stretch.from;
    lost_ = std::exp(-unseen / freePath_) * (1 - seen.echo[bandOf(elevationRadians)]);
}

double SightChance::after(double unseenMetres) const {
    return std::max(0.0, std::exp(-unseenMetres / freePath_) - lost_);
}

} // namespace scene
