#include "scene/align/panorama.h"

#include "scene/align/panorama_places.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/Eigenvalues>
#include <glm/geometric.hpp>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace scene {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kNearestMetres = 0.05; ///< nearer to the scanner is the scanner itself
constexpr int kWindow = 2;              ///< cells to each side that a normal is found from: next to each other,
constexpr double kWindowMetres = 0.045; ///< or farther apart where the window would be less wide than this to each side
constexpr int kLeastInWindow = 8;
constexpr std::size_t kPlacedTogether = 1 << 14; ///< points
/// Samples in most cells of the coarse panorama, from which on those of the fine one are not left empty.
constexpr int kDenseSamples = 4;
/// Samples of one surface in a cell lie this near to each other, metres and relatively.
constexpr double kSameMetres = 0.03, kSameShare = 0.02;
/// A window is smooth if its points leave their plane by less, metres and in widths of a cell.
constexpr double kRoughnessMetres = 0.012, kRoughnessWidths = 0.35;

/// std::atan2 to 2e-8 radians, for a quarter of its time: registration asks for little else. Not for (0, 0).
double angleOf(double y, double x) {
    const double across = std::abs(x), up = std::abs(y), ratio = std::min(across, up) / std::max(across, up),
                 square = ratio * ratio;
    double sum = 0;
    for (std::size_t i = kArcTangent.size(); i > 0; --i)
        sum = (sum + kArcTangent[i - 1]) * square;
    double angle = ratio * (1 + sum);
    if (up > across) angle = kPi / 2 - angle;
    if (x < 0) angle = kPi - angle;
    return y < 0 ? -angle : angle;
}

struct CellSums {
    Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    int count = 0;

    void add(const Eigen::Vector3d& p) {
        squares += p * p.transpose();
        sum += p;
        ++count;
    }
};

void findNormal(Panorama& panorama, int x, int y) {
    PanoramaCell& cell = panorama.cells(x, y);
    if (cell.samples == 0) return;
    const glm::dvec3 centre(cell.point);
    const double range = glm::length(centre), width = range * panorama.stepRadians();
    // Near the poles cells are narrow: a window as wide as it is high takes more of them.
    const double step = std::clamp(kWindowMetres / (kWindow * width), 1.0, 12.0);
    const int down = static_cast<int>(step),
              across =
                  std::min(static_cast<int>(step / std::max(panorama.weightOf(y), 0.05)), panorama.width() / kWindow);
    CellSums sums;
    for (int dy = -kWindow; dy <= kWindow; ++dy)
        for (int dx = -kWindow; dx <= kWindow; ++dx) {
            const int row = y + dy * down, column = (x + dx * across + panorama.width()) % panorama.width();
            if (row < 0 || row >= panorama.height()) continue;
            const PanoramaCell& other = panorama.cells(column, row);
            if (other.samples == 0) continue;
            const glm::dvec3 p = glm::dvec3(other.point) - centre;
            // A floor seen at five degrees leaves a dozen widths behind for each cell.
            if (glm::length(p) > 0.02 + 12 * kWindow * width * down) continue;
            sums.add({p.x, p.y, p.z});
        }
    if (sums.count < kLeastInWindow) return;
    const Eigen::Vector3d mean = sums.sum / sums.count;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(
        Eigen::Matrix3d(sums.squares / sums.count - mean * mean.transpose()));
    const double rough = std::sqrt(std::max(solver.eigenvalues()[0], 0.0));
    if (rough > kRoughnessMetres + kRoughnessWidths * width * down ||
        solver.eigenvalues()[1] < 4 * solver.eigenvalues()[0])
        return;
    const Eigen::Vector3d n = solver.eigenvectors().col(0);
    const glm::dvec3 normal(n.x(), n.y(), n.z());
    cell.normal = glm::vec3(glm::dot(normal, centre) > 0 ? -normal : normal);
}

