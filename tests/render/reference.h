#pragma once
// What the warps should draw, worked out sample by sample in double precision and without any code of
// render/.

#include "scene/image.h"
#include "scene/tile.h"
#include "scene/view.h"

#include <span>

namespace render {

struct ReferenceImage {
    scene::Image<double> disparity; ///< of the eye, 1/m; negative where there is nothing
    scene::Image<scene::Rgb8> colour;
    scene::Image<std::uint8_t>
        isUncertain; ///< 1 where an edge passes so near to the pixel's centre that either is right
};

/// Squares of 1 to maxFootprint pixels, as wide as the sample is seen at the most magnified corner of its tile, in
/// plain order of z, where what is about a sample's own pixel counts as a hundredth less near.
ReferenceImage referencePoints(std::span<const scene::TileBlock> blocks, const scene::View& view, int maxFootprint);

/// Every triangle over every pixel of its box. Colours are mixed by the shares of the corners on the screen.
ReferenceImage referenceMesh(std::span<const scene::TileBlock> blocks, const scene::View& view);

} // namespace render
