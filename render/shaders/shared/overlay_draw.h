#ifndef RENDER_SHADERS_SHARED_OVERLAY_DRAW_H
#define RENDER_SHADERS_SHARED_OVERLAY_DRAW_H
// What the processor tells the overlay's shader (std430), and what a stroke does to a pixel.
//
// A stroke is a line on the screen with round ends: everything of an overlay is made of them, letters too. The screen
// is cut into bins of kBinSide x kBinSide pixels; each bin names the strokes that may touch it, farthest first, and one
// workgroup draws it: a pixel belongs to one invocation, so the order is the list's on any device.

#include "render/shaders/shared/language.h"

SHARED_BEGIN

SHARED_CONSTANT uint kBinSide = 16u; ///< pixels

/// How much farther than a surface an overlay may stand and still be drawn upon it, as a share: what was set on a
/// surface must not be eaten by the surface's noise.
SHARED_CONSTANT float kDepthSlack = 0.01f;

/// Over how much of the ellipse's radius the rim fades from clear to black.
SHARED_CONSTANT float kVignetteFade = 0.45f;

struct OverlayStroke {
    vec2 a; ///< ends, pixels
    vec2 b;
    vec2 disparities; ///< the eye's at a and b, 1/m; affine between them, as everything straight
    float halfWidth;  ///< pixels
    float whenHidden; ///< share of the opacity behind a surface
    uint colour;      ///< r | g << 8 | b << 16 | opacity << 24
    uint reserved;
};

struct OverlayBin {
    uint place; ///< column | row << 16
    uint first; ///< entry
    uint count; ///< of entries
    uint reserved;
};

struct OverlayConstants {
    int width; ///< pixels
    int height;
    uint firstBin;  ///< of the workgroup with number 0
    float clear;    ///< share of the ellipse's radius up to where the picture is not darkened
    vec2 centre;    ///< of the ellipse, pixels
    vec2 perRadius; ///< one over its half axes, 1/pixels
};

#ifdef __cplusplus
static_assert(sizeof(OverlayStroke) == 40 && alignof(OverlayStroke) == 4);
static_assert(sizeof(OverlayBin) == 16);
static_assert(sizeof(OverlayConstants) == 32);
#endif

/// How much of a pixel (0 to 1) a stroke covers; p: the pixel's centre. surfaceDisparity: of the picture there, 0 where
/// there is nothing or sky.
SHARED_FUNCTION float shareOfStroke(OverlayStroke stroke, vec2 p, float surfaceDisparity) {
    vec2 along = stroke.b - stroke.a, from = p - stroke.a;
    float length2 = along.x * along.x + along.y * along.y;
    float t = length2 > 0.0f ? clamp((from.x * along.x + from.y * along.y) / length2, 0.0f, 1.0f) : 0.0f;
    vec2 off = from - t * along;
    float distance = sqrt(off.x * off.x + off.y * off.y);
    float cover = clamp(stroke.halfWidth + 0.5f - distance, 0.0f, 1.0f);
    float disparity = stroke.disparities.x + t * (stroke.disparities.y - stroke.disparities.x);
    bool isBefore = disparity * (1.0f + kDepthSlack) >= surfaceDisparity;
    float opacity = float(stroke.colour >> 24) / 255.0f;
    return cover * opacity * (isBefore ? 1.0f : stroke.whenHidden);
}

/// What the rim leaves of a pixel's light.
SHARED_FUNCTION float lightAt(OverlayConstants constants, vec2 p) {
    vec2 r = (p - constants.centre) * constants.perRadius;
    float in01 = clamp((sqrt(r.x * r.x + r.y * r.y) - constants.clear) / kVignetteFade, 0.0f, 1.0f);
    return 1.0f - in01 * in01 * (3.0f - 2.0f * in01);
}

SHARED_FUNCTION vec3 colourOf(uint rgb) {
    return vec3(float(rgb & 255u), float((rgb >> 8) & 255u), float((rgb >> 16) & 255u));
}
/// r | g << 8 | b << 16 of channels from 0 to 255.
SHARED_FUNCTION uint packColour(vec3 colour) {
    vec3 rounded = clamp(colour + vec3(0.5f), vec3(0.0f), vec3(255.0f));
    return uint(rounded.x) | (uint(rounded.y) << 8) | (uint(rounded.z) << 16);
}

SHARED_END

#endif
