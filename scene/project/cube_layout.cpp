#include "scene/project/cube_layout.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>
#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

namespace scene {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr std::size_t kGrain = 1 << 16;
/// A face may always have so many pixels, and beyond that so many for each point of the scan: of a scan all round that
/// is many times what a face needs, of a scan of one face alone as much as if three quarters of it were sky.
constexpr double kUsualPixels = 4096.0 * 4096.0, kMostPixelsPerPoint = 8;

// Azimuth of the middle of what the scanner saw, if it left out a quarter of the horizon or more; else 0.
double frontAzimuth(const Scan& scan, const glm::dvec3& copInScanner) {
    constexpr int kBins = 360, kLeastGap = 90;
    std::array<bool, kBins> seen{};
    for (const glm::vec3& point : scan.pointsInScanner) {
        const glm::dvec3 p = glm::dvec3(point) - copInScanner;
        if (p.x == 0 && p.y == 0) continue; // straight above or below: every azimuth and none
        const auto bin = static_cast<int>(std::floor(std::atan2(p.y, p.x) / kDegree));
        seen[static_cast<std::size_t>((bin + kBins) % kBins)] = true;
    }
    int longest = 0, endOfLongest = 0, gap = 0;
    for (int i = 0; i < 2 * kBins; ++i) { // twice around, for a gap that crosses bin 0
        gap = seen[static_cast<std::size_t>(i % kBins)] ? 0 : gap + 1;
        if (gap > longest && gap <= kBins) longest = gap, endOfLongest = i;
    }
    if (longest < kLeastGap || longest == kBins) return 0.0;
    return (endOfLongest + 1 + 0.5 * (kBins - longest)) * kDegree;
}

struct Bounds {
    double minX = std::numeric_limits<double>::infinity(), maxX = -minX, minY = minX, maxY = -minX;
    std::size_t ownPoints = 0;

    void add(double x, double y) {
        minX = std::min(minX, x), maxX = std::max(maxX, x);
        minY = std::min(minY, y), maxY = std::max(maxY, y);
    }
    void add(const Bounds& other) {
        minX = std::min(minX, other.minX), maxX = std::max(maxX, other.maxX);
        minY = std::min(minY, other.minY), maxY = std::max(maxY, other.maxY);
        ownPoints += other.ownPoints;
    }
};
using FaceBounds = std::array<Bounds, kFaceCount>;

FaceBounds boundsOf(std::span<const glm::vec3> points, const CubeFrame& frame, double reach) {
    const auto addPoint = [&](const glm::vec3& point, FaceBounds& bounds) {
        const int own = frame.faceOf(point);
        if (own < 0) return;
        for (int face = 0; face < kFaceCount; ++face) {
            const glm::dvec3 p = frame.inFace(face, point);
            if (face != own && (p.z <= 0 || std::max(std::abs(p.x), std::abs(p.y)) > reach * p.z)) continue;
            auto& b = bounds[static_cast<std::size_t>(face)];
            b.add(p.x / p.z, p.y / p.z);
            b.ownPoints += face == own;
        }
    };
    return tbb::parallel_reduce(
        tbb::blocked_range<std::size_t>(0, points.size(), kGrain), FaceBounds{},
        [&](const tbb::blocked_range<std::size_t>& range, FaceBounds bounds) {
            for (std::size_t i = range.begin(); i < range.end(); ++i)
                addPoint(points[i], bounds);
            return bounds;
        },
        [](FaceBounds a, const FaceBounds& b) {
            for (std::size_t face = 0; face < a.size(); ++face)
                a[face].add(b[face]);
            return a;
        });
}

struct Axis {
    double focal = 0, centre = 0;
    int size = 0;
    bool coarser = false;
};

// One axis of a face: pixels from the tangents it must hold and the angle between samples.
Axis layOutAxis(double minimum, double maximum, double step, int overlap, int maxSize) {
    constexpr int kMargin = 1; // a pixel on each side, so that rounding of an extreme stays inside
    Axis axis;
    axis.focal = 1.0 / step;
    const double room = maxSize - 2 * (kMargin + overlap) - 2;
    if ((maximum - minimum) * axis.focal > room) {
        axis.focal = room / (maximum - minimum);
        axis.coarser = true;
    }
    const double edge = std::ceil(axis.focal) + overlap;
    const double first = std::max(std::floor(minimum * axis.focal) - kMargin, -edge);
    const double last = std::min(std::ceil(maximum * axis.focal) + kMargin, edge);
    axis.centre = -first;
    axis.size = static_cast<int>(last - first);
    return axis;
}

} // namespace

