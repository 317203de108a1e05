#include "scene/project/scan_grid.h"

#include "scene/median.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <glm/geometric.hpp>
#include <tbb/parallel_for.h>

namespace scene {
namespace {

constexpr double kFinestStep = 1e-6; ///< radians; finer than any scanner's encoder
constexpr double kPi = std::numbers::pi;

double azimuthBetween(const glm::vec3& a, const glm::vec3& b) {
    const double angle = std::abs(std::atan2(double{a.y}, double{a.x}) - std::atan2(double{b.y}, double{b.x}));
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
    const int strideX = dx ? 1 : std::max(1, cells.width() / 256), strideY = dy ? 1 : std::max(1, cells.height() / 256);
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
    if (medianOf(along.azimuth) < medianOf(along.elevation)) std::swap(along, across);
    const AngularSteps steps{std::max(medianOf(along.azimuth), kFinestStep),
                             std::max(medianOf(across.elevation), kFinestStep)};
    // Regular directions fill the sphere once, or twice for scanners that turn over the zenith; loose points
    // in an arbitrary order jump about and would fill it many times.
    const double filled = static_cast<double>(scan.pointsInScanner.size()) * steps.horizontal * steps.vertical;
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
    return cells.width() > 8 && !gaps.empty() && medianOf(gaps) < 1.5 * steps.horizontal;
}

// Decides which cells are neighbours on one surface.
class Linking {
  public:
    Linking(const Scan& scan, double sameSurface, const ScanGrid& grid)
        : scan_(scan), grid_(grid), sameSurface_(sameSurface),
          // Two steps each way and noise: what is farther apart is a hole in the grid or a damaged index.
          chord_(std::min(4.0 * std::max(grid.steps.horizontal, grid.steps.vertical), 0.5)) {}

    bool areOneSurface(int x, int y, int dx, int dy) const {
        const std::optional<glm::dvec3> a = pointAt(x, y), b = pointAt(x + dx, y + dy);
        if (!a || !b) return false;
        const double rangeA = glm::length(*a), rangeB = glm::length(*b);
        if (glm::distance(*a / rangeA, *b / rangeB) > chord_) return false;
        const double jump = std::max(rangeA, rangeB) / std::min(rangeA, rangeB) - 1.0;
        if (jump <= sameSurface_) return true;
        if (jump > kSteepest * sameSurface_) return false;
        const double offA = offPlane(pointAt(x - dx, y - dy), rangeA, rangeB);
        const double offB = offPlane(pointAt(x + 2 * dx, y + 2 * dy), rangeB, rangeA);
        const double bound = kOffPlane * sameSurface_;
        if (std::abs(offA) <= bound || std::abs(offB) <= bound) return true;
        return jump <= kSteepestCrease * sameSurface_ && offA * offB > 0;
    }

  private:
    // In units of sameSurface: the relative change of range from cell to cell beyond which even a plane is
    // not believed, nor a crease, and how far a point may be off the plane.
    static constexpr double kSteepest = 10.0, kSteepestCrease = 3.0, kOffPlane = 0.5;

    std::optional<glm::dvec3> pointAt(int x, int y) const {
        const int width = grid_.pointOfCell.width();
        if (grid_.closes) x = (x + width) % width;
        if (x < 0 || y < 0 || x >= width || y >= grid_.pointOfCell.height()) return std::nullopt;
        const std::int32_t point = grid_.pointOfCell(x, y);
        if (point < 0) return std::nullopt;
        return glm::dvec3(scan_.pointsInScanner[static_cast<std::size_t>(point)]);
    }

    // How far, relatively, `next` lies before (> 0) or behind the plane through the point before and the one
    // at `range`.
    static double offPlane(const std::optional<glm::dvec3>& before, double range, double next) {
        if (!before) return std::numeric_limits<double>::quiet_NaN(); // which is within no bound and has no sign
        const double expected = 2.0 / range - 1.0 / glm::length(*before);
        return 1.0 - expected * next;
    }

    const Scan& scan_;
    const ScanGrid& grid_;
    double sameSurface_, chord_;
};

void linkCells(const Scan& scan, double sameSurface, ScanGrid& grid) {
    const int width = grid.pointOfCell.width(), height = grid.pointOfCell.height();
    grid.links = Image<std::uint8_t>(width, height, 0);
    const Linking linking(scan, sameSurface, grid);
    tbb::parallel_for(0, height, [&](int y) {
        for (int x = 0; x < width; ++x) {
            if (grid.pointOfCell(x, y) < 0) continue;
            const bool right = linking.areOneSurface(x, y, 1, 0), below = linking.areOneSurface(x, y, 0, 1);
            grid.links(x, y) = static_cast<std::uint8_t>((right ? kLinkRight : 0) | (below ? kLinkBelow : 0));
        }
    });
}

} // namespace

std::optional<ScanGrid> gridOf(const Scan& scan, double sameSurface) {
    // A triangle of the mesh is known by four times its cell's index, in 32 bits.
    constexpr std::int64_t kMostCells = 1 << 30;
    if (scan.rows < 2 || scan.columns < 2 || std::int64_t{scan.rows} * scan.columns > kMostCells) return std::nullopt;
    assert(scan.row.size() == scan.pointsInScanner.size() && scan.column.size() == scan.row.size());
    ScanGrid grid;
    grid.pointOfCell = Image<std::int32_t>(scan.columns, scan.rows, -1);
    for (std::size_t i = scan.row.size(); i-- > 0;) {
        const glm::vec3& p = scan.pointsInScanner[i];
        if (glm::length(glm::dvec3(p)) >= kNearestMetres)
            grid.pointOfCell(scan.column[i], scan.row[i]) = static_cast<std::int32_t>(i);
    }
    const auto steps = stepsOf(scan, grid.pointOfCell);
    if (!steps) return std::nullopt;
    grid.steps = *steps;
    grid.closes = closesOf(scan, grid.pointOfCell, *steps);
    linkCells(scan, sameSurface, grid);
    return grid;
}

} // namespace scene
