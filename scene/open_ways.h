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
// About the eye cells are finer (scene/open_grid.h): an octant's ways are found there first, and go on in the wider
// cells around from where they left the finer ones.
//
// Of cells and portals (Teller and Sequin, "Visibility preprocessing for interactive walkthroughs", 1991) what needs
// neither walls nor doors to be known: coarse, and never too little.

#include "scene/open_grid.h"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace scene {

/// What may be seen from about some eyes; they may move a little before it must be found anew. Of each layer of the
/// grid it takes four megabytes, and as many for cells of finer layers.
class OpenWays {
  public:
    /// Finds it anew if an eye has left the place that it was found for. Of eyes in or right beside cells in which
    /// anything is unseen, or outside of the cube, nothing is known: they may see anything, since pictures let an eye
    /// look out of unseen space. Returns whether it was found anew. The grid must be the one of the call before, or
    /// all of that forgotten.
    bool standAt(const OpenGrid& grid, std::span<const glm::dvec3> eyesInWorld);

    /// Whether of these eyes anything can be known.
    static bool standClear(const OpenGrid& grid, std::span<const glm::dvec3> eyesInWorld);

    /// They may see anything, from now on.
    void forget();
    bool isKnown() const { return isKnown_; }

    /// Whether the eyes may see something within the box (metres, world), or as far beside it as `beside` times its
    /// distance.
    bool mayMeet(const glm::dvec3& least, const glm::dvec3& most, double beside) const;

  private:
    static constexpr int kBlock = 4, kBlocksAcross = kOpenCellsAcross / kBlock;
    /// Of blocks of four cells each way: along x, a bit each; by y, then by z.
    using Blocks = std::array<std::uint64_t, std::size_t{kBlocksAcross} * kBlocksAcross>;
    struct Octant {
        bool isMirrored; ///< against x: rows with their last cells first
        int stepY, stepZ;
    };
    /// Cells of a layer between two, both included.
    struct Part {
        GridCell low{}, high{};
    };
    /// What ways lead to, along x or against it; if that, last cells first.
    struct Reached {
        std::vector<CellRow> rows;
        int lowY = kOpenCellsAcross, highY = -1, lowZ = kOpenCellsAcross, highZ = -1; ///< of rows with any
        Blocks blocks{};

        void clear();
        void add(int y, int z, const CellRow& cells);
    };
    struct Layer {
        std::optional<OpenCells> own; ///< of finer layers; the widest is the grid's
        const OpenCells* cells = nullptr;
        Reached along, against; ///< in the end all is in the first
        Part finer;             ///< where the next layer knows better, unless this is the finest one
    };

    void knowNothing();
    bool centre(const OpenGrid& grid);
    bool areStillWithin() const;
    void gatherPlace();
    CellRow placeRow(int y, int z, bool isMirrored) const;
    void findWays(const Octant& octant);
    void sweep(Layer& layer, const Octant& octant, const Blocks* finer, Blocks& found) const;
    void summarize(std::size_t number);
    double cellMetresAbout(const glm::dvec3& least, const glm::dvec3& most) const;
    bool meets(const glm::dvec3& least, const glm::dvec3& most) const;
    bool meets(const Layer& layer, const glm::dvec3& least, const glm::dvec3& most) const;

    bool isKnown_ = false, leavesCube_ = false;
    std::vector<std::unique_ptr<Layer>> layers_; ///< the widest first; none if all is forgotten
    std::size_t used_ = 0;                       ///< of them; the finest may not hold all eyes
    std::vector<glm::dvec3> eyesInWorld_;
    Part place_;                        ///< in the finest layer, where eyes may stand
    std::vector<std::uint8_t> isPlace_; ///< and of its cells whether they may: x first, then y, then z
};

} // namespace scene