Panorama binned(const Scan& scan, int rows) {
    const int columns = 2 * rows;
    Panorama panorama;
    panorama.cells = Image<PanoramaCell>(columns, rows);
    // Points in the order of their cells.
    const std::size_t cellCount = panorama.cells.size();
    std::vector<std::uint32_t> cellOf(scan.pointsInScanner.size());
    std::vector<std::size_t> first(cellCount + 1, 0);
    constexpr std::uint32_t kNone = UINT32_MAX;
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, cellOf.size(), kPlacedTogether),
                      [&](const tbb::blocked_range<std::size_t>& range) {
                          PanoramaPlaces places;
                          for (std::size_t i = range.begin(); i < range.end(); ++i)
                              places.add(scan.pointsInScanner[i]);
                          places.find(Pose{}, rows);
                          for (int k = 0; k < places.count(); ++k) {
                              const bool isSomewhere =
                                  places.cell(k) >= 0 && glm::length(places.point(k)) >= kNearestMetres;
                              cellOf[range.begin() + static_cast<std::size_t>(k)] =
                                  isSomewhere ? static_cast<std::uint32_t>(places.cell(k)) : kNone;
                          }
                      });
    for (const std::uint32_t cell : cellOf)
        if (cell != kNone) ++first[cell + 1];
    for (std::size_t cell = 0; cell < cellCount; ++cell)
        first[cell + 1] += first[cell];
    std::vector<std::size_t> next(first.begin(), first.end() - 1), sorted(first.back());
    for (std::size_t i = 0; i < cellOf.size(); ++i)
        if (cellOf[i] != kNone) sorted[next[cellOf[i]]++] = i;

    tbb::parallel_for(0, rows, [&](int y) {
        std::vector<double> ranges;
        for (int x = 0; x < columns; ++x) {
            const auto index = static_cast<std::size_t>(y * columns + x);
            const std::size_t begin = first[index], end = first[index + 1];
            if (begin == end) continue;
            ranges.clear();
            for (std::size_t i = begin; i < end; ++i)
                ranges.push_back(glm::length(glm::dvec3(scan.pointsInScanner[sorted[i]])));
            const auto [least, most] = std::minmax_element(ranges.begin(), ranges.end());
            PanoramaCell& cell = panorama.cells(x, y);
            cell.nearest = static_cast<float>(*least), cell.farthest = static_cast<float>(*most);
            const auto middle = ranges.begin() + static_cast<std::ptrdiff_t>(ranges.size() / 2);
            std::nth_element(ranges.begin(), middle, ranges.end());
            const double median = *middle, reach = kSameMetres + kSameShare * median;
            glm::dvec3 sum(0);
            for (std::size_t i = begin; i < end; ++i) {
                const glm::dvec3 p(scan.pointsInScanner[sorted[i]]);
                if (std::abs(glm::length(p) - median) > reach) continue;
                sum += p;
                ++cell.samples;
            }
            cell.point = glm::vec3(sum / static_cast<double>(cell.samples));
        }
    });
    return panorama;
}

void findNormals(Panorama& panorama) {
    tbb::parallel_for(0, panorama.height(), [&](int y) {
        for (int x = 0; x < panorama.width(); ++x)
            findNormal(panorama, x, y);
    });
}

/// Of the cells about the horizon that saw anything.
int medianSamples(const Panorama& panorama) {
    std::vector<int> samples;
    for (int y = panorama.height() / 4; y < panorama.height() * 3 / 4; ++y)
        for (const PanoramaCell& cell : panorama.cells.row(y))
            if (cell.samples > 0) samples.push_back(cell.samples);
    if (samples.empty()) return 0;
    const auto middle = samples.begin() + static_cast<std::ptrdiff_t>(samples.size() / 2);
    std::nth_element(samples.begin(), middle, samples.end());
    return *middle;
}

} // namespace

double Panorama::stepRadians() const {
    return kPi / height();
}

std::optional<std::array<int, 2>> Panorama::placeOf(const glm::dvec3& d) const {
    const double level = std::sqrt(d.x * d.x + d.y * d.y);
    const double size = level + std::abs(d.z);
    if (!(size > 0) || !std::isfinite(size)) return std::nullopt;
    const double x = level > 0 ? (angleOf(d.y, d.x) + kPi) / stepRadians() : width() / 2.0,
                 y = (angleOf(d.z, level) + kPi / 2) / stepRadians();
    return std::array{std::clamp(static_cast<int>(x), 0, width() - 1),
                      std::clamp(static_cast<int>(y), 0, height() - 1)};
}

double Panorama::weightOf(int row) const {
    return std::cos((row + 0.5) * stepRadians() - kPi / 2);
}

void lookAbout(Panorama& panorama) {
    const int width = panorama.width(), height = panorama.height();
    panorama.about = Image<PanoramaAbout>(width, height);
    tbb::parallel_for(0, height, [&](int y) {
        for (int x = 0; x < width; ++x) {
            PanoramaAbout about{1e30f, 0, panorama.cells(x, y).samples > 0, true};
            for (int dy = -1; dy <= 1; ++dy)
                for (int dx = -1; dx <= 1; ++dx) {
                    const PanoramaCell& cell =
                        panorama.cells((x + dx + width) % width, std::clamp(y + dy, 0, height - 1));
                    if (cell.samples == 0) {
                        about.isWhole = false;
                        continue;
                    }
                    about.nearest = std::min(about.nearest, cell.nearest);
                    about.farthest = std::max(about.farthest, cell.farthest);
                }
            panorama.about(x, y) = about;
        }
    });
}

Panorama panoramaOf(const Scan& scan) {
    Panorama panorama = binned(scan, kCoarseRows);
    if (medianSamples(panorama) >= kDenseSamples) panorama = binned(scan, kFineRows);
    findNormals(panorama);
    lookAbout(panorama);
    return panorama;
}

Panorama panoramaOf(const Scan& scan, int rows) {
    Panorama panorama = binned(scan, rows);
    findNormals(panorama);
    lookAbout(panorama);
    return panorama;
}

} // namespace scene
