#include "scene/align/scan_planes.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <Eigen/Eigenvalues>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scene {

namespace {

constexpr double kSameNormal = 0.97;  ///< cosine between a cell's normal and its region's
constexpr double kGrowMetres = 0.02;  ///< a cell leaves the region's plane by no more than this,
constexpr double kGrowShare = 0.0015; ///< and this share of its range
constexpr double kMergeCosine = 0.9994, kMergeMetres = 0.012; ///< regions of one plane
constexpr double kKeptDeviations = 2.5;                       ///< samples farther from a plane lie on something else
constexpr int kFits = 3;
constexpr int kLongestGap = 3; ///< cells from one to its neighbour

struct RegionSums {
    glm::dmat3 squares{0.0};
    glm::dvec3 sum{0.0};
    double count = 0;

    void add(const glm::dvec3& p) {
        squares += glm::outerProduct(p, p);
        sum += p;
        count += 1;
    }
    void add(const RegionSums& other) {
        squares += other.squares;
        sum += other.sum;
        count += other.count;
    }
};

/// The plane of least squares; false if the points have none.
bool fit(const RegionSums& sums, ScanPlane& plane) {
    if (sums.count < 3) return false;
    plane.middle = sums.sum / sums.count;
    plane.covariance = sums.squares / sums.count - glm::outerProduct(plane.middle, plane.middle);
    Eigen::Matrix3d c;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            c(i, j) = plane.covariance[j][i];
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(c);
    const Eigen::Vector3d n = solver.eigenvectors().col(0);
    plane.normal = {n.x(), n.y(), n.z()};
    plane.offset = glm::dot(plane.normal, plane.middle);
    if (plane.offset > 0) plane.normal = -plane.normal, plane.offset = -plane.offset;
    plane.noiseMetres = std::sqrt(std::max(solver.eigenvalues()[0], 0.0));
    plane.samples = static_cast<std::int64_t>(sums.count);
    return solver.eigenvalues()[1] > 1e-8;
}

struct Region {
    std::vector<int> cells; ///< indices into the panorama
    RegionSums sums;
    ScanPlane plane;
};

class Growing {
  public:
    Growing(Panorama& panorama, const ScanPlaneOptions& options)
        : panorama_(panorama), options_(options), region_(panorama.cells.size(), -1) {}

    std::vector<Region> run() {
        // Smooth cells first: those whose normal is most like their neighbours'.
        std::vector<std::pair<float, int>> seeds;
        for (int i = 0; i < static_cast<int>(panorama_.cells.size()); ++i)
            if (hasNormal(i)) seeds.emplace_back(-likeness(i), i);
        std::sort(seeds.begin(), seeds.end());
        std::vector<Region> regions;
        const int leastCells = options_.leastCells * panorama_.finerThanCoarse();
        for (const auto& [order, seed] : seeds) {
            if (region_[static_cast<std::size_t>(seed)] >= 0) continue;
            Region region = grow(seed, static_cast<int>(regions.size()));
            if (static_cast<int>(region.cells.size()) >= leastCells && areaOf(region) >= options_.leastArea) {
                regions.push_back(std::move(region));
                continue;
            }
            for (const int cell : region.cells)
                region_[static_cast<std::size_t>(cell)] = -1;
            region_[static_cast<std::size_t>(seed)] = kRefused;
        }
        return merged(std::move(regions));
    }

    double areaOf(const Region& region) const {
        double area = 0;
        for (const int index : region.cells) {
            const glm::dvec3 p(at(index).point);
            const double range = glm::length(p), side = range * panorama_.stepRadians();
            const double cosine = std::max(std::abs(glm::dot(p, region.plane.normal)) / range, 0.05);
            area += side * side * panorama_.weightOf(index / panorama_.width()) / cosine;
        }
        return area;
    }

  private:
    static constexpr int kRefused = 1 << 30; ///< a seed that nothing grew from

    const PanoramaCell& at(int index) const { return panorama_.cells.pixels()[static_cast<std::size_t>(index)]; }
    bool hasNormal(int index) const { return at(index).normal != glm::vec3(0); }

    template <class Take>
    void forNeighbours(int index, Take take) const {
        // A cell that no sample fell into parts nothing: what stands behind it is the neighbour.
        const int width = panorama_.width(), height = panorama_.height(), x = index % width, y = index / width;
        const auto look = [&](int dx, int dy) {
            for (int step = 1; step <= kLongestGap; ++step) {
                const int row = y + step * dy;
                if (row < 0 || row >= height) return;
                const int other = row * width + (x + step * dx + width) % width;
                if (at(other).samples == 0) continue;
                take(other);
                return;
            }
        };
        look(0, -1), look(0, 1), look(1, 0), look(-1, 0);
    }

    float likeness(int index) const {
        float sum = 0;
        forNeighbours(index, [&](int other) { sum += glm::dot(at(index).normal, at(other).normal); });
        return sum;
    }

