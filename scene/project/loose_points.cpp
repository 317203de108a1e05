#include "scene/project/loose_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include <glm/geometric.hpp>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

namespace scene {
namespace {

constexpr double kUnknownStep = 1e-3;   ///< radians, for scans of a point or two
constexpr double kFinestSpacing = 1e-6; ///< radians; finer than any scanner's encoder

double quantile(std::vector<double>& values, double fraction) {
    const auto at = static_cast<std::ptrdiff_t>(fraction * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), values.begin() + at, values.end());
    return values[static_cast<std::size_t>(at)];
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
    const auto quantise = [](double t) { return static_cast<std::uint32_t>((t + 1.0) * 0.5 * ((1 << 30) - 1)); };
    const std::uint64_t face = static_cast<std::uint64_t>(2 * axis + (p[axis] < 0));
    return face << 60 | spread(quantise(u)) | spread(quantise(v)) << 1;
}

// How many of the points have another surface right beside them, before or behind: 0 where each direction has
// one range, as it is for whoever measured them.
double hiddenShare(const std::vector<glm::dvec3>& points, const glm::dvec3& place) {
    constexpr double kOtherSurface = 1.25; ///< ratio of ranges
    struct Seen {
        std::uint64_t onCurve;
        double range;
        bool operator<(const Seen& other) const {
            return onCurve != other.onCurve ? onCurve < other.onCurve : range < other.range;
        }
    };
    std::vector<Seen> seen;
    seen.reserve(points.size());
    std::size_t crossings = points.size();
    for (const glm::dvec3& point : points) {
        const double range = glm::distance(point, place);
        if (range < kNearestMetres) continue; // lost: counts as hidden
        seen.push_back({curvePlace(point - place), range});
    }
    crossings -= seen.size();
    std::sort(seen.begin(), seen.end());
    for (std::size_t i = 1; i < seen.size(); ++i) {
        const double ratio = seen[i].range / seen[i - 1].range;
        crossings += ratio > kOtherSurface || ratio * kOtherSurface < 1.0;
    }
    return static_cast<double>(crossings) / static_cast<double>(points.size());
}

} // namespace

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
        if (glm::length(p) >= kNearestMetres) places.push_back({curvePlace(p), static_cast<std::uint32_t>(i)});
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
        const std::size_t begin = i > kWindow ? i - kWindow : 0, end = std::min(places.size(), i + kWindow + 1);
        for (std::size_t j = begin; j < end; ++j) {
            const double angle = glm::distance(own, directionOf(j));
            if (angle > kSameDirection) nearest[k] = std::min(nearest[k], angle);
        }
    });
    std::erase_if(nearest, [](double angle) { return angle > 1.0; });
    const double step = nearest.empty() ? kUnknownStep : std::max(quantile(nearest, 0.5), kFinestSpacing);
    return {step, step};
}

glm::dvec3 viewpointOf(const Scan& scan) {
    constexpr std::size_t kSample = 4096;
    std::vector<glm::dvec3> points;
    const std::size_t stride = std::max<std::size_t>(1, scan.pointsInScanner.size() / kSample);
    for (std::size_t i = 0; i < scan.pointsInScanner.size(); i += stride)
        points.emplace_back(scan.pointsInScanner[i]);
    const glm::dvec3 origin(0.0);
    // A handful of points tells nothing of who measured them; only one at the very origin must be escaped.
    constexpr std::size_t kTooFewToJudge = 64;
    const bool oneAtOrigin =
        std::any_of(points.begin(), points.end(), [](const glm::dvec3& p) { return glm::length(p) < kNearestMetres; });
    if (points.size() < kTooFewToJudge && !oneAtOrigin) return origin;

    // Whoever measured the points saw one surface in each direction. Where the origin is a survey mark, a
    // corner of the model or a place on a wall, points crowd it and hide each other: a floor through the
    // centre of projection is seen edge-on, and all its samples share a single line of pixels.
    constexpr double kAsMeasured = 0.3, kWorthMoving = 0.1;
    const double hiddenFromOrigin = hiddenShare(points, origin);
    if (hiddenFromOrigin <= kAsMeasured && points.size() >= kTooFewToJudge) return origin;

    // Else the place of a coarse lattice amid them from which the fewest hide each other.
    glm::dvec3 low{0.0}, high{0.0};
    std::vector<double> values(points.size());
    for (int axis = 0; axis < 3; ++axis) {
        for (std::size_t i = 0; i < points.size(); ++i)
            values[i] = points[i][axis];
        low[axis] = quantile(values, 0.05);
        high[axis] = quantile(values, 0.95);
    }
    constexpr int kPlaces = 7; // along each axis
    std::array<double, kPlaces * kPlaces * kPlaces> hidden{};
    const auto placeAt = [&](int i) {
        return low + (high - low) * glm::dvec3(i % kPlaces, i / kPlaces % kPlaces, i / kPlaces / kPlaces) /
                         double{kPlaces - 1};
    };
    tbb::parallel_for(0, static_cast<int>(hidden.size()),
                      [&](int i) { hidden[static_cast<std::size_t>(i)] = hiddenShare(points, placeAt(i)); });
    const auto best = std::min_element(hidden.begin(), hidden.end());
    return *best < hiddenFromOrigin - kWorthMoving ? placeAt(static_cast<int>(best - hidden.begin())) : origin;
}

} // namespace scene
