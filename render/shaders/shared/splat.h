#ifndef RENDER_SHADERS_SHARED_SPLAT_H
#define RENDER_SHADERS_SHARED_SPLAT_H
// Quadratic splats (Nyland et al. 1999, section 5.4): circles of one colour whose depth falls off from their centres,
// so that of overlapping ones each pixel shows the nearest. scene/warp_splats.cpp is the same on the processor.

#include "render/shaders/shared/tile_draw.h"

SHARED_BEGIN

/// Share of its disparity that a splat loses from centre to rim: more than neighbouring samples of a slanted surface
/// differ by, and less than surfaces that are to be told apart.
SHARED_CONSTANT float kSplatFalloff = 0.01f;
/// Every sample reaches the centre of a pixel.
SHARED_CONSTANT float kLeastSplat = 0.70710678f;

/// Radius in pixels of a sample, from what is in the draw: radius times w as the bits of span.x, bound as footprint.
SHARED_FUNCTION float splatRadiusOf(TileDraw draw, vec4 h) {
    PRECISE float inverse = 1.0f / h.z;
    PRECISE float radius = uintBitsToFloat(draw.span.x) * inverse;
    return clamp(radius, kLeastSplat, float(footprintOf(draw)));
}

/// The disparity of a splat at an offset from its centre, pixels; negative outside of it. perRadius2: 1 / radius^2.
SHARED_FUNCTION float splatDisparity(float disparity, vec2 offset, float perRadius2) {
    PRECISE float share = (offset.x * offset.x + offset.y * offset.y) * perRadius2;
    PRECISE float there = disparity * (1.0f - kSplatFalloff * share);
    return share > 1.0f ? -1.0f : there;
}

SHARED_END

#endif