    bool belongs(const ScanPlane& plane, int index) const {
        const PanoramaCell& cell = at(index);
        const glm::dvec3 p(cell.point);
        return glm::dot(glm::dvec3(cell.normal), plane.normal) > kSameNormal &&
               std::abs(glm::dot(plane.normal, p) - plane.offset) < kGrowMetres + kGrowShare * glm::length(p);
    }

    Region grow(int seed, int number) {
        Region region;
        region.plane.normal = glm::dvec3(at(seed).normal);
        region.plane.offset = glm::dot(region.plane.normal, glm::dvec3(at(seed).point));
        std::size_t fitAt = 12;
        region.cells.push_back(seed);
        region_[static_cast<std::size_t>(seed)] = number;
        for (std::size_t next = 0; next < region.cells.size(); ++next) {
            region.sums.add(glm::dvec3(at(region.cells[next]).point));
            if (next + 1 == fitAt) {
                if (!fit(region.sums, region.plane)) break;
                fitAt += fitAt / 2;
            }
            forNeighbours(region.cells[next], [&](int other) {
                int& owner = region_[static_cast<std::size_t>(other)];
                if ((owner >= 0 && owner != kRefused) || !hasNormal(other) || !belongs(region.plane, other)) return;
                owner = number;
                region.cells.push_back(other);
            });
        }
        fit(region.sums, region.plane);
        return region;
    }

    /// What an obstacle or a crease of a normal has cut into several regions becomes one plane again.
    static std::vector<Region> merged(std::vector<Region> regions) {
        std::sort(regions.begin(), regions.end(),
                  [](const Region& a, const Region& b) { return a.cells.size() > b.cells.size(); });
        std::vector<Region> kept;
        for (Region& region : regions) {
            const auto same = std::find_if(kept.begin(), kept.end(), [&](const Region& other) {
                const auto distance = [](const ScanPlane& plane, const glm::dvec3& p) {
                    return std::abs(glm::dot(plane.normal, p) - plane.offset);
                };
                return glm::dot(region.plane.normal, other.plane.normal) > kMergeCosine &&
                       distance(other.plane, region.plane.middle) < kMergeMetres &&
                       distance(region.plane, other.plane.middle) < 4 * kMergeMetres;
            });
            if (same == kept.end()) {
                kept.push_back(std::move(region));
                continue;
            }
            same->cells.insert(same->cells.end(), region.cells.begin(), region.cells.end());
            same->sums.add(region.sums);
            fit(same->sums, same->plane);
        }
        return kept;
    }

    Panorama& panorama_;
    const ScanPlaneOptions& options_;
    std::vector<int> region_;
};

/// Fits each plane to the scan's own samples in its cells, those left out that stand before or behind it.
void fitToSamples(const Scan& scan, const Panorama& panorama, std::vector<ScanPlane>& planes) {
    std::vector<double> bounds(planes.size());
    for (std::size_t i = 0; i < planes.size(); ++i)
        bounds[i] = std::max(3 * planes[i].noiseMetres, 0.02);
    for (int pass = 0; pass < kFits; ++pass) {
        std::vector<RegionSums> sums(planes.size());
        for (const glm::vec3& point : scan.pointsInScanner) {
            const glm::dvec3 p(point);
            const PanoramaCell* cell = panorama.find(p);
            if (!cell || cell->plane < 0) continue;
            const auto i = static_cast<std::size_t>(cell->plane);
            if (std::abs(glm::dot(planes[i].normal, p) - planes[i].offset) < bounds[i]) sums[i].add(p);
        }
        for (std::size_t i = 0; i < planes.size(); ++i) {
            fit(sums[i], planes[i]);
            bounds[i] = std::max(kKeptDeviations * planes[i].noiseMetres, 0.001);
        }
    }
}

} // namespace

double ScanPlane::offsetDeviation() const {
    return noiseMetres / std::sqrt(static_cast<double>(std::max<std::int64_t>(samples, 1)));
}

double ScanPlane::tiltDeviation(double spreadMetres) const {
    return offsetDeviation() / std::max(spreadMetres, 1e-9);
}

std::vector<ScanPlane> planesOf(const Scan& scan, Panorama& panorama, const ScanPlaneOptions& options) {
    Growing growing(panorama, options);
    std::vector<Region> regions = growing.run();
    std::vector<double> worth;
    for (const Region& region : regions)
        worth.push_back(std::sqrt(growing.areaOf(region) * static_cast<double>(region.cells.size())));
    std::vector<std::size_t> order(regions.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return worth[a] > worth[b]; });
    if (order.size() > static_cast<std::size_t>(options.most)) order.resize(static_cast<std::size_t>(options.most));

    std::vector<ScanPlane> planes;
    for (PanoramaCell& cell : panorama.cells.pixels())
        cell.plane = -1;
    for (const std::size_t i : order) {
        for (const int cell : regions[i].cells)
            panorama.cells.pixels()[static_cast<std::size_t>(cell)].plane = static_cast<std::int32_t>(planes.size());
        planes.push_back(regions[i].plane);
        planes.back().areaSquareMetres = growing.areaOf(regions[i]);
        planes.back().cells = static_cast<int>(regions[i].cells.size());
    }
    fitToSamples(scan, panorama, planes);
    return planes;
}

} // namespace scene
