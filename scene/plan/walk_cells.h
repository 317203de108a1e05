#pragma once
// Walk cells: the Delaunay triangulation of the positions that images were taken from, and which positions' images are
// drawn at any place, with what share of their samples. Everywhere a few positions suffice: the cost of a frame does
// not grow with their number. After an article on warping cube-map images of the corners of a tetrahedron (sections 4
// and 5: Delaunay cells of reference positions, smooth change between them).
//
// The rule. A cell within reach of the walker counts by how near it is, 1 - distance / reach; a position's share is the
// greatest of the cells that it is a corner of. So all corners of the walker's own cell have share 1, and others come
// from 0 as their cells come near. The paper's own rule (alpha = min di / (d0 + di)) gives a cell's share by its face
// alone: it jumps from 1 to 0 where a path crosses an edge. This one has no such place: along any path shares change by
// at most kShareSlope / (distance between positions there) for each metre.
//
// Beyond the hull of all positions a walker counts as standing at the hull's nearest place; the positions of a tripod
// lie in a plane, those of a corridor in a line: then cells are triangles or segments, and the walker counts as
// standing at the plane's or the line's nearest place. All of that moves no faster than the walker does.

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

namespace scene {

/// Corners: places in WalkCells::corners. dimension + 1 of them. Across the face opposite to corner i lies
/// neighbours[i], or nothing (kNoCell).
struct WalkCell {
    static constexpr std::uint32_t kNoCell = 0xffffffffu;
    std::uint32_t corners[4] = {0, 0, 0, 0};
    std::uint32_t neighbours[4] = {kNoCell, kNoCell, kNoCell, kNoCell};
};

/// Of the distance between neighbouring positions: how far before its border a cell's images begin to come.
inline constexpr double kReachShare = 0.2;
/// (1 + kReachShare) / kReachShare: see above.
inline constexpr double kShareSlope = 6;

struct PositionShare {
    std::uint32_t position = 0; ///< as the constructor was given them
    float share = 0;            ///< of its images' samples, in (0, 1]
};

class WalkCells {
  public:
    WalkCells() = default;
    /// positions in the world, metres, finite; any number of them, however they lie; equal ones are drawn together.
    /// What lies in a plane or a line but for a twentieth of the least distance between positions is taken to lie in
    /// it; within, exact predicates decide.
    explicit WalkCells(std::span<const glm::dvec3> positions);

    int dimension() const { return dimension_; } ///< of the cells, 0 to 3; -1 without positions
    std::span<const WalkCell> cells() const { return cells_; }
    std::span<const glm::dvec3> corners() const { return corners_; } ///< the positions that differ, in the world

    /// The cell that the walker counts as standing in (see above): itself, or the one nearest to it. from: where the
    /// search begins, such as what was found last. There must be a position.
    std::uint32_t locate(const glm::dvec3& p, std::uint32_t from = 0) const;

    /// Positions with a share greater than 0, ascending. cell: where the search begins; becomes the walker's cell.
    void sharesAt(const glm::dvec3& p, std::uint32_t& cell, std::vector<PositionShare>& shares) const;

    /// Those with all of their samples: the walker's cell's corners, ascending.
    std::vector<std::uint32_t> cornersAt(const glm::dvec3& p, std::uint32_t& cell) const;

    /// How far before a cell's border its images begin to come, metres.
    double reachAt(const glm::dvec3& p) const;

  private:
    struct Place {
        std::uint32_t cell = 0;
        glm::dvec3 at{0}; ///< where the walker counts as standing, about origin_
    };
    Place placeOf(const glm::dvec3& p, std::uint32_t from) const;
    Place nearestOnHull(const glm::dvec3& p) const;
    /// exact: what the predicates decide about. local: the same about origin_.
    void triangulate(std::span<const glm::dvec3> positions, std::span<const glm::dvec3> exact,
                     std::span<const glm::dvec3> local);
    glm::dvec3 nearestIn(const WalkCell& cell, const glm::dvec3& p) const;
    double reachFrom(const glm::dvec3& at) const;
    void findOutward();

    int dimension_ = -1;
    std::vector<glm::dvec3> corners_;
    std::vector<WalkCell> cells_;
    std::vector<std::uint32_t> firstOf_, positionsOf_; ///< the positions of each corner

    // About an origin amid the positions, so that a place in a national grid is as good as any.
    glm::dvec3 origin_{0};
    std::vector<glm::dvec3> local_;     ///< corners
    std::vector<double> spacing_;       ///< of each corner: to the nearest other one, metres
    std::vector<glm::dvec3> outward_;   ///< of each cell dimension + 1: unit normals of its faces, that point out of it
    std::vector<std::uint32_t> onHull_; ///< cell * 4 + face, of the faces with nothing beyond
    glm::dvec3 span_{0};                ///< dimension 1: the line's direction; dimension 2: the plane's normal
};

} // namespace scene
