#include "scene/project/planar_projection.h"

#include "scene/project/colour_mean.h"
#include "scene/project/disparity_runs.h"
#include "scene/project/loose_points.h"
#include "scene/project/scan_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include <glm/geometric.hpp>
#include <tbb/parallel_for.h>

namespace scene {

namespace {

constexpr double kNoiseWidths = 6;        ///< of noise, that two samples of one surface may differ by
constexpr double kGridSameSurface = 0.02; ///< see gridOf
constexpr int kSlitSamples = 10;
constexpr double kSameInSlit = 0.01;
constexpr double kLeastOff = 0.005, kOffDeviations = 3.5; ///< of averaged samples; relative
constexpr double kGentle = 0.015, kSteepest = 0.08;       ///< slopes from one sample to the next; relative
constexpr double kSlopeGoesOn = 0.5;                      ///< by which a steep slope may change, of itself
constexpr double kFarBack = 0.03;                         ///< behind the surface beside; relative
/// Samples that hardly make a surface where so many are about, of the nine or so that a support of 1.5 spacings holds.
constexpr std::size_t kPair = 2, kFew = 4, kCrowd = 5;
constexpr double kOnePlane = 0.005; ///< root mean square of what lies on one; relative, and noise more
constexpr int kMostSupport = 64;    ///< pixels; a camera far finer than the scan is left with holes

/// Samples that go on neither the surface before nor the one behind them in their row or column, but lie between the
/// two, or behind the one where the other gave no echo. 1 / range of a plane is a straight line along rows and columns,
/// so each side is carried on by its own slope.
std::vector<std::uint8_t> findAveraged(const Scan& scan, const ScanGrid& grid) {
    const int width = grid.pointOfCell.width(), height = grid.pointOfCell.height();
    const double noiseMetres = rangeNoiseOf(scan);
    const auto isInGrid = [&](int x, int y) { return (grid.closes || (x >= 0 && x < width)) && y >= 0 && y < height; };
    const auto disparityAt = [&](int x, int y) {
        if (grid.closes) x = (x + width) % width;
        if (!isInGrid(x, y) || grid.pointOfCell(x, y) < 0) return 0.0;
        return 1.0 / glm::length(scan.pointsInScanner[static_cast<std::size_t>(grid.pointOfCell(x, y))]);
    };
    // Where the surface at x, y would be one step farther on; beyond a silhouette there is no slope to be had, and two
    // samples alone may stand on either side of one.
    const auto carriedOn = [&](int x, int y, int dx, int dy) {
        const double here = disparityAt(x, y), before = disparityAt(x - dx, y - dy), slope = here - before;
        if (!(before > 0) || std::abs(slope) >= kSteepest * here) return here;
        if (std::abs(slope) > kGentle * here) {
            const double earlier = before - disparityAt(x - 2 * dx, y - 2 * dy);
            if (std::abs(earlier - slope) >= kSlopeGoesOn * std::abs(slope)) return here;
        }
        return here + slope;
    };
    // Noise of a sample and of what two others foretell.
    const auto leastOff = [&](double here) {
        return here * std::max(kLeastOff, kOffDeviations * std::sqrt(6.0) * noiseMetres * here);
    };
    const auto isBetween = [&](int x, int y, int dx, int dy) {
        const double here = disparityAt(x, y);
        if (!(disparityAt(x - dx, y - dy) > 0 && disparityAt(x + dx, y + dy) > 0)) return false;
        const double from = carriedOn(x - dx, y - dy, dx, dy) - here, to = carriedOn(x + dx, y + dy, -dx, -dy) - here;
        const double least = leastOff(here);
        if (std::abs(from) <= least || std::abs(to) <= least) return false;
        if (from * to < 0) return true;
        if (from < 0) return false; // a rod before what stands behind it
        // A slit as narrow as one sample: believed if what one sees in it goes on somewhere beside.
        for (int i = 2; i <= kSlitSamples; ++i)
            for (const int side : {-i, i}) {
                const double other = disparityAt(x + side * dx, y + side * dy);
                if (other > 0 && std::abs(other - here) < kSameInSlit * here) return false;
            }
        return true;
    };
    // At the rim of what gives an echo: behind the surface beside it, as if averaged with what gave none, and going on
    // along the rim to neither side.
    const auto hangsBehind = [&](int x, int y, int dx, int dy) {
        const double here = disparityAt(x, y);
        if (!isInGrid(x - dx, y - dy) || disparityAt(x - dx, y - dy) > 0 || !(disparityAt(x + dx, y + dy) > 0))
            return false;
        const double least = leastOff(here);
        if (carriedOn(x + dx, y + dy, -dx, -dy) - here <= std::max(least, kFarBack * here)) return false;
        for (const int side : {-1, 1}) {
            const int u = x + side * dy, v = y + side * dx;
            if (disparityAt(u, v) > 0 && std::abs(carriedOn(u, v, -side * dy, -side * dx) - here) <= least)
                return false;
        }
        return true;
    };
    std::vector<std::uint8_t> isAveraged(scan.pointsInScanner.size(), 0);
    tbb::parallel_for(0, height, [&](int y) {
        for (int x = 0; x < width; ++x)
            if (grid.pointOfCell(x, y) >= 0)
                isAveraged[static_cast<std::size_t>(grid.pointOfCell(x, y))] =
                    isBetween(x, y, 1, 0) || isBetween(x, y, 0, 1) || hangsBehind(x, y, 1, 0) ||
                    hangsBehind(x, y, -1, 0) || hangsBehind(x, y, 0, 1) || hangsBehind(x, y, 0, -1);
    });
    return isAveraged;
}

/// A sample as the camera sees it.
struct Seen {
    float x = 0, y = 0, disparity = 0;
    std::uint32_t point = 0;
};

struct Member {
    float dx = 0, dy = 0; ///< from the pixel's centre, pixels
    float disparity = 0, weight = 0;
    std::uint32_t point = 0;

