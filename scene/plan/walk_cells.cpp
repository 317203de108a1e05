#include "scene/plan/walk_cells.h"

#include "scene/plan/simplex.h"

#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Spatial_sort_traits_adapter_3.h>
#include <CGAL/Triangulation_cell_base_with_info_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>
#include <CGAL/property_map.h>
#include <CGAL/spatial_sort.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <unordered_set>
#include <utility>

#include <Eigen/Eigenvalues>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scene {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_3<std::uint32_t, Kernel>;
using CellBase =
    CGAL::Triangulation_cell_base_with_info_3<std::uint32_t, Kernel, CGAL::Delaunay_triangulation_cell_base_3<Kernel>>;
using Delaunay = CGAL::Delaunay_triangulation_3<Kernel, CGAL::Triangulation_data_structure_3<VertexBase, CellBase>>;

constexpr std::uint32_t kNone = WalkCell::kNoCell;

/// What lies beyond a face by less than this share of the distance between positions lies on it: else rounding could
/// send the search to and fro.
constexpr double kOnFace = 1e-12;

/// Positions that lie in a plane or a line but for this share of the least distance between them are taken to lie in
/// it: floors and tripods are never exact, and cells as thin as a hair would have corners at opposite ends of a scene.
constexpr double kFlatShare = 0.05;

