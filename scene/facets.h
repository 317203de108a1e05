#pragma once
// The adaptive mesh: a plane is affine in (x, y, disparity), so wherever a tile's samples are, within a tolerance, its
// squares become one textured facet. Flat walls cost a facet a tile; only where a surface bends is it subdivided.

#include "scene/tile.h"

namespace scene {

/// What becomes of the squares of a tile that has got facets.
enum class Squares { stay, goWhereFacetsAre };

/// Of a facet's side, which is in squares.
inline std::uint32_t log2SideOf(const TileFacet& facet) {
    return facet.mark >> 12 & 7u;
}

/// Lays facets over the squares of the tiles of set.tiles: quadtrees of sides 32, 16, ... 1, each a plane that no
/// sample leaves by more than tolerance times its disparity; a single square that bends more is two halves. A tile
/// where that saves little (foliage), or that is a scrap, gets none. Neighbouring facets meet within that tolerance, so
/// seen from a camera b away, surfaces at z, cracks are at most 2 f tolerance b / z pixels wide. The largest of a tile
/// come first.
void layFacets(TileSet& set, float tolerance, Squares squares);

/// Appends another set's tiles, which have one level, as tiles of that level.
void appendLevel(TileSet& set, const TileSet& coarse, int level);

} // namespace scene