    /// Sorted by disparity; the rest makes sums the same on any number of threads.
    bool operator<(const Member& other) const {
        return disparity != other.disparity ? disparity < other.disparity : point < other.point;
    }
};

/// Samples by the pixel they fall into: those of pixel i are [first[i], first[i + 1]).
struct Buckets {
    std::vector<Seen> samples;
    std::vector<std::uint32_t> first;
};

Buckets sortIntoPixels(const Scan& scan, const Pose& cameraFromScanner, const Camera& camera) {
    const auto pixels = static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
    std::vector<Seen> seen(scan.pointsInScanner.size());
    std::vector<std::int64_t> pixelOf(seen.size());
    tbb::parallel_for(std::size_t{0}, seen.size(), [&](std::size_t i) {
        const glm::dvec3 p = cameraFromScanner * glm::dvec3(scan.pointsInScanner[i]);
        pixelOf[i] = -1;
        if (!(p.z > kNearestMetres)) return;
        const glm::dvec2 place = project(camera, p);
        if (!(place.x >= 0 && place.y >= 0 && place.x < camera.width && place.y < camera.height)) return;
        seen[i] = {static_cast<float>(place.x), static_cast<float>(place.y), static_cast<float>(1 / p.z),
                   static_cast<std::uint32_t>(i)};
        pixelOf[i] = static_cast<std::int64_t>(place.y) * camera.width + static_cast<std::int64_t>(place.x);
    });
    Buckets buckets;
    buckets.first.assign(pixels + 1, 0);
    for (const std::int64_t pixel : pixelOf)
        if (pixel >= 0) ++buckets.first[static_cast<std::size_t>(pixel) + 1];
    for (std::size_t i = 0; i < pixels; ++i)
        buckets.first[i + 1] += buckets.first[i];
    buckets.samples.resize(buckets.first.back());
    std::vector<std::uint32_t> next(buckets.first.begin(), buckets.first.end() - 1);
    for (std::size_t i = 0; i < seen.size(); ++i)
        if (pixelOf[i] >= 0) buckets.samples[next[static_cast<std::size_t>(pixelOf[i])]++] = seen[i];
    return buckets;
}

/// The plane d = disparity + b (dx - x) + c (dy - y) through samples, by their weights.
struct Plane {
    double x = 0, y = 0, disparity = 0, b = 0, c = 0;
    bool isSpanned = false; ///< samples in a line say nothing about the slope across it; b and c are then 0

