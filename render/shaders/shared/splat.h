#ifndef RENDER_SHADERS_SHARED_SPLAT_H
#define RENDER_SHADERS_SHARED_SPLAT_H
// Quadratic splats (Nyland et al. 1999, section 5.4): circles of one colour whose depth falls off from their centres,
// so that of overlapping ones each pixel shows the nearest. scene/warp_splats.cpp is the same on the processor.

#include "render/shaders/shared/sample_place.h"
#include "render/shaders/shared/tile_draw.h"

SHARED_BEGIN

/// Share of its disparity that a splat loses from centre to rim: more than neighbouring samples of a slanted surface
/// differ by, and less than surfaces that are to be told apart.
SHARED_CONSTANT float kSplatFalloff = 0.01f;
/// Radius in pixels of all splats of a tile: the bits of span.x.
SHARED_FUNCTION float splatRadiusOf(TileDraw draw) {
    return uintBitsToFloat(draw.span.x);
}

/// Columns, or rows, that a splat may touch: as many from the first on, whatever its place in its pixel.
SHARED_FUNCTION int splatSideOf(float radius) {
    return int(floor(2.0f * radius)) + 1;
}
SHARED_FUNCTION float firstOfSplat(float position, float radius) {
    PRECISE float first = ceil(position - radius - 0.5f);
    return first;
}

/// Whether splats cover the pixel that they stand in and one beside it at most. With a centre a and b off its pixel's,
/// the squares of the distances to the next one across and to the next one along add up to 1 at least; within a
/// thousandth of a pixel of where four meet, one of them is left out. scene/warp_splats.cpp has the same.
SHARED_CONSTANT float kTwoPixels = 0.5000002f; ///< square of the radius: the least one's (scene/footprint.h), rounded
SHARED_FUNCTION bool coversTwoAtMost(float radius) {
    PRECISE float square = radius * radius;
    return square <= kTwoPixels;
}
/// The steps to that one beside. offset: from the splat's centre to that of the pixel it stands in.
SHARED_FUNCTION ivec2 nextOfSplat(vec2 offset) {
    bool isAcross = abs(offset.x) >= abs(offset.y);
    int across = offset.x < 0.0f ? 1 : -1, along = offset.y < 0.0f ? 1 : -1;
    return ivec2(isAcross ? across : 0, isAcross ? 0 : along);
}

/// The disparity of a splat at an offset from its centre, pixels; negative outside of it. perRadius2: 1 / radius^2.
SHARED_FUNCTION float splatDisparity(float disparity, vec2 offset, float perRadius2) {
    PRECISE float share = (offset.x * offset.x + offset.y * offset.y) * perRadius2;
    PRECISE float there = disparity * (1.0f - kSplatFalloff * share);
    return share > 1.0f ? -1.0f : there;
}

/// The key of a pixel that a splat covers, with its disparity there.
SHARED_FUNCTION uvec2 keyOfSplat(float disparity, vec2 offset, uint colour, uint levelAndClass) {
    return withPlace(packKey(disparity, colour, levelAndClass),
                     placeCode(offset, perPixelOf(placeStepsOfSplats().own)));
}

SHARED_END

#endif
