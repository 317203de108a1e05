#pragma once
// Reference positions by what they make known, found from lines of sight alone.
//
// The article on Delaunay cells (section 5) asks of a place how much is unknown there, by drawing pictures. Where most
// is unknown is often a corner from which little else is seen; a position is worth what walkers everywhere see better
// for it. So walkers are put at places all over, each with rays in all directions; what a ray meets is known to a
// position if nothing stands between, and if samples taken from there lie densely enough for that walker. All of that
// is found once, as bits. Then the very thing that is wanted is worked out for any set of positions: the share of the
// rays whose end none of the positions drawn there (scene/plan/walk_cells.h) knows. Positions are added greedily, each
// where the share falls most, and exchanged one by one for better ones while there are any (M. Teitz and P. Bart,
// "Heuristic methods for estimating the generalized vertex median of a weighted graph", 1968).

#include "scene/sight_lines.h"

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace scene {

struct SightSearchOptions {
    int count = 8;          ///< so many at most
    int walkers = 200;      ///< places from which one looks
    int looks = 96;         ///< rays from each, spread evenly
    int candidates = 800;   ///< places where positions may stand
    int exchanged = 64;     ///< of them, that are tried in place of one that was chosen: the nearest
    double mostStretch = 4; ///< between samples of a position, over what lies between as many looks of a walker
    double leastGain = 0;   ///< ends earlier where one more position makes known less than this share
    int exchangeRounds = 4; ///< through all positions, at most, after the last one
};

struct SightSearchResult {
    std::vector<glm::dvec3> positions;
    std::vector<double> unknownShares; ///< after each was added; exchanging lowers the last one further
    double unknownShare = 1;           ///< of what the walkers see
    std::int64_t rays = 0;             ///< that were cast
    std::int64_t trials = 0;           ///< sets of positions that were tried
};

/// places: where one can stand; walkers and candidates are spread over their order. A function of its arguments alone,
/// on any number of threads. told: after each position.
SightSearchResult searchBySight(std::span<const glm::dvec3> places, const SightLines& lines,
                                const SightSearchOptions& options, const std::function<void()>& told = {});

} // namespace scene
