#include "scene/project/scan_density.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <vector>

#include <glm/geometric.hpp>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

namespace scene {
namespace {

constexpr double kUnknownStep = 1e-3; ///< radians, for scans of a point or two
constexpr double kFinestStep = 1e-6;  ///< radians; finer than any scanner's encoder
constexpr double kPi = std::numbers::pi;

double quantile(std::vector<double>& values, double fraction) {
    assert(!values.empty());
    const auto at = static_cast<std::ptrdiff_t>(fraction * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), values.begin() + at, values.end());
    return values[static_cast<std::size_t>(at)];
}

double azimuthBetween(const glm::vec3& a, const glm::vec3& b) {
    const double angle =
        std::abs(std::atan2(double{a.y}, double{a.x}) - std::atan2(double{b.y}, double{b.x}));
    return std::min(angle, 2 * kPi - angle);
}

double elevation(const glm::vec3& p) {
    return std::atan2(double{p.z}, std::hypot(double{p.x}, double{p.y}));
}

// Changes of azimuth and elevation from one cell to the next, along rows or along columns.
struct Changes {
    std::vector<double> azimuth, elevation;

    void add(const glm::vec3& a, const glm::vec3& b) {
        azimuth.push_back(azimuthBetween(a, b));
        elevation.push_back(std::abs(scene::elevation(a) - scene::elevation(b)));
    }
};

// About 256 rows and columns speak for the whole grid.
Changes changesAlong(const Scan& scan, const Image<std::int32_t>& cells, int dx, int dy) {
    Changes changes;
    const int strideX = dx ? 1 : std::max(1, cells.width() / 256),
              strideY = dy ? 1 : std::max(1, cells.height() / 256);
    for (int y = 0; y + dy < cells.height(); y += strideY)
        for (int x = 0; x + dx < cells.width(); x += strideX) {
            const std::int32_t a = cells(x, y), b = cells(x + dx, y + dy);
            if (a >= 0 && b >= 0)
                changes.add(scan.pointsInScanner[static_cast<std::size_t>(a)],
                            scan.pointsInScanner[static_cast<std::size_t>(b)]);
        }
    return changes;
}

std::optional<AngularSteps> stepsOf(const Scan& scan, const Image<std::int32_t>& cells) {
    Changes along = changesAlong(scan, cells, 1, 0), across = changesAlong(scan, cells, 0, 1);
    if (along.azimuth.empty() || across.azimuth.empty()) return std::nullopt;
    // Columns are turns of the head and rows nods in most files; some swap them.
    if (quantile(along.azimuth, 0.5) < quantile(along.elevation, 0.5)) std::swap(along, across);
    const AngularSteps steps{std::max(quantile(along.azimuth, 0.5), kFinestStep),
                             std::max(quantile(across.elevation, 0.5), kFinestStep)};
    // Regular directions fill the sphere once, or twice for scanners that turn over the zenith; loose points
    // in an arbitrary order jump about and would fill it many times.
    const double filled =
        static_cast<double>(scan.pointsInScanner.size()) * steps.horizontal * steps.vertical;
    if (steps.horizontal > 0.2 || steps.vertical > 0.2 || filled > 3.0 * 4.0 * kPi) return std::nullopt;
    return steps;
}

bool closesOf(const Scan& scan, const Image<std::int32_t>& cells, const AngularSteps& steps) {
    std::vector<double> gaps;
    for (int y = 0; y < cells.height(); ++y) {
        const std::int32_t first = cells(0, y), last = cells(cells.width() - 1, y);
        if (first >= 0 && last >= 0)
            gaps.push_back(azimuthBetween(scan.pointsInScanner[static_cast<std::size_t>(first)],
                                          scan.pointsInScanner[static_cast<std::size_t>(last)]));
    }
    return cells.width() > 8 && !gaps.empty() && quantile(gaps, 0.5) < 1.5 * steps.horizontal;
}

// Places of directions along a curve that keeps neighbours together: bits of the face's two coordinates
// interleaved.
std::uint64_t spread(std::uint32_t bits) {
    std::uint64_t v = bits;
    v = (v | v << 16) & 0x0000ffff0000ffffull;
    v = (v | v << 8) & 0x00ff00ff00ff00ffull;
    v = (v | v << 4) & 0x0f0f0f0f0f0f0f0full;
    v = (v | v << 2) & 0x3333333333333333ull;
    return (v | v << 1) & 0x5555555555555555ull;
}

std::uint64_t curvePlace(const glm::dvec3& p) {
    int axis = 0;
    for (int i = 1; i < 3; ++i)
        if (std::abs(p[i]) > std::abs(p[axis])) axis = i;
    const double u = p[(axis + 1) % 3] / p[axis], v = p[(axis + 2) % 3] / p[axis];
    const auto quantise = [](double t) {
        return static_cast<std::uint32_t>((t + 1.0) * 0.5 * ((1 << 30) - 1));
    };
    const std::uint64_t face = static_cast<std::uint64_t>(2 * axis + (p[axis] < 0));
    return face << 60 | spread(quantise(u)) | spread(quantise(v)) << 1;
}

} // namespace

