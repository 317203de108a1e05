#pragma once
// What eyes may see of a scene whose unseen space is shown (scene/coverage.h): where every way to a place leads through
// space that no image observed, its surfaces are never drawn, and need not be asked for. Rooms behind walls, floors
// above floors.
//
//     +-----------+   +---------+     e: the eye. Rays go on along each axis or back, never both, and end where a
//     | . . . . . |###| # # # # |     cell is unseen all through (#). What no such way leads to (x) is seen from
//     | . e . . . . . . # # x x |     nowhere about the eye: a sweep over the grid for each of the eight octants
//     | . . . . . |###| . # # x |     finds all ways at once, sixty-four cells of a row at a time.
//     +-----------+   +---------+
//
// Of cells and portals (Teller and Sequin, "Visibility preprocessing for interactive walkthroughs", 1991) what needs
// neither walls nor doors to be known: coarse, and never too little.

#include "scene/coverage.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace scene {

inline constexpr int kOpenGridAcross = 256; ///< cells along the edge of the coverage's cube

/// A cell of the grid.
using GridCell = std::array<int, 3>;

/// Which cells of a grid over the coverage's cube hold anything that is not unseen, and which nothing that is.
class OpenGrid {
  public:
    using Row = std::array<std::uint64_t, kOpenGridAcross / 64>; ///< a bit for each cell, along x

    explicit OpenGrid(const Coverage& coverage);

    const glm::dvec3& cornerInWorld() const { return cornerInWorld_; }
    double cellMetres() const { return cellMetres_; }
    const Row& openRow(int y, int z) const { return open_[rowOf(y, z)]; }
    const Row& mirroredRow(int y, int z) const { return mirrored_[rowOf(y, z)]; } ///< its last cell first
    /// False outside of the grid.
    bool isOpen(const GridCell& cell) const { return holds(open_, cell); }
    bool isClear(const GridCell& cell) const { return holds(clear_, cell); }

    static std::size_t rowOf(int y, int z) {
        return static_cast<std::size_t>(z) * kOpenGridAcross + static_cast<std::size_t>(y);
    }

  private:
    void openCells(const Coverage& coverage, std::size_t node, const GridCell& first, int edge);
    static void fill(std::vector<Row>& rows, const GridCell& first, int edge);
    static bool holds(const std::vector<Row>& rows, const GridCell& cell);

    glm::dvec3 cornerInWorld_;
    double cellMetres_;
    std::vector<Row> open_, mirrored_, clear_;
};

/// What may be seen from about some eyes; they may move a little before it must be found anew.
class OpenWays {
  public:
    /// Finds it anew if an eye has left the place that it was found for. Of eyes in or right beside cells in which
    /// anything is unseen, or outside of the cube, nothing is known: they may see anything, since pictures let an eye
    /// look out of unseen space. Returns whether it was found anew.
    bool standAt(const OpenGrid& grid, std::span<const glm::dvec3> eyesInWorld);

    /// They may see anything, from now on.
    void forget();
    bool isKnown() const { return isKnown_; }

    /// Whether the eyes may see something within the box (metres, world), or as far beside it as `beside` times its
    /// distance.
    bool mayMeet(const glm::dvec3& least, const glm::dvec3& most, double beside) const;

  private:
    using Row = OpenGrid::Row;

    bool areStillWithin(const OpenGrid& grid, std::span<const glm::dvec3> eyesInWorld) const;
    void gatherPlace(const OpenGrid& grid, std::span<const glm::dvec3> eyesInWorld);
    void sweep(const OpenGrid& grid, bool isMirrored, int stepY, int stepZ, std::vector<Row>& reached) const;
    void summarize();
    bool meets(const glm::dvec3& least, const glm::dvec3& most) const;

    bool isKnown_ = false, leavesCube_ = false;
    glm::dvec3 cornerInWorld_{0};
    double cellMetres_ = 0;
    std::vector<glm::dvec3> eyesInWorld_;
    GridCell low_{}, high_{};              ///< the cells of the place, all between them
    std::vector<std::uint8_t> isPlace_;    ///< of those, whether an eye may stand there: x first, then y, then z
    std::vector<Row> reached_, backwards_; ///< along x, and against it: their last cells first
    std::vector<std::uint64_t> blocks_;    ///< of four cells each way, along x; by y, then by z
};

} // namespace scene
