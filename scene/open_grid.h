#pragma once
// Of which cells of a grid anything was observed: the tree of what was observed (scene/coverage.h) in rows of bits, as
// a sweep over many cells wants it (scene/open_ways.h). One layer of cells takes in the coverage's whole cube; where
// those are wide, as at a large site, others about whoever asks are finer, each of cells a quarter as wide:
//
//     +---------------------------+
//     |   .   .   .   .   .   .   |     All layers have as many cells. Walls are thinner than the widest ones, and
//     |           +-------+       |     nothing would be hidden by them; far away they are all that is needed.
//     |   .   .   |:::+-+:|   .   |
//     |           |:::|#|:|       |     (After the nested grids of Losasso and Hoppe, "Geometry clipmaps", 2004.)
//     |   .   .   +-------+   .   |
//     +---------------------------+

#include "scene/coverage.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace scene {

inline constexpr int kOpenCellsAcross = 256; ///< of each layer, along each edge
inline constexpr int kWidestLevel = 4;       ///< of the tree, whose cells the widest layer has

/// Cells are no finer than is needed for this, metres: walls between rooms are not much thinner.
inline constexpr double kFineEnoughMetres = 0.05;
inline constexpr int kMostLayers = 3;

/// A cell of a layer, or of a level of the tree.
using GridCell = std::array<int, 3>;

/// A bit for each cell of a row along x.
using CellRow = std::array<std::uint64_t, kOpenCellsAcross / 64>;

/// A layer: a cube of cells of one level of the tree. Open: not unseen all through.
class OpenCells {
  public:
    /// first: the layer's first cell, of all of that level; multiples of four.
    OpenCells(const Coverage& coverage, int level, const GridCell& first);

    const GridCell& first() const { return first_; }
    double cellMetres() const { return cellMetres_; }
    glm::dvec3 inCells(const glm::dvec3& pInWorld) const { return (pInWorld - cornerInWorld_) / cellMetres_; }
    const CellRow& openRow(int y, int z) const { return open_[rowOf(y, z)]; }
    const CellRow& mirroredRow(int y, int z) const { return mirrored_[rowOf(y, z)]; } ///< its last cell first
    /// False outside of the layer.
    bool isOpen(const GridCell& cell) const;

    static std::size_t rowOf(int y, int z) {
        return static_cast<std::size_t>(z) * kOpenCellsAcross + static_cast<std::size_t>(y);
    }

  private:
    struct Slab; ///< of the rows, what one thread fills
    void open(const Coverage& coverage, std::size_t node, const GridCell& at, int edge, const Slab& slab);
    void fill(const GridCell& at, int edge, const Slab& slab);

    GridCell first_;
    double cellMetres_;
    glm::dvec3 cornerInWorld_;
    std::vector<CellRow> open_, mirrored_;
};

/// The layer of the whole cube, and what finer ones are made of.
class OpenGrid {
  public:
    /// The coverage must outlive it, where it is.
    explicit OpenGrid(const Coverage& coverage, double fineEnoughMetres = kFineEnoughMetres);
    explicit OpenGrid(Coverage&&, double = 0) = delete;

    const Coverage& coverage() const { return *coverage_; }
    const OpenCells& whole() const { return whole_; }
    int layers() const { return layers_; } ///< at least one; the last has the finest cells
    double cellMetres() const { return whole_.cellMetres(); }
    double finestMetres() const { return finestCellMetres_; }

    /// Whether nothing of a place is unseen: of the cell of the finest layer that it is in, and false outside.
    bool isClear(const glm::dvec3& pInWorld) const;

    /// Layers from 1 on, finer ones. Where one begins that is about a place, as far as the cube reaches.
    GridCell firstAbout(const glm::dvec3& pInWorld, int layer) const;
    OpenCells layer(int number, const GridCell& first) const { return {*coverage_, kWidestLevel + number, first}; }

  private:
    const Coverage* coverage_;
    OpenCells whole_;
    int layers_ = 1;
    double finestCellMetres_;
};

/// The last bit first.
std::uint64_t mirrored(std::uint64_t word);
CellRow mirrored(const CellRow& row);

} // namespace scene
