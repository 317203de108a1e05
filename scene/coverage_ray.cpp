#include "scene/coverage_ray.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

namespace scene {

namespace {

/// A nudge past a face, in edges of the whole cube: much less than the finest cell that there may be.
constexpr double kNudge = 1e-10;

struct Stretch {
    double begin, end; ///< empty if the end is not behind the beginning
};

/// Metres along the ray within a cube.
Stretch within(const glm::dvec3& corner, double edge, const glm::dvec3& origin, const glm::dvec3& direction) {
    Stretch stretch{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
    for (int axis = 0; axis < 3; ++axis) {
        const double low = corner[axis] - origin[axis], high = low + edge;
        if (direction[axis] == 0) {
            if (low > 0 || high < 0) return {0, -1};
            continue;
        }
        const double a = low / direction[axis], b = high / direction[axis];
        stretch.begin = std::max(stretch.begin, std::min(a, b));
        stretch.end = std::min(stretch.end, std::max(a, b));
    }
    return stretch;
}

} // namespace

std::optional<double> firstUnseen(const Coverage& coverage, const glm::dvec3& originInWorld,
                                  const glm::dvec3& direction, double end, double pocket) {
    assert(std::abs(glm::length(direction) - 1) < 1e-6 && !coverage.nodes.empty());
    const Stretch cube = within(coverage.cornerInWorld, coverage.edgeMetres, originInWorld, direction);
    const double nudge = kNudge * coverage.edgeMetres;
    double step = nudge; // grows where rounding keeps the ray in a cell that it has left
    double t = std::max(cube.begin, 0.0);
    const bool isMissed = !(t < cube.end);
    bool isInPocket = isMissed || cube.begin > 0 || pocket > 0;
    if (!isMissed)
        for (t += nudge; t < std::min(end, cube.end);) {
            const std::optional<CoverageCell> cell = cellAt(coverage, originInWorld + t * direction);
            if (!cell) break; // rounding, at the cube's own faces
            const bool isUnseen = cell->observed == Observed::unseen;
            if (isUnseen && !isInPocket) return t;
            if (!isUnseen && isInPocket) {
                if (t > pocket) break;
                isInPocket = false;
            }
            const double leaves = within(cell->cornerInWorld, cell->edgeMetres, originInWorld, direction).end;
            step = leaves > t ? nudge : 2 * step;
            t = std::max(t, leaves) + step;
        }
    if (!isInPocket) return std::nullopt;
    const double reached = isMissed || t >= cube.end ? end : std::min(t, end);
    return reached > pocket ? std::optional(reached) : std::nullopt;
}

} // namespace scene