    double at(double dx, double dy) const { return disparity + b * (dx - x) + c * (dy - y); }
};

Plane planeThrough(std::span<const Member> members) {
    Plane plane;
    double w = 0;
    for (const Member& m : members) {
        w += m.weight, plane.disparity += double{m.weight} * m.disparity;
        plane.x += double{m.weight} * m.dx, plane.y += double{m.weight} * m.dy;
    }
    plane.x /= w, plane.y /= w, plane.disparity /= w;
    double xx = 0, xy = 0, yy = 0, xd = 0, yd = 0;
    for (const Member& m : members) {
        const double dx = m.dx - plane.x, dy = m.dy - plane.y, dd = m.disparity - plane.disparity;
        xx += m.weight * dx * dx, xy += m.weight * dx * dy, yy += m.weight * dy * dy;
        xd += m.weight * dx * dd, yd += m.weight * dy * dd;
    }
    const double determinant = xx * yy - xy * xy;
    plane.isSpanned = members.size() >= 4 && determinant > 0.02 * (xx + yy) * (xx + yy);
    if (plane.isSpanned) plane.b = (xd * yy - yd * xy) / determinant, plane.c = (yd * xx - xd * xy) / determinant;
    return plane;
}

/// Sorted by disparity.
float planeAtCentre(std::span<const Member> members) {
    return static_cast<float>(std::clamp(planeThrough(members).at(0, 0), double{members.front().disparity},
                                         double{members.back().disparity}));
}

/// Whether samples lie on one plane, however steeply it stands: neighbours on a far floor are clusters of their own.
/// noise: relative.
bool lieOnOnePlane(std::span<const Member> members, double noise) {
    const Plane plane = planeThrough(members);
    double w = 0, squares = 0;
    for (const Member& m : members) {
        const double off = m.disparity - plane.at(m.dx, m.dy);
        w += m.weight, squares += m.weight * off * off;
    }
    return plane.isSpanned && squares <= w * (kOnePlane * kOnePlane + noise * noise) * std::pow(plane.disparity, 2);
}

class Projection {
  public:
    Projection(const Scan& scan, const ScanTraits& traits, const Camera& camera, const Buckets& buckets,
               const PlanarOptions& options)
        : scan_(scan), traits_(traits), camera_(camera), buckets_(buckets), options_(options),
          step_(traits.spacingRadians()) {}

    void row(int y, DepthImage& image) const {
        Scratch scratch;
        for (int x = 0; x < camera_.width; ++x)
            pixel(x, y, scratch, image);
    }

  private:
    /// Reused from pixel to pixel.
    struct Scratch {
        std::vector<Member> members, averaged, about;
    };

    void pixel(int x, int y, Scratch& scratch, DepthImage& image) const {
        auto& [members, averaged, about] = scratch;
        const glm::dvec3 ray = rayThrough(camera_, x + 0.5, y + 0.5);
        const double away = glm::dot(ray, ray); // angles widen by this towards the rim
        const double spacingX = std::max(step_ * camera_.fx * away, 1.0),
                     spacingY = std::max(step_ * camera_.fy * away, 1.0);
        const double reachX = options_.support * spacingX, reachY = options_.support * spacingY;
        gather(x, y, reachX, reachY, members, averaged);
        if (members.empty()) return;
        const std::span<const Member> cluster = heaviest(members, std::sqrt(away));
        const std::size_t all = members.size() + averaged.size();
        if (cluster.size() == 1 && all > 2) return; // between surfaces, or by itself
        // An averaged sample says that there is surface, if not where.
        const auto isOwn = [&](const Member& m) {
            return std::abs(m.dx) <= options_.reach * spacingX && std::abs(m.dy) <= options_.reach * spacingY;
        };
        if (std::none_of(cluster.begin(), cluster.end(), isOwn) &&
            std::none_of(averaged.begin(), averaged.end(), isOwn))
            return;
        if (cluster.size() <= kFew && all >= kCrowd) { // among leaves they agree by chance
            about.assign(members.begin(), members.end());
            about.insert(about.end(), averaged.begin(), averaged.end());
            const bool isSure = cluster.size() > kPair && !isBetween(cluster, about, std::sqrt(away));
            if (!isSure && !lieOnOnePlane(about, noiseAt(cluster.front().disparity, std::sqrt(away)))) return;
        }
        image.disparity(x, y) = planeAtCentre(cluster);
        ColourMean mean;
        for (const Member& m : cluster)
            mean.add(scan_, m.point, m.weight);
        image.colour(x, y) = mean.colour();
        image.flags(x, y) = mean.flags();
    }

