#ifndef RENDER_SHADERS_SHARED_Z_KEY_H
#define RENDER_SHADERS_SHARED_Z_KEY_H
// A pixel of an eye's z-buffer: 64 bits that compare as wanted, so that one atomic maximum is depth test and
// write at once and the order of drawing does not matter.
//
//     63 ......... 38 | 37 . 33 | 32 | 31 ..... 8 | 7 .... 2 | 1 . 0
//     order disparity |  place  | rim|  b   g   r |   level  | class
//
// Order disparity is never negative, so that its bits order as it does; 0 is the cleared pixel: nothing there.
// It is the eye's over the scale of the order level (scene/preference.h says why), and at the rim of a
// point less by kRimShare. It is rounded to 17 bits after the first, by 4 millionths of it at most; where in its
// pixel a sample stands has the others (sample_place.h). scene/tile_warp.h is the same on the processor.
//
// As uvec2 (low, high): x holds colour and class, y the disparity.

#include "render/shaders/shared/language.h"

SHARED_BEGIN

SHARED_CONSTANT uint kClassBackground = 0u;
SHARED_CONSTANT uint kClassSeen = 1u;
SHARED_CONSTANT uint kClassFilled = 2u;
SHARED_CONSTANT uint kClassUnseen = 3u;

/// What a point covers besides the pixel it stands in keeps this share of its disparity: where squares of one surface
/// lie over one another, a pixel then shows the sample that stands in it and not one beside it that is nearer to the
/// eye. As kSplatFalloff: more than neighbouring samples of a slanted surface differ by, less than surfaces that are to
/// be told apart; and less than an order level.
SHARED_CONSTANT float kRimShare = 0.99f, kPerRimShare = 1.0f / 0.99f;

/// Bits of y that are not the order disparity's, and those of the place among them.
SHARED_CONSTANT uint kNotDisparity = 63u, kPlaceMask = 62u;

/// The order disparity in y, rounded.
SHARED_FUNCTION uint orderBitsOf(float orderDisparity) {
    return (floatBitsToUint(orderDisparity) + (kNotDisparity + 1u) / 2u) & ~kNotDisparity;
}

/// Of what stands in the middle of its pixel. colour: r | g << 8 | b << 16; what stands above is dropped.
/// levelAndClass: order level << 2 | class.
SHARED_FUNCTION uvec2 packKey(float orderDisparity, uint colour, uint levelAndClass) {
    return uvec2((colour << 8) | levelAndClass, orderBitsOf(orderDisparity));
}

/// Of a pixel at the rim of a point. What is infinitely far has no rim.
SHARED_FUNCTION uvec2 packRim(float orderDisparity, uint colour, uint levelAndClass) {
    PRECISE float pushed = orderDisparity * kRimShare;
    uvec2 key = packKey(pushed, colour, levelAndClass);
    return uvec2(key.x, key.y != 0u ? key.y | 1u : 0u);
}

/// Such a key where the sample stands elsewhere (placeCode). What is infinitely far stands in the middle.
SHARED_FUNCTION uvec2 withPlace(uvec2 key, uint place) {
    return uvec2(key.x, key.y != 0u ? key.y | (place << 1) : 0u);
}

/// r | g << 8 | b << 16 | class << 24: what resolve writes. What stands above the class until a picture is enlarged is
/// the sample's place (placeKept).
SHARED_FUNCTION uint colourAndClassOf(uvec2 key) {
    return (key.x >> 8) | ((key.x & 3u) << 24);
}
SHARED_CONSTANT uint kPlaceShift = 26u; ///< above the class
SHARED_FUNCTION uint classOfPixel(uint colourAndClass) {
    return (colourAndClass >> 24) & 3u;
}

/// The eye's disparity, 1/m: the order's with its level taken back.
SHARED_FUNCTION float eyeDisparityOf(uvec2 key) {
    PRECISE float scale = 1.0f + float(int((key.x >> 2) & 63u)) / 63.0f;
    PRECISE float disparity = uintBitsToFloat(key.y & ~kNotDisparity) * scale;
    PRECISE float ofRim = disparity * kPerRimShare;
    return (key.y & 1u) != 0u ? ofRim : disparity;
}

/// Metres along z; 0 where nothing is, infinity for what is infinitely far (sky).
SHARED_FUNCTION float depthOf(uvec2 key) {
    if ((key.x & 3u) == kClassBackground) return 0.0f;
    if (key.y == 0u) return uintBitsToFloat(0x7f800000u);
    return 1.0f / eyeDisparityOf(key);
}

SHARED_END

#endif
