#pragma once
// Which way is up, of a capture whose files do not say: whoever holds a camera seldom holds it level, but floors,
// ceilings and tables are level, and walls stand upright. A walk space that leans makes walkers sick.

#include "scene/tile.h"

#include <span>
#include <vector>

#include <glm/vec3.hpp>

namespace scene {

/// A piece of plane surface.
struct Facing {
    glm::dvec3 normal{0}; ///< in the world, unit
    double area = 0;      ///< square metres, as if it were 10 m away at most
};

/// Those of an image's base tiles that are plane.
void addFacings(const TileBlock& block, std::vector<Facing>& facings);

/// The direction, at most 25 degrees from the guess (unit), that most of what is about level or about upright is
/// exactly level or upright to; the guess itself, where that is less than a fifth of all or no more than is so to the
/// guess.
glm::dvec3 levelled(const glm::dvec3& guess, std::span<const Facing> facings);

} // namespace scene
