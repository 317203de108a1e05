#pragma once
// Levels of detail: a depth image halved again and again, and the tiles of each (row O5: from twice as far, half the
// samples along a line do).
//
// A coarse sample never averages over a silhouette, so that none floats between two surfaces: it takes the part in
// which most of its four agree, the nearer of two alike, and what a tile keeps comes before what it does not.

#include "scene/depth_image.h"
#include "scene/tile.h"

namespace scene {

struct PyramidOptions {
    float sameSurface = 0.03f; ///< relative difference in disparity up to which two samples are averaged
    int tileSize = kDefaultTileSize;
    float facetTolerance = 0.003f; ///< see scene/facets.h
};

/// The camera of an image of half the width and height, rounded up: its sample (x, y) stands for (2 x, 2 y) to
/// (2 x + 1, 2 y + 1).
Camera halve(const Camera& camera);

/// The same, level times.
Camera cameraAtLevel(const Camera& camera, int level);

/// The image with half as many samples a side. A coarse sample is of the first tier of which a sample is kept below it;
/// measured ones are averaged by themselves, and where most of one surface is closed or guessed the whole is closed, or
/// a few measured samples would vouch for ever more from level to level.
/// A triangle is a skin where there was one and its corners are no one surface.
DepthImage halve(const DepthImage& image, const PyramidOptions& options);

/// The tiles of an image and of its coarser levels, with facets (scene/facets.h). Squares of coarser levels stay only
/// where there are no facets.
TileSet cutIntoLevels(const DepthImage& image, const PyramidOptions& options);

} // namespace scene