int CubeFrame::faceOf(const glm::vec3& pInScanner) const {
    const glm::dvec3 p = inFace(0, pInScanner); // x right, y down, z forward of the front face
    const double x = std::abs(p.x), y = std::abs(p.y), z = std::abs(p.z);
    if (!(std::max({x, y, z}) >= kNearestMetres)) return -1;
    if (z >= x && z >= y) return p.z > 0 ? 0 : 2;
    if (x >= y) return p.x > 0 ? 3 : 1;
    return p.y > 0 ? 5 : 4;
}

CubeFrame cubeFrame(const Scan& scan, const glm::dvec3& copInScanner) {
    CubeFrame frame;
    frame.copInScanner = copInScanner;
    frame.faceFromScanner = facesFromCube(frontAzimuth(scan, copInScanner));
    return frame;
}

std::array<FaceLayout, kFaceCount> layOutFaces(const Scan& scan, const CubeFrame& frame, const AngularSteps& steps,
                                               bool isMesh, const CubeFaceOptions& options,
                                               std::span<const glm::vec3> directions) {
    assert(steps.horizontal > 0 && steps.vertical > 0 && options.maxFaceSize >= 16);
    // A neighbour's point counts where a square of the mesh may carry it over the edge.
    const double finest = std::min(steps.horizontal, steps.vertical);
    const double reach = isMesh ? 1.0 + 4.0 * std::max(steps.horizontal, steps.vertical) : 1.0;
    FaceBounds bounds = boundsOf(scan.pointsInScanner, frame, reach);
    const FaceBounds further = boundsOf(directions, frame, reach);
    for (std::size_t face = 0; face < bounds.size(); ++face)
        bounds[face].add(further[face]);
    std::array<FaceLayout, kFaceCount> layouts;
    for (std::size_t face = 0; face < layouts.size(); ++face) {
        const Bounds& b = bounds[face];
        if (b.ownPoints == 0) continue;
        // About the poles the two steps turn with the azimuth; the finer one serves both axes.
        const bool isSide = face < 4;
        const int overlap = isMesh ? kMeshOverlapPixels : 0;
        const auto layOut = [&](double stepAcross, double stepDown) {
            return std::pair(layOutAxis(b.minX, b.maxX, stepAcross, overlap, options.maxFaceSize),
                             layOutAxis(b.minY, b.maxY, stepDown, overlap, options.maxFaceSize));
        };
        auto [x, y] = layOut(isSide ? steps.horizontal : finest, isSide ? steps.vertical : finest);
        const double pixels = static_cast<double>(x.size) * y.size;
        const double most =
            std::max(kUsualPixels, kMostPixelsPerPoint * static_cast<double>(scan.pointsInScanner.size()));
        const bool isTooMany = pixels > most;
        const double coarser = 1.01 * std::sqrt(pixels / most); // margins do not shrink with it
        if (isTooMany) std::tie(x, y) = layOut(coarser / x.focal, coarser / y.focal);
        layouts[face] = {Camera{x.size, y.size, x.focal, y.focal, x.centre, y.centre},
                         isTooMany || x.coarser || y.coarser};
    }
    return layouts;
}

} // namespace scene
