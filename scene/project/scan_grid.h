#pragma once
// A structured scan's rows and columns: how densely they sample the directions about the scanner, and which
// neighbouring cells saw one surface.

#include "scene/image.h"
#include "scene/project/cube_layout.h"
#include "scene/scan.h"

#include <cstdint>
#include <optional>

namespace scene {

/// What links a cell to its neighbours.
enum CellLink : std::uint8_t {
    kLinkRight = 1 << 0, ///< the cell and the next one of its row are on one surface
    kLinkBelow = 1 << 1, ///< the cell and the next one of its column are
};

/// A scan's rows and columns as a mesh to look points up in.
struct ScanGrid {
    Image<std::int32_t> pointOfCell; ///< width columns, height rows; -1 where nothing returned
    Image<std::uint8_t> links;       ///< CellLink bits
    AngularSteps steps;
    bool closes = false; ///< the last column is the first one's neighbour: a full turn
};

/// The grid of a structured scan; nothing if it has none or if its cells are no regular directions about the
/// scanner (some programs write loose points as a grid). Of two points in a cell the first is the mesh's.
///
/// Two neighbours are on one surface if their ranges differ by at most sameSurface (relative), or if the
/// surface beside them, carried on as a plane, meets the other one: far floors and long walls fall away
/// faster than any fixed difference. Or if the surfaces on both sides, carried on, meet between them, as a
/// floor and a wall do.
///
///     1/range    o               o                        1/range of a plane is a straight line along rows
///     and along a      o               o   x                  columns (but for the square of the step). A
///     silhouette row            o             x     o      o o       is where the lines of neither side meet
///     the other.
///                      x         x         o         x x
///                  plane            crease    silhouette
std::optional<ScanGrid> gridOf(const Scan& scan, double sameSurface);

} // namespace scene