    /// The samples about a pixel, sorted, and apart from them those that are averaged.
    void gather(int x, int y, double reachX, double reachY, std::vector<Member>& members,
                std::vector<Member>& averaged) const {
        averaged.clear();
        members.clear();
        const int rx = std::min(static_cast<int>(std::ceil(reachX)), kMostSupport),
                  ry = std::min(static_cast<int>(std::ceil(reachY)), kMostSupport);
        const int left = std::max(x - rx, 0), right = std::min(x + rx, camera_.width - 1);
        for (int j = std::max(y - ry, 0); j <= std::min(y + ry, camera_.height - 1); ++j) {
            const auto start = static_cast<std::size_t>(j) * static_cast<std::size_t>(camera_.width);
            const std::uint32_t begin = buckets_.first[start + static_cast<std::size_t>(left)],
                                end = buckets_.first[start + static_cast<std::size_t>(right) + 1];
            for (std::uint32_t i = begin; i < end; ++i) {
                const Seen& seen = buckets_.samples[i];
                const double dx = seen.x - (x + 0.5), dy = seen.y - (y + 0.5);
                const double weight = (1 - std::abs(dx) / reachX) * (1 - std::abs(dy) / reachY);
                if (std::abs(dx) >= reachX || std::abs(dy) >= reachY || weight <= 0) continue;
                const bool isAveraged = !traits_.isAveraged.empty() && traits_.isAveraged[seen.point];
                (isAveraged ? averaged : members)
                    .push_back({static_cast<float>(dx), static_cast<float>(dy), seen.disparity,
                                static_cast<float>(weight), seen.point});
            }
        }
        std::sort(members.begin(), members.end());
    }

    /// Whether others stand both before and behind a cluster.
    bool isBetween(std::span<const Member> cluster, std::span<const Member> about, double secant) const {
        const auto [farthest, nearest] = std::minmax_element(
            about.begin(), about.end(), [](const Member& a, const Member& b) { return a.disparity < b.disparity; });
        return nearest->disparity - cluster.back().disparity > gap(nearest->disparity, secant) &&
               cluster.front().disparity - farthest->disparity > gap(cluster.front().disparity, secant);
    }

    /// secant: between the pixel's ray and the camera's axis; noise is along the ray.
    std::span<const Member> heaviest(std::span<const Member> sorted, double secant) const {
        return heaviestRun<double>(sorted, [&](const Member& member) { return gap(member.disparity, secant); });
    }

    /// Relative.
    double noiseAt(double disparity, double secant) const { return options_.noiseMetres / secant * disparity; }
    double gap(double disparity, double secant) const {
        return disparity * std::max(options_.sameSurface, kNoiseWidths * noiseAt(disparity, secant));
    }

    const Scan& scan_;
    const ScanTraits& traits_;
    const Camera& camera_;
    const Buckets& buckets_;
    const PlanarOptions& options_;
    double step_;
};

} // namespace

ScanTraits traitsOf(const Scan& scan) {
    const std::optional<ScanGrid> grid = gridOf(scan, kGridSameSurface);
    if (!grid) return {looseSteps(scan, glm::dvec3(0)), {}};
    return {grid->steps, findAveraged(scan, *grid)};
}

DepthImage projectToCamera(const Scan& scan, const ScanTraits& traits, const Pose& cameraFromScanner,
                           const Camera& camera, const PlanarOptions& options) {
    DepthImage image;
    image.camera = camera;
    image.colour = Image<Rgb8>(camera.width, camera.height);
    image.disparity = Image<float>(camera.width, camera.height, 0.0f);
    image.flags = Image<std::uint8_t>(camera.width, camera.height, kNoSurface);
    const Buckets buckets = sortIntoPixels(scan, cameraFromScanner, camera);
    const Projection projection(scan, traits, camera, buckets, options);
    tbb::parallel_for(0, camera.height, [&](int y) { projection.row(y, image); });
    return image;
}

double rangeNoiseOf(const Scan& scan) {
    if (scan.rows == 0) return 0;
    constexpr std::size_t kMost = 1 << 18;
    constexpr float kSilhouette = 0.05f;
    // Points of a column follow each other in files; any three that do and are next to each other serve.
    std::vector<float> off;
    const std::size_t count = scan.pointsInScanner.size();
    const std::size_t stride = std::max<std::size_t>(1, count / kMost);
    for (std::size_t i = 1; i + 1 < count; i += stride) {
        if (scan.column[i - 1] != scan.column[i] || scan.column[i + 1] != scan.column[i]) continue;
        if (std::abs(scan.row[i - 1] - scan.row[i]) != 1 || scan.row[i - 1] + scan.row[i + 1] != 2 * scan.row[i])
            continue;
        const float a = glm::length(scan.pointsInScanner[i - 1]), b = glm::length(scan.pointsInScanner[i]),
                    c = glm::length(scan.pointsInScanner[i + 1]);
        if (std::abs(a - b) > kSilhouette * b || std::abs(c - b) > kSilhouette * b) continue;
        off.push_back(std::abs(b - 0.5f * (a + c)));
    }
    if (off.size() < 100) return 0;
    const auto middle = off.begin() + std::ssize(off) / 2;
    std::nth_element(off.begin(), middle, off.end());
    return 1.4826 * double{*middle} / std::sqrt(1.5);
}

} // namespace scene
