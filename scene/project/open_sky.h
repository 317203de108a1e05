#pragma once
// Which directions about a scanner met nothing but the sky. A ray that came back with nothing may have met glass, what
// is black or wet, or a hole that somebody cut; under the open sky most of them met nothing. Which it was no file says.
// Where somebody says that a scan was taken under the open sky, those are taken for sky that are above the horizon and
// hang together with the uppermost ones that came back with nothing:
//
//      . . . . . . . .     .  nothing came back, sky        a window below a roof  (x)  does not hang together with it,
//      . . o o o o . .     x  nothing came back, proves     nor does a slit in a crown of leaves: passages narrower
//      . o o x x o o .        nothing                       than three cells are none
//      o o o x x o o o     o  came back
//   ------------------------  horizon

#include "scene/image.h"
#include "scene/project/scan_grid.h"
#include "scene/scan.h"

#include <vector>

#include <glm/vec3.hpp>

namespace scene {

class OpenSky {
  public:
    /// Of none: no direction is open.
    OpenSky() = default;

    /// The horizon is level in the world, or, where the scanner's pose turns it over (worlds whose +Y is up), about its
    /// own axis. Nothing is open where cells' directions cannot be told: they must go evenly
    /// along rows and columns, by two angles about the scanner's z axis, and over the zenith if they like.
    OpenSky(const Scan& scan, const ScanGrid& grid);

    bool isEmpty() const { return share_ == 0; }
    double share() const { return share_; } ///< of the grid's cells

    /// Whether a ray of that direction (any length but 0) met the sky: only where all cells that look there did.
    bool isOpen(const glm::dvec3& directionInScanner) const;

    /// Unit directions, which reach as far as the open ones do, in the scanner's coordinates.
    const std::vector<glm::vec3>& directions() const { return directions_; }

  private:
    /// An angle that grows evenly with a cell's number.
    struct Even {
        double first = 0, step = 0; ///< radians, of cell 0 and from cell to cell
        double at(double cell) const { return first + step * cell; }
    };
    bool findDirections(const Scan& scan, const ScanGrid& grid);
    void findOpen(const Scan& scan, const ScanGrid& grid);
    glm::dvec3 directionOf(int x, int y) const;
    /// -1: beyond the grid, 0: not open, 1: open.
    int lookUp(double nod, double turn) const;

    Even nod_, turn_;        ///< of rows (0 level, a quarter turn the zenith, and on over it), of columns
    glm::dvec3 up_{0, 0, 1}; ///< in the scanner's coordinates
    bool closes_ = false;
    Image<std::uint8_t> open_; ///< by cell
    std::vector<glm::vec3> directions_;
    double share_ = 0;
};

} // namespace scene
