#ifndef RENDER_SHADERS_SHARED_TILE_DRAW_H
#define RENDER_SHADERS_SHARED_TILE_DRAW_H
// What the processor tells the warps about one visible tile of one eye (std430), and the warp of a sample.
// Nyland, McAllister, Popescu, McCue, Lastra: "Interactive exploration of acquired 3D data", 1999, equation
// 2, incrementally: the matrix C is multiplied out in double precision up to the tile's first sample, so that
// what is left is small.
//
// A warped sample is a vec4 h = (u w, v w, w, d): seen at pixel position (u, v) with eye disparity d / w if w
// > 0.

#include "render/shaders/shared/language.h"

SHARED_BEGIN

struct TileDraw {
    vec4 base;  ///< h of the tile's first sample at its minDisparity
    vec4 perX;  ///< what one sample to the right adds
    vec4 perY;  ///< one sample down
    vec4 perQ;  ///< one step of quantised disparity
    uvec4 span; ///< first vertex (facets: texel; splats: see splat.h) in the page; first item (vertex, quad or facet);
                ///< items; see packMark
    uvec4 source; ///< first sample in its image, x and y; level of detail | width + 1 << 8 | height << 20, in samples
                  ///< (rows of texels are as long); see packSource
    vec4 detail;  ///< see isOfDetail; x 0: all samples are drawn. w: number of the draw's run in its batch
};

struct WarpConstants {
    uint firstDraw; ///< of the workgroup with number 0; with kAmongPassed among the draws that have passed a look
    int width;      ///< of the eye's image, pixels
    int height;
    uint count; ///< of draws from firstDraw on, where parts that are listed are drawn (large_part.h)
};
SHARED_CONSTANT uint kAmongPassed = 0x80000000u;

/// Which tiles a pipeline draws: all, or plain ones, or those that are no more than small (Reach in
/// render/draw_list.h).
SHARED_CONSTANT uint kDrawsAll = 0u, kDrawsPlain = 1u, kDrawsSmall = 2u;

/// A draw that may still change the picture, when that was last looked at (occlusion.h).
struct PassedDraw {
    uint draw; ///< number in the list
    uint rows; ///< of its tile, that may: first | end << 8
};
SHARED_CONSTANT uint kAllRows = 0xff00u, kNoRows = 0u;

#ifdef __cplusplus
static_assert(sizeof(PassedDraw) == 8);
static_assert(sizeof(TileDraw) == 112 && alignof(TileDraw) == 4);
static_assert(sizeof(WarpConstants) == 16);
#endif

/// What a draw's samples have in common, in span.w: order level and class (both as in a key), the bits of a coordinate
/// in a vertex' place, and footprint.
SHARED_FUNCTION uint packMark(uint orderLevel, uint pixelClass, uint placeBits, uint footprint) {
    return (orderLevel << 18) | (pixelClass << 16) | (placeBits << 12) | footprint;
}
SHARED_FUNCTION uint levelAndClassOf(TileDraw draw) {
    return draw.span.w >> 16;
}
SHARED_FUNCTION uint placeBitsOf(TileDraw draw) {
    return (draw.span.w >> 12) & 15u;
}
SHARED_FUNCTION int footprintOf(TileDraw draw) {
    return int(draw.span.w & 0xfffu);
}

SHARED_FUNCTION int heightOf(TileDraw draw) {
    return int(draw.source.z >> 20);
}

/// Bits of a place in all tiles but scraps.
SHARED_CONSTANT uint kRowPlaceBits = 6u;

/// Which image a draw's samples are of, and how many of them are left out, in source.w.
SHARED_CONSTANT uint kImageBits = 24u, kMostImages = 1u << 24;
SHARED_FUNCTION uint packSource(uint image, float share) {
    return image | (uint(int((1.0f - share) * 255.0f + 0.5f)) << kImageBits);
}
SHARED_FUNCTION uint imageOf(TileDraw draw) {
    return draw.source.w & (kMostImages - 1u);
}
/// In [0, 1].
SHARED_FUNCTION float shareOf(TileDraw draw) {
    PRECISE float share = 1.0f - float(int(draw.source.w >> kImageBits)) / 255.0f;
    return share;
}

