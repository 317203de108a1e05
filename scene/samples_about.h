#pragma once
// How exactly the samples about a place say where it is: what is measured with them is known no better.

#include "scene/tile.h"

#include <cstddef>
#include <optional>
#include <span>

#include <glm/vec3.hpp>

namespace scene {

struct SamplesAbout {
    std::size_t image = 0;    ///< of the blocks: whose samples are the nearest
    double rangeMetres = 0;   ///< from its camera to the place
    double spacingMetres = 0; ///< between samples on the surface, the wider way: where an edge lies is not known better
    /// Standard deviation, along rays, from the plane through those about: noise, and what the surface bends. Nothing
    /// where there are too few.
    std::optional<double> scatterMetres;
};

/// Of those that were measured and are drawn for all eyes; nothing where none stands on a surface there, within two
/// samples beside the place and two hundredths of its range. Reads some hundred samples of each image that shows it.
std::optional<SamplesAbout> samplesAbout(std::span<const TileBlock> blocks, const glm::dvec3& placeInWorld);

} // namespace scene
