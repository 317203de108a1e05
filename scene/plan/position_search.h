#pragma once
// The article's search for reference positions (on Delaunay cells, sections 5 and 6), to compare with: position by
// position, each where the images that are drawn there know least of what is seen, weighed by how much room it is. That
// place is looked for genetically in every cell. A second way is the same with a memory: it asks the objective once for
// each place and never in cells that cannot win. What builds take is scene/plan/sight_search.h.
//
// What differs from the article: places are those where one can stand (a grid over the floors), not all of space, and
// those beyond the hull of the positions count to the cell they are nearest to; so the search begins with one position
// and needs no hull to be given. The volume of a cell is the number of places in it.

#include "scene/depth_image.h"
#include "scene/plan/unknown_space.h"

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

namespace scene {

enum class CellSearch { genetic, remembering };

struct PositionSearchOptions {
    int count = 8;
    CellSearch search = CellSearch::genetic;
    int geneticIndividuals = 4; ///< as in the article
    int geneticIterations = 50; ///< of two children each; the article has 50 to 150
    /// Ends earlier when the most that a further position could make known, as a share of all that is seen from all
    /// places, falls below this; 0: never.
    double leastGain = 0;
    std::uint32_t seed = 1;
    UnknownSpaceOptions unknown;
};

/// After each position.
struct PositionSearchStep {
    glm::dvec3 position{0};
    std::int64_t evaluations = 0; ///< of the objective, for this position; genetic: each child anew, as in the article
    double unknownShare = 0;      ///< of what is seen from the test places, by the cells' images
};

/// The small images of a position.
using CaptureSmall = std::function<std::vector<DepthImage>(const glm::dvec3& position)>;

/// places: where positions may stand; at least options.count. The first position is the first of them. testPlaces:
/// where unknownShare is taken. A function of its arguments alone, on any number of threads. told: after each step.
std::vector<PositionSearchStep> searchPositions(std::span<const glm::dvec3> places,
                                                std::span<const glm::dvec3> testPlaces, const CaptureSmall& capture,
                                                const PositionSearchOptions& options,
                                                const std::function<void(const PositionSearchStep&)>& told = {});

/// The same share for positions that were chosen otherwise, of all of them.
double unknownShareOf(std::span<const glm::dvec3> positions, std::span<const glm::dvec3> testPlaces,
                      const CaptureSmall& capture, const UnknownSpaceOptions& options = {});

} // namespace scene