/// Nearest surface that is drawn, 10 micrometres before the eye, as eye disparity in 1/m.
SHARED_CONSTANT float kMaxEyeDisparity = 1e5f;

/// (x, y, quantised disparity) of a sample in its tile, alike for both eyes. place as in scene::TileVertex: x | y <<
/// bits | q << 2 bits. Through int because processors convert that faster.
SHARED_FUNCTION vec3 placeInTile(TileDraw draw, uint place) {
    uint bits = placeBitsOf(draw), mask = (1u << bits) - 1u;
    return vec3(float(int(place & mask)), float(int((place >> bits) & mask)), float(int(place >> (2u * bits))));
}
SHARED_FUNCTION vec4 warpPlace(TileDraw draw, vec3 at) {
    PRECISE vec4 h = draw.base + at.x * draw.perX + at.y * draw.perY + at.z * draw.perQ;
    return h;
}
SHARED_FUNCTION vec4 warpSample(TileDraw draw, uint place) {
    return warpPlace(draw, placeInTile(draw, place));
}

/// Where a sample stands in its tile.
SHARED_FUNCTION uvec2 columnAndRowOf(TileDraw draw, uint place) {
    uint bits = placeBitsOf(draw), mask = (1u << bits) - 1u;
    return uvec2(place & mask, (place >> bits) & mask);
}

/// True before the eye and not too near; what is not can neither be projected nor compared.
SHARED_FUNCTION bool isBeforeEye(vec4 h) {
    return h.z > 1e-30f && h.w <= kMaxEyeDisparity * h.z;
}

/// False if all samples that the tile could hold are before the eye.
SHARED_FUNCTION bool mayReachBehind(TileDraw draw) {
    uint bits = placeBitsOf(draw);
    float most = float(int((1u << bits) - 1u)), mostQ = float(int((1u << (32u - 2u * bits)) - 1u));
    // At least 0 before the eye, and affine: least in a corner of the tile's box.
    float first = kMaxEyeDisparity * draw.base.z - draw.base.w;
    float alongX = most * (kMaxEyeDisparity * draw.perX.z - draw.perX.w);
    float alongY = most * (kMaxEyeDisparity * draw.perY.z - draw.perY.w);
    float alongQ = mostQ * (kMaxEyeDisparity * draw.perQ.z - draw.perQ.w);
    float least = first + min(alongX, 0.0f) + min(alongY, 0.0f) + min(alongQ, 0.0f);
    float rounding = 1e-6f * (abs(first) + abs(alongX) + abs(alongY) + abs(alongQ));
    return !(least > rounding);
}

/// (u, v, eye disparity) of a sample before the eye. Quantised sky may come out an ulp below zero: infinitely
/// far.
SHARED_FUNCTION vec3 project(vec4 h) {
    PRECISE float inverse = 1.0f / h.z;
    PRECISE vec3 seen = vec3(h.x * inverse, h.y * inverse, max(h.w, 0.0f) * inverse);
    return seen;
}

/// First row or column of a square footprint of size pixels centred on a position.
SHARED_FUNCTION float firstOfFootprint(float position, int size) {
    PRECISE float first = floor(position - 0.5f * float(size - 1));
    return first;
}

/// The pixels whose centres are within reach of a position, first and end, along one side of an image of that size.
SHARED_FUNCTION ivec2 touchedBy(float position, float reach, float size) {
    PRECISE float first = ceil(position - reach - 0.5f);
    PRECISE float end = floor(position + reach + 0.5f);
    // Clamped as floats: far outside, the conversion to int is undefined.
    return ivec2(int(clamp(first, 0.0f, size)), int(clamp(end, 0.0f, size)));
}

SHARED_END

#endif
