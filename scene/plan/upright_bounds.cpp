#include "scene/plan/upright_bounds.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>

#include <tbb/parallel_for.h>

namespace scene {

namespace {

constexpr int kFootprintPixels = 256;     ///< along an edge of the picture of the ground that tells how walls lie
constexpr int kDirections = 90;           ///< of walls that are tried, a degree apart
constexpr int kBins = 8192;               ///< along each axis, over twice the cube's edge
constexpr double kFarShare = 2e-3;        ///< of the surfaces' area, at each end of an axis, may lie outside
constexpr double kGridPoints = 1 << 20;

/// Each cell that a surface goes through: its centre in the world and its edge.
void forEachSurface(const Coverage& coverage, const std::function<void(const glm::dvec3&, double)>& visit) {
    struct Entry {
        std::size_t node;
        glm::dvec3 corner;
        double edge;
    };
    std::vector<Entry> open;
    if (!coverage.nodes.empty()) open.push_back({0, coverage.cornerInWorld, coverage.edgeMetres});
    while (!open.empty()) {
        const Entry entry = open.back();
        open.pop_back();
        const CoverageNode& node = coverage.nodes[entry.node];
        const double cell = entry.edge / kCoverageBranching;
        for (int bit = 0; bit < 64; ++bit) {
            const std::uint64_t mask = coverageMask(bit);
            const glm::dvec3 corner = entry.corner + cell * glm::dvec3(bit % 4, bit / 4 % 4, bit / 16);
            if ((node.surface & mask) != 0) visit(corner + 0.5 * cell, cell);
            if ((node.children & mask) != 0)
                open.push_back({node.firstChild + childRank(node.children, bit), corner, cell});
        }
    }
}

/// Area by place along an axis.
class Histogram {
  public:
    explicit Histogram(double edgeMetres) : areas_(kBins, 0.0), bin_(2 * edgeMetres / kBins) {}
    void add(double at, double area) {
        const double index = std::floor(at / bin_) + kBins / 2;
        areas_[static_cast<std::size_t>(std::clamp(index, 0.0, kBins - 1.0))] += area;
        sum_ += area;
    }
    std::pair<double, double> range() const {
        return {end(0, 1), end(kBins - 1, -1)};
    }

