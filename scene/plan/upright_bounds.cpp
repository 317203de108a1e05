#include "scene/plan/upright_bounds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>

#include <tbb/parallel_for.h>

namespace scene {

namespace {

constexpr int kDirections = 90;         ///< of walls that are tried, a degree apart
constexpr int kBins = 2048;             ///< along each axis, over twice the cube's edge
constexpr double kFarShare = 0.01;      ///< of what was seen empty, at each end of an axis, may lie outside,
constexpr double kThinShare = 0.25;     ///< unless it goes on as wide as this share of the mean
constexpr double kThinnestShare = 0.02; ///< the same, to tell how the box lies: corners of a crooked one are thin
constexpr double kGridPoints = 1 << 20;

/// Each cell that was seen empty: its centre in the world and its edge.
void forEachEmpty(const Coverage& coverage, const std::function<void(const glm::dvec3&, double)>& visit) {
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
            if (((node.unseen | node.surface | node.children) & mask) == 0) visit(corner + 0.5 * cell, cell);
            if ((node.children & mask) != 0)
                open.push_back({node.firstChild + childRank(node.children, bit), corner, cell});
        }
    }
}

/// Volume by place along an axis.
class Profile {
  public:
    explicit Profile(double edgeMetres) : volumes_(kBins, 0.0), bin_(2 * edgeMetres / kBins) {}
    /// A cell is spread over its width.
    void add(double at, double width, double volume) {
        const int first = index(at - 0.5 * width), last = index(at + 0.5 * width);
        for (int i = first; i <= last; ++i)
            volumes_[static_cast<std::size_t>(i)] += volume / (last - first + 1);
        sum_ += volume;
    }
    std::pair<double, double> range(double thinShare) const {
        int least = inner(0, 1), most = inner(kBins - 1, -1);
        const double thin = thinShare * sum_ / (most - least + 1);
        while (least > 0 && volumes_[static_cast<std::size_t>(least - 1)] > thin)
            --least;
        while (most + 1 < kBins && volumes_[static_cast<std::size_t>(most + 1)] > thin)
            ++most;
        return {(least - kBins / 2) * bin_, (most + 1 - kBins / 2) * bin_};
    }

  private:
    int index(double at) const {
        return static_cast<int>(std::clamp(std::floor(at / bin_) + kBins / 2, 0.0, kBins - 1.0));
    }
    /// The first bin from an end with more than the far share up to it.
    int inner(int from, int step) const {
        double passed = 0;
        int i = from;
        while (i + step >= 0 && i + step < kBins &&
               (passed += volumes_[static_cast<std::size_t>(i)]) <= kFarShare * sum_)
            i += step;
        return i;
    }
    std::vector<double> volumes_;
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
    const auto rangesAt = [&](double radians, double thinShare, const auto& forEach) {
        const Pose boundsFromWorld = turned(centred, radians);
        std::array<Profile, 3> axes{Profile(coverage.edgeMetres), Profile(coverage.edgeMetres),
                                    Profile(coverage.edgeMetres)};
        forEach([&](const glm::dvec3& p, double edge) {
            const glm::dvec3 at = boundsFromWorld * p;
            for (std::size_t axis = 0; axis < 3; ++axis)
                axes[axis].add(at[static_cast<int>(axis)], edge, edge * edge * edge);
        });
        UprightBounds bounds{boundsFromWorld, {}};
        for (int axis = 0; axis < 3; ++axis) {
            const auto [least, most] = axes[static_cast<std::size_t>(axis)].range(thinShare);
            bounds.boundsFromWorld.translation[axis] -= least;
            bounds.size[axis] = most - least;
        }
        return bounds;
    };
    // Which way the walls run is told by the larger cells; small ones are most of the work and hold little.
    bool isAny = false;
    double largest = 0;
    forEachEmpty(coverage, [&](const glm::dvec3&, double edge) { isAny = true, largest = std::max(largest, edge); });
    if (!isAny) return {};
    std::vector<std::pair<glm::dvec3, double>> coarse;
    forEachEmpty(coverage, [&](const glm::dvec3& p, double edge) {
        if (edge > largest / 20) coarse.emplace_back(p, edge);
    });
    double best = 0, bestArea = std::numeric_limits<double>::infinity();
    for (int i = 0; i < kDirections; ++i) {
        const double radians = i * 1.5707963267948966 / kDirections;
        const UprightBounds bounds = rangesAt(radians, kThinnestShare, [&](const auto& add) {
            for (const auto& [p, edge] : coarse)
                add(p, edge);
        });
        // An equal one that comes later would turn on rounding alone.
        if (bounds.size.x * bounds.size.z < 0.999 * bestArea) bestArea = bounds.size.x * bounds.size.z, best = radians;
    }
    return rangesAt(best, kThinShare, [&](const auto& add) { forEachEmpty(coverage, add); });
}

UprightBounds wholeCube(const Coverage& coverage) {
    return {{glm::dmat3(1), -coverage.cornerInWorld}, glm::dvec3(coverage.edgeMetres)};
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
