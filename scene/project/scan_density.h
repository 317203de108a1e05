#pragma once
// How densely a scan samples the directions about it, and from where it is best looked at.

#include "scene/image.h"
#include "scene/project/cube_layout.h"
#include "scene/scan.h"

#include <cstdint>
#include <optional>

namespace scene {

/// A scan's rows and columns as a mesh to look points up in.
struct ScanGrid {
    Image<std::int32_t> pointOfCell; ///< width columns, height rows; -1 where nothing returned
    AngularSteps steps;
    bool closes = false; ///< the last column is the first one's neighbour: a full turn
};

/// The grid of a structured scan; nothing if it has none or if its cells are no regular directions about the
/// scanner (some programs write loose points as a grid). Of two points in a cell the first is the mesh's.
std::optional<ScanGrid> gridOf(const Scan& scan);

/// Median angle between a loose point's direction and the nearest other one, as seen from a place.
AngularSteps looseSteps(const Scan& scan, const glm::dvec3& copInScanner);

/// Where loose points are projected from: the scanner's origin, unless points crowd it.
glm::dvec3 viewpointOf(const Scan& scan);

} // namespace scene