/// The corners of the face opposite to each corner of a tetrahedron that CGAL calls positive, so that their normal
/// points outward.
constexpr std::array<std::array<std::size_t, 3>, 4> kFaces{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

/// In an order in which neighbours come soon after one another.
std::vector<std::size_t> spatialOrder(const std::vector<Kernel::Point_3>& points) {
    std::vector<std::size_t> order(points.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    const auto map = CGAL::make_property_map(points);
    using Traits = CGAL::Spatial_sort_traits_adapter_3<Kernel, decltype(map)>;
    CGAL::spatial_sort(order.begin(), order.end(), Traits(map));
    return order;
}

/// Axes of what positions spread along, most first.
struct Frame {
    glm::dmat3 axes{1.0};
    glm::dvec3 middle{0};
    int dimension = 3; ///< that are kept
    glm::dvec3 into(const glm::dvec3& p) const {
        glm::dvec3 at = glm::transpose(axes) * (p - middle);
        for (int i = dimension; i < 3; ++i)
            at[i] = 0;
        return at;
    }
    glm::dvec3 outOf(const glm::dvec3& at) const { return middle + axes * at; }
};

/// The plane or line that all positions lie in but for a little (kFlatShare); nothing if they do not, or exactly.
std::optional<Frame> flatFrameOf(std::span<const glm::dvec3> positions, std::span<const double> spacing,
                                 int dimension) {
    if (dimension < 2) return std::nullopt;
    Frame frame;
    for (const glm::dvec3& p : positions)
        frame.middle += p / static_cast<double>(positions.size());
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (const glm::dvec3& p : positions) {
        const Eigen::Vector3d d(p.x - frame.middle.x, p.y - frame.middle.y, p.z - frame.middle.z);
        spread += d * d.transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread);
    for (int i = 0; i < 3; ++i) {
        const Eigen::Vector3d axis = solver.eigenvectors().col(2 - i);
        frame.axes[i] = {axis.x(), axis.y(), axis.z()};
    }
    const double most = kFlatShare * *std::min_element(spacing.begin(), spacing.end());
    glm::dvec3 reach(0);
    for (const glm::dvec3& p : positions)
        reach = glm::max(reach, glm::abs(glm::transpose(frame.axes) * (p - frame.middle)));
    frame.dimension = reach.y <= most ? 1 : reach.z <= most ? 2 : 3;
    if (frame.dimension >= dimension) return std::nullopt;
    return frame;
}

} // namespace

WalkCells::WalkCells(std::span<const glm::dvec3> positions) {
    if (positions.empty()) return;
    origin_ = positions[0];
    std::vector<glm::dvec3> local;
    for (const glm::dvec3& p : positions) {
        assert(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
        local.push_back(p - origin_);
    }
    triangulate(positions, positions, local);
    if (const std::optional<Frame> frame = flatFrameOf(local_, spacing_, dimension_)) {
        std::vector<glm::dvec3> flat;
        for (glm::dvec3& p : local) {
            flat.push_back(frame->into(p));
            p = frame->outOf(flat.back());
        }
        triangulate(positions, flat, local);
    }
    findOutward();
}

void WalkCells::triangulate(std::span<const glm::dvec3> positions, std::span<const glm::dvec3> exact,
                            std::span<const glm::dvec3> local) {
    corners_.clear(), cells_.clear(), local_.clear();
    std::vector<Kernel::Point_3> points;
    for (const glm::dvec3& p : exact)
        points.emplace_back(p.x, p.y, p.z);
    Delaunay delaunay;
    Delaunay::Vertex_handle last;
    std::vector<std::uint32_t> cornerOf(positions.size());
    for (const std::size_t i : spatialOrder(points)) {
        const std::size_t before = delaunay.number_of_vertices();
        last = before == 0 ? delaunay.insert(points[i]) : delaunay.insert(points[i], last);
        if (delaunay.number_of_vertices() > before) {
            last->info() = static_cast<std::uint32_t>(corners_.size());
            corners_.push_back(positions[i]);
            local_.push_back(local[i]);
        }
        cornerOf[i] = last->info();
    }
    dimension_ = delaunay.dimension();

    firstOf_.assign(corners_.size() + 1, 0);
    for (const std::uint32_t corner : cornerOf)
        ++firstOf_[corner + 1];
    for (std::size_t i = 1; i < firstOf_.size(); ++i)
        firstOf_[i] += firstOf_[i - 1];
    positionsOf_.resize(positions.size());
    std::vector<std::uint32_t> next(firstOf_.begin(), firstOf_.end() - 1);
    for (std::uint32_t i = 0; i < positions.size(); ++i)
        positionsOf_[next[cornerOf[i]]++] = i;

    spacing_.assign(corners_.size(), std::numeric_limits<double>::infinity());

    const int faces = dimension_ + 1;
    if (dimension_ == 0) {
        cells_.emplace_back();
    } else {
        // Below three dimensions the container holds triangles or segments as cells with corners to spare.
        auto& all = delaunay.tds().cells();
        std::uint32_t count = 0;
        for (auto cell = all.begin(); cell != all.end(); ++cell)
            cell->info() = cell->has_vertex(delaunay.infinite_vertex()) ? kNone : count++;
        cells_.reserve(count);
        for (auto cell = all.begin(); cell != all.end(); ++cell) {
            if (cell->info() == kNone) continue;
            WalkCell& made = cells_.emplace_back();
            for (int i = 0; i < faces; ++i) {
                made.corners[i] = cell->vertex(i)->info();
                made.neighbours[i] = cell->neighbor(i)->info();
            }
        }
    }
    for (const WalkCell& cell : cells_)
        for (int i = 0; i < faces; ++i)
            for (int k = 0; k < i; ++k) {
                // Nearest neighbours share an edge of a Delaunay triangulation.
                const std::uint32_t a = cell.corners[i], b = cell.corners[k];
                const double distance = glm::length(local_[a] - local_[b]);
                spacing_[a] = std::min(spacing_[a], distance), spacing_[b] = std::min(spacing_[b], distance);
            }
}

void WalkCells::findOutward() {
    const auto corner = [&](const WalkCell& cell, std::size_t i) { return local_[cell.corners[i]]; };
    const std::size_t faces = static_cast<std::size_t>(dimension_) + 1;
    // Of the widest cell, whose plane or line is the surest.
    double widest = 0;
    for (const WalkCell& cell : cells_) {
        if (dimension_ != 1 && dimension_ != 2) break;
        const glm::dvec3 edge = corner(cell, 1) - corner(cell, 0);
        const glm::dvec3 across = dimension_ == 1 ? edge : glm::cross(edge, corner(cell, 2) - corner(cell, 0));
        if (glm::length(across) <= widest) continue;
        widest = glm::length(across);
        span_ = across / widest;
    }
    outward_.assign(faces * cells_.size(), glm::dvec3(0));
    for (std::uint32_t c = 0; c < cells_.size(); ++c)
        for (std::size_t i = 0; i < faces && dimension_ > 0; ++i) {
            const WalkCell& cell = cells_[c];
            glm::dvec3 normal;
            if (dimension_ == 1) {
                normal = corner(cell, 1 - i) - corner(cell, i);
            } else if (dimension_ == 2) {
                const glm::dvec3 a = corner(cell, (i + 1) % 3), b = corner(cell, (i + 2) % 3);
                normal = glm::cross(b - a, span_);
                if (glm::dot(normal, corner(cell, i) - a) > 0) normal = -normal;
            } else {
                const glm::dvec3 a = corner(cell, kFaces[i][0]);
                normal = glm::cross(corner(cell, kFaces[i][1]) - a, corner(cell, kFaces[i][2]) - a);
            }
            const double length = glm::length(normal);
            outward_[faces * c + i] = length > 0 ? normal / length : glm::dvec3(0);
            if (cell.neighbours[i] == kNone) onHull_.push_back(4 * c + static_cast<std::uint32_t>(i));
        }
}

glm::dvec3 WalkCells::nearestIn(const WalkCell& cell, const glm::dvec3& p) const {
    std::array<glm::dvec3, 4> corners{};
    const std::size_t count = static_cast<std::size_t>(dimension_) + 1;
    for (std::size_t i = 0; i < count; ++i)
        corners[i] = local_[cell.corners[i]];
    return nearestInSimplex(std::span(corners).first(count), p);
}

WalkCells::Place WalkCells::nearestOnHull(const glm::dvec3& p) const {
    Place nearest;
    double least = std::numeric_limits<double>::infinity();
    for (const std::uint32_t face : onHull_) {
        const WalkCell& cell = cells_[face / 4];
        std::array<glm::dvec3, 3> corners{};
        std::size_t count = 0;
        for (std::uint32_t i = 0; i <= static_cast<std::uint32_t>(dimension_); ++i)
            if (i != face % 4) corners[count++] = local_[cell.corners[i]];
        const glm::dvec3 at = nearestInSimplex(std::span(corners).first(count), p);
        const double square = glm::dot(at - p, at - p);
        if (square < least) least = square, nearest = {face / 4, at};
    }
    return nearest;
}

WalkCells::Place WalkCells::placeOf(const glm::dvec3& pInWorld, std::uint32_t from) const {
    assert(dimension_ >= 0);
    if (dimension_ == 0) return {0, local_[0]};
    glm::dvec3 p = pInWorld - origin_;
    if (dimension_ == 1) p = local_[0] + glm::dot(p - local_[0], span_) * span_;
    if (dimension_ == 2) p -= glm::dot(p - local_[0], span_) * span_;

    const std::uint32_t faces = static_cast<std::uint32_t>(dimension_) + 1;
    std::uint32_t at = from < cells_.size() ? from : 0;
    // A search that always goes on across the face that the place is farthest beyond does not come back to a cell of a
    // Delaunay triangulation; rounding could make it.
    for (std::size_t steps = 0; steps <= cells_.size(); ++steps) {
        const WalkCell& cell = cells_[at];
        double farthest = 0;
        std::uint32_t next = kNone;
        bool isBeyondHull = false;
        for (std::uint32_t i = 0; i < faces; ++i) {
            const std::uint32_t onFace = cell.corners[i == 0 ? 1 : 0];
            const double beyond = glm::dot(outward_[faces * at + i], p - local_[onFace]);
            if (beyond <= kOnFace * spacing_[onFace]) continue;
            if (cell.neighbours[i] == kNone)
                isBeyondHull = true;
            else if (beyond > farthest)
                farthest = beyond, next = cell.neighbours[i];
        }
        if (next == kNone) return isBeyondHull ? nearestOnHull(p) : Place{at, p};
        at = next;
    }
    Place nearest{0, p};
    double least = std::numeric_limits<double>::infinity();
    for (std::uint32_t i = 0; i < cells_.size(); ++i)
        if (const glm::dvec3 place = nearestIn(cells_[i], p); glm::length(place - p) < least)
            least = glm::length(place - p), nearest = {i, place};
    return nearest;
}

std::uint32_t WalkCells::locate(const glm::dvec3& p, std::uint32_t from) const {
    return placeOf(p, from).cell;
}

std::vector<std::uint32_t> WalkCells::cornersAt(const glm::dvec3& p, std::uint32_t& cell) const {
    std::vector<PositionShare> shares;
    sharesAt(p, cell, shares);
    std::vector<std::uint32_t> corners;
    for (const PositionShare& share : shares)
        if (share.share >= 1) corners.push_back(share.position);
    return corners;
}

double WalkCells::reachAt(const glm::dvec3& p) const {
    return reachFrom(placeOf(p, 0).at);
}

double WalkCells::reachFrom(const glm::dvec3& at) const {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < local_.size(); ++i)
        least = std::min(least, spacing_[i] + glm::length(local_[i] - at));
    return kReachShare * least;
}

void WalkCells::sharesAt(const glm::dvec3& p, std::uint32_t& cell, std::vector<PositionShare>& shares) const {
    shares.clear();
    if (dimension_ < 0) return;
    const Place place = placeOf(p, cell);
    cell = place.cell;
    const auto add = [&](std::uint32_t corner, float share) {
        for (std::uint32_t i = firstOf_[corner]; i < firstOf_[corner + 1]; ++i)
            shares.push_back({positionsOf_[i], share});
    };
    const std::uint32_t faces = static_cast<std::uint32_t>(dimension_) + 1;
    const double reach = reachFrom(place.at);
    std::vector<std::uint32_t> found{cell};
    std::unordered_set<std::uint32_t> known{cell};
    for (std::size_t next = 0; next < found.size(); ++next) {
        const WalkCell& at = cells_[found[next]];
        const double distance = next == 0 ? 0 : glm::length(nearestIn(at, place.at) - place.at);
        if (distance >= reach) continue;
        for (std::uint32_t i = 0; i < faces; ++i) {
            add(at.corners[i], next == 0 ? 1.0f : static_cast<float>(1 - distance / reach));
            const std::uint32_t neighbour = at.neighbours[i];
            if (neighbour != kNone && known.insert(neighbour).second) found.push_back(neighbour);
        }
    }
    std::sort(shares.begin(), shares.end(), [](const PositionShare& a, const PositionShare& b) {
        return a.position != b.position ? a.position < b.position : a.share > b.share;
    });
    const auto isSame = [](const PositionShare& a, const PositionShare& b) { return a.position == b.position; };
    shares.erase(std::unique(shares.begin(), shares.end(), isSame), shares.end());
}

} // namespace scene