std::optional<ScanGrid> gridOf(const Scan& scan) {
    // A triangle of the mesh is known by four times its cell's index, in 32 bits.
    constexpr std::int64_t kMostCells = 1 << 30;
    if (scan.rows < 2 || scan.columns < 2 || std::int64_t{scan.rows} * scan.columns > kMostCells)
        return std::nullopt;
    assert(scan.row.size() == scan.pointsInScanner.size() && scan.column.size() == scan.row.size());
    ScanGrid grid{Image<std::int32_t>(scan.columns, scan.rows, -1), {}, false};
    for (std::size_t i = scan.row.size(); i-- > 0;) {
        const glm::vec3& p = scan.pointsInScanner[i];
        if (glm::length(glm::dvec3(p)) >= kNearestMetres)
            grid.pointOfCell(scan.column[i], scan.row[i]) = static_cast<std::int32_t>(i);
    }
    const auto steps = stepsOf(scan, grid.pointOfCell);
    if (!steps) return std::nullopt;
    grid.steps = *steps;
    grid.closes = closesOf(scan, grid.pointOfCell, *steps);
    return grid;
}

AngularSteps looseSteps(const Scan& scan, const glm::dvec3& copInScanner) {
    struct Place {
        std::uint64_t onCurve;
        std::uint32_t point;
        bool operator<(const Place& other) const {
            return onCurve != other.onCurve ? onCurve < other.onCurve : point < other.point;
        }
    };
    std::vector<Place> places;
    places.reserve(scan.pointsInScanner.size());
    for (std::size_t i = 0; i < scan.pointsInScanner.size(); ++i) {
        const glm::dvec3 p = glm::dvec3(scan.pointsInScanner[i]) - copInScanner;
        if (glm::length(p) >= kNearestMetres)
            places.push_back({curvePlace(p), static_cast<std::uint32_t>(i)});
    }
    tbb::parallel_sort(places.begin(), places.end());

    // The nearest of 16 neighbours along the curve on either side is the nearest of all for most points.
    constexpr std::size_t kWindow = 16, kSample = 1 << 16;
    constexpr double kSameDirection = 1e-6; // radians
    const auto directionOf = [&](std::size_t i) {
        return glm::normalize(glm::dvec3(scan.pointsInScanner[places[i].point]) - copInScanner);
    };
    const std::size_t stride = std::max<std::size_t>(1, places.size() / kSample);
    std::vector<double> nearest(places.size() / stride, 4.0);
    tbb::parallel_for(std::size_t{0}, nearest.size(), [&](std::size_t k) {
        const std::size_t i = k * stride;
        const glm::dvec3 own = directionOf(i);
        const std::size_t begin = i > kWindow ? i - kWindow : 0,
                          end = std::min(places.size(), i + kWindow + 1);
        for (std::size_t j = begin; j < end; ++j) {
            const double angle = glm::distance(own, directionOf(j));
            if (angle > kSameDirection) nearest[k] = std::min(nearest[k], angle);
        }
    });
    std::erase_if(nearest, [](double angle) { return angle > 1.0; });
    const double step = nearest.empty() ? kUnknownStep : std::max(quantile(nearest, 0.5), kFinestStep);
    return {step, step};
}

glm::dvec3 viewpointOf(const Scan& scan) {
    constexpr std::size_t kSample = 4096;
    constexpr int kPlaces = 9; // along each axis
    std::vector<glm::dvec3> points;
    const std::size_t stride = std::max<std::size_t>(1, scan.pointsInScanner.size() / kSample);
    for (std::size_t i = 0; i < scan.pointsInScanner.size(); i += stride)
        points.emplace_back(scan.pointsInScanner[i]);
    if (points.empty()) return glm::dvec3(0.0);

    std::vector<double> values(points.size());
    const auto rangeQuantile = [&](const glm::dvec3& place, double fraction) {
        for (std::size_t i = 0; i < points.size(); ++i)
            values[i] = glm::distance(points[i], place);
        return quantile(values, fraction);
    };
    // A scanner keeps a distance: what is nearest to it, its own floor, is a metre or two away in rooms of
    // ten. Points that come much nearer were moved after scanning, their origin is a survey mark or a corner
    // of the model, and a surface through the centre of projection would be seen edge-on and lose all its
    // samples to a single line of pixels.
    constexpr double kLeastRoom = 0.05;
    const glm::dvec3 origin(0.0);
    if (rangeQuantile(origin, 0.01) >= kLeastRoom * rangeQuantile(origin, 0.5)) return origin;

    // The roomiest place amid them: the one of a coarse lattice whose nearest points are farthest away.
    glm::dvec3 low{0.0}, high{0.0};
    for (int axis = 0; axis < 3; ++axis) {
        for (std::size_t i = 0; i < points.size(); ++i)
            values[i] = points[i][axis];
        low[axis] = quantile(values, 0.05);
        high[axis] = quantile(values, 0.95);
    }
    glm::dvec3 best = origin;
    double bestRoom = rangeQuantile(origin, 0.01);
    for (int z = 0; z < kPlaces; ++z)
        for (int y = 0; y < kPlaces; ++y)
            for (int x = 0; x < kPlaces; ++x) {
                const glm::dvec3 place = low + (high - low) * glm::dvec3(x, y, z) / double{kPlaces - 1};
                const double room = rangeQuantile(place, 0.01);
                if (room > bestRoom) best = place, bestRoom = room;
            }
    return best;
}

} // namespace scene