  private:
    /// The outer edge of the first bin from that end that has more than the far share behind it.
    double end(int from, int step) const {
        double passed = 0;
        int i = from;
        while (i + step >= 0 && i + step < kBins && (passed += areas_[static_cast<std::size_t>(i)]) <= kFarShare * sum_)
            i += step;
        return (i - kBins / 2 + (step > 0 ? 0 : 1)) * bin_;
    }
    std::vector<double> areas_;
    double bin_, sum_ = 0;
};

/// Turned about walk's y.
Pose turned(const Pose& walkFromWorld, double radians) {
    const double c = std::cos(radians), s = std::sin(radians);
    return Pose{glm::dmat3(c, 0, -s, 0, 1, 0, s, 0, c), glm::dvec3(0)} * walkFromWorld;
}

} // namespace

bool UprightBounds::holds(const glm::dvec3& pInWorld) const {
    const glm::dvec3 p = boundsFromWorld * pInWorld;
    return p.x >= 0 && p.y >= 0 && p.z >= 0 && p.x <= size.x && p.y <= size.y && p.z <= size.z;
}

UprightBounds findUprightBounds(const Coverage& coverage, const Pose& walkFromWorld) {
    // About the cube's middle, so that large coordinates lose nothing.
    const glm::dvec3 middle = coverage.cornerInWorld + 0.5 * coverage.edgeMetres;
    const Pose centred{walkFromWorld.rotation, -(walkFromWorld.rotation * middle)};
    const auto rangesAt = [&](double radians, const auto& forEach) {
        const Pose boundsFromWorld = turned(centred, radians);
        std::array<Histogram, 3> axes{Histogram(coverage.edgeMetres), Histogram(coverage.edgeMetres),
                                      Histogram(coverage.edgeMetres)};
        forEach([&](const glm::dvec3& p, double area) {
            const glm::dvec3 at = boundsFromWorld * p;
            for (std::size_t axis = 0; axis < 3; ++axis)
                axes[axis].add(at[static_cast<int>(axis)], area);
        });
        UprightBounds bounds{boundsFromWorld, {}};
        for (int axis = 0; axis < 3; ++axis) {
            const auto [least, most] = axes[static_cast<std::size_t>(axis)].range();
            bounds.boundsFromWorld.translation[axis] -= least;
            bounds.size[axis] = most - least;
        }
        return bounds;
    };
    // Which way the walls run, from a coarse picture of the ground.
    std::vector<double> ground(static_cast<std::size_t>(kFootprintPixels) * kFootprintPixels, 0.0);
    const double pixel = 2 * coverage.edgeMetres / kFootprintPixels;
    bool isAny = false;
    forEachSurface(coverage, [&](const glm::dvec3& p, double edge) {
        const glm::dvec3 at = centred * p;
        const auto index = [&](double x) {
            return static_cast<std::size_t>(
                std::clamp(std::floor(x / pixel) + kFootprintPixels / 2, 0.0, kFootprintPixels - 1.0));
        };
        ground[index(at.z) * kFootprintPixels + index(at.x)] += edge * edge;
        isAny = true;
    });
    if (!isAny) return {};
    const Pose worldFromCentred = inverse(centred);
    std::vector<std::pair<glm::dvec3, double>> coarse;
    for (std::size_t i = 0; i < ground.size(); ++i)
        if (ground[i] > 0)
            coarse.emplace_back(
                worldFromCentred *
                    glm::dvec3((static_cast<double>(i % kFootprintPixels) - kFootprintPixels / 2 + 0.5) * pixel, 0,
                               (static_cast<double>(i / kFootprintPixels) - kFootprintPixels / 2 + 0.5) * pixel),
                ground[i]);
    double best = 0, bestArea = std::numeric_limits<double>::infinity();
    for (int i = 0; i < kDirections; ++i) {
        const double radians = i * 1.5707963267948966 / kDirections;
        const UprightBounds bounds = rangesAt(radians, [&](const auto& add) {
            for (const auto& [p, area] : coarse)
                add(p, area);
        });
        // An equal one that comes later would turn on rounding alone.
        if (bounds.size.x * bounds.size.z < 0.999 * bestArea) bestArea = bounds.size.x * bounds.size.z, best = radians;
    }
    return rangesAt(best, [&](const auto& add) {
        forEachSurface(coverage, [&](const glm::dvec3& p, double edge) { add(p, edge * edge); });
    });
}

double unseenWithin(const Coverage& coverage, const UprightBounds& bounds) {
    if (bounds.isEmpty()) return 0;
    const double step = std::cbrt(bounds.cubicMetres() / kGridPoints);
    glm::dvec3 cells;
    for (int axis = 0; axis < 3; ++axis)
        cells[axis] = std::max(1.0, std::floor(bounds.size[axis] / step));
    const Pose worldFromBounds = inverse(bounds.boundsFromWorld);
    const glm::dvec3 edge = bounds.size / cells;
    std::vector<std::int64_t> unseen(static_cast<std::size_t>(cells.y), 0);
    tbb::parallel_for(std::size_t{0}, unseen.size(), [&](std::size_t y) {
        for (int z = 0; z < cells.z; ++z)
            for (int x = 0; x < cells.x; ++x) {
                const glm::dvec3 p = edge * (glm::dvec3(x, static_cast<double>(y), z) + 0.5);
                unseen[y] += observedAt(coverage, worldFromBounds * p) == Observed::unseen ? 1 : 0;
            }
    });
    std::int64_t sum = 0;
    for (const std::int64_t count : unseen)
        sum += count;
    return static_cast<double>(sum) * edge.x * edge.y * edge.z;
}

} // namespace scene
