#pragma once
// What a renderer must be ready for to draw at a quality.

#include "render/quality.h"

#include <vector>

namespace render {

/// How far outside the image a sample may stand and still touch it, pixels. isStreamed: chunks of the scene may be
/// missing, and coarse samples stand in for them.
double marginOf(const Quality& quality, bool isStreamed);

/// Whether gaps of a pixel are taken for filled when hidden tiles are looked for. Meshes have gaps at silhouettes
/// alone, and what is seen through those is not for the filler to make up.
bool closesGaps(const Quality& quality);

/// All that may be drawn with, the quality's own warp first. Scraps of the adaptive mesh are points, and what bends is
/// squares; and so is what stands in for missing chunks, or is right before the eye. What is in no square is points.
std::vector<Warp> warpsFor(const Quality& quality, bool isStreamed);

} // namespace render
