#pragma once
// Depth images as tiles, for tests that look at tiles.

#include "scene/depth_image.h"
#include "scene/tile.h"

#include <cstddef>
#include <utility>
#include <vector>

namespace scene {

/// Images cut into tiles, and who lends them.
struct Tiled {
    std::vector<DepthImage> images;
    std::vector<TileSet> sets;
    std::vector<TileBlock> blocks;

    explicit Tiled(std::vector<DepthImage> taken) : images(std::move(taken)) {
        for (const DepthImage& image : images)
            sets.push_back(cutIntoTiles(image));
        for (std::size_t i = 0; i < images.size(); ++i)
            blocks.push_back(lend(sets[i], images[i].camera, images[i].worldFromCamera));
    }
};

} // namespace scene
