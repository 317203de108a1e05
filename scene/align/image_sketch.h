#pragma once
// What of a photograph with range is needed to lay it on others: smaller, so that those of a whole capture are held at
// once.

#include "scene/depth_image.h"

#include <vector>

namespace scene {

struct ImageSketch {
    /// Camera, pose, disparity and flags of the smaller picture; a sample stands for a square of the photograph's, and
    /// is there if those of it that have range are of one surface. No colour.
    DepthImage depth;
    /// Logarithms of linear light without broad shading, of the smaller picture, then of halves of it: what changes
    /// with exposure and light is gone.
    std::vector<Image<float>> greys;
};

/// shrink: so many pixels of the photograph, each way, become one.
ImageSketch sketchOf(const DepthImage& image, int shrink);

/// Bytes that it takes.
std::size_t bytesOfSketch(const Camera& camera, int shrink);

} // namespace scene
