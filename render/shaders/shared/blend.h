#ifndef RENDER_SHADERS_SHARED_BLEND_H
#define RENDER_SHADERS_SHARED_BLEND_H
// The second pass of the blended warp: samples that stand at the front surface are added up, as whole numbers, so that
// the order does not matter. scene/blend.h says what is added and why.
//
// A pixel's sums are four numbers of 32 bits, two in each 64-bit word: red | green << 32, blue | weight << 32.

#include "render/shaders/shared/tile_draw.h"
#include "render/shaders/shared/z_key.h"

SHARED_BEGIN

/// A tile of the second pass: order level 0, so that its disparities are those of the eye.
struct BlendDraw {
    TileDraw tile;
    vec4 spot;  ///< xx, xy, yy as in scene::BlendSpot; and the weight of its centre as a whole number
    vec4 reach; ///< half the sides of the spot's box, pixels; tolerance of disparity; nothing
};

struct BlendResolveConstants {
    int width; ///< pixels; a workgroup resolves one row
};

#ifdef __cplusplus
static_assert(sizeof(BlendDraw) == 144 && sizeof(BlendResolveConstants) == 4);
#endif

/// Whether a sample of that disparity and class is part of the front surface: key is of the first pass.
SHARED_FUNCTION bool isAtFront(float disparity, uint pixelClass, uvec2 key, float tolerance) {
    float front = eyeDisparityOf(key);
    PRECISE float difference = disparity - front;
    PRECISE float most = tolerance * front;
    return (key.x & 3u) == pixelClass && abs(difference) <= most;
}

/// What a sample counts at a pixel whose centre stands offset pixels from it; 0: nothing.
SHARED_FUNCTION uint countOf(vec4 spot, vec2 offset) {
    PRECISE float q = spot.x * offset.x * offset.x + spot.y * offset.x * offset.y + spot.z * offset.y * offset.y;
    PRECISE float rest = max(1.0f - q, 0.0f);
    PRECISE float count = spot.w * rest * rest + 0.5f;
    return uint(int(count));
}

/// What is added to the two words of a pixel, each as (low, high). colour: r | g << 8 | b << 16.
SHARED_FUNCTION uvec2 redGreenOf(uint colour, uint count) {
    return uvec2((colour & 255u) * count, ((colour >> 8) & 255u) * count);
}
SHARED_FUNCTION uvec2 blueWeightOf(uint colour, uint count) {
    return uvec2(((colour >> 16) & 255u) * count, count);
}

/// r | g << 8 | b << 16: the mean. Something must have been added.
SHARED_FUNCTION uint meanColourOf(uvec2 redGreen, uvec2 blueWeight) {
    uint weight = blueWeight.y, halfWeight = weight / 2u;
    uint red = (redGreen.x + halfWeight) / weight, green = (redGreen.y + halfWeight) / weight;
    return red | (green << 8) | (((blueWeight.x + halfWeight) / weight) << 16);
}

SHARED_END

#endif
