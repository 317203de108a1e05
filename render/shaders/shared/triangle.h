#ifndef RENDER_SHADERS_SHARED_TRIANGLE_H
#define RENDER_SHADERS_SHARED_TRIANGLE_H
// Triangles on the pixel grid, for the mesh warp (Nyland et al. 1999, section 5.2).
//
// Disparity is affine on the screen (a plane is affine in (u, v, d / w)), so it is interpolated without a
// division. Colour is interpolated affinely too: a triangle spans one sample, and perspective shows only
// where its depth changes over it.
//
// Watertight: a pixel belongs to every triangle that its centre is inside of or less than kFatEdge outside
// of. Edges shared by two tiles differ by rounding and quantisation, far less than that; what is drawn twice
// costs nothing, since the z-buffer takes the nearer whichever comes first. Seen from behind a triangle is
// drawn as well.

#include "render/shaders/shared/language.h"

SHARED_BEGIN

SHARED_CONSTANT float kFatEdge = 1.0f / 64.0f; ///< pixels

/// The pixels of a box, first to last; empty if last < first.
struct PixelBox {
    ivec2 first;
    ivec2 last;
};

/// Where pixel centres may lie inside of the box between two positions, on the screen.
SHARED_FUNCTION PixelBox pixelsOf(vec2 low, vec2 high, vec2 size) {
    // Clamped as floats: far outside, the conversion to int is undefined.
    vec2 first = clamp(ceil(low - vec2(0.5f + kFatEdge)), vec2(0.0f), size);
    vec2 last = clamp(floor(high - vec2(0.5f - kFatEdge)), vec2(-1.0f), size - vec2(1.0f));
    PixelBox box;
    box.first = ivec2(first);
    box.last = ivec2(last);
    return box;
}

/// A triangle (a, b, c) as its pixels need it. A point is a + ofB (b - a) + ofC (c - a); ofB and ofC are
/// affine on the screen, as x and y of the vec2s.
struct Triangle {
    vec2 atOrigin; ///< ofB, ofC at the centre of some pixel
    vec2 perX;     ///< what a pixel to the right adds
    vec2 perY;     ///< a pixel down
    vec3 slack;    ///< how far below 0 the shares of a, b, c may be: kFatEdge
};

/// What a triangle leaves at a pixel.
struct Covered {
    float disparity; ///< negative if the pixel is not covered
    float ofB, ofC;
};

/// Corners are projected samples (u, v, eye disparity).
SHARED_FUNCTION Triangle setUp(vec3 a, vec3 b, vec3 c, vec2 origin) {
    vec2 toB = vec2(b.x - a.x, b.y - a.y), toC = vec2(c.x - a.x, c.y - a.y);
    vec2 toOrigin = vec2(origin.x - a.x, origin.y - a.y);
    PRECISE float area = toB.x * toC.y - toB.y * toC.x; // twice, and signed
    // Seen edge-on there is nothing to cover: the neighbours have the pixels.
    bool hasArea = abs(area) > 1e-20f;
    PRECISE float inverse = hasArea ? 1.0f / area : 0.0f;
    PRECISE float ofB = (toOrigin.x * toC.y - toOrigin.y * toC.x) * inverse;
    PRECISE float ofC = (toB.x * toOrigin.y - toB.y * toOrigin.x) * inverse;
    Triangle t;
    t.atOrigin = vec2(hasArea ? ofB : -1.0f, ofC);
    t.perX = vec2(toC.y, -toB.y) * inverse;
    t.perY = vec2(-toC.x, toB.x) * inverse;
    // Twice the area that lies kFatEdge outside of an edge; a little more on diagonals.
    float fat = kFatEdge * abs(inverse);
    t.slack = vec3(abs(b.x - c.x) + abs(b.y - c.y), abs(toC.x) + abs(toC.y), abs(toB.x) + abs(toB.y)) * fat;
    return t;
}

/// The triangle that setUp made of a, b, c, at the pixel that stands offset from the origin.
SHARED_FUNCTION Covered cover(Triangle t, vec3 a, vec3 b, vec3 c, vec2 offset) {
    PRECISE vec2 of = t.atOrigin + offset.x * t.perX + offset.y * t.perY;
    PRECISE float disparity = a.z + of.x * (b.z - a.z) + of.y * (c.z - a.z);
    // Thin triangles must not shoot forward where a fat edge extends them.
    float nearest = max(max(a.z, b.z), c.z);
    float farthest = min(min(a.z, b.z), c.z);
    bool isInside = of.x >= -t.slack.y && of.y >= -t.slack.z && 1.0f - of.x - of.y >= -t.slack.x;
    Covered covered;
    covered.disparity = isInside ? clamp(disparity, farthest, nearest) : -1.0f;
    covered.ofB = of.x;
    covered.ofC = of.y;
    return covered;
}

/// Colours r | g << 8 | b << 16 mixed with weights of 1/256, so that two channels fit into one product:
/// within a step and a half of the exact mixture, and the same on every device.
SHARED_FUNCTION uint mixColours(uint a, uint b, uint c, float ofB, float ofC) {
    uint weightB = uint(int(clamp(ofB, 0.0f, 1.0f) * 256.0f + 0.5f));
    uint weightC = min(uint(int(clamp(ofC, 0.0f, 1.0f) * 256.0f + 0.5f)), 256u - weightB);
    uint weightA = 256u - weightB - weightC;
    uint redBlue = (a & 0xff00ffu) * weightA + (b & 0xff00ffu) * weightB + (c & 0xff00ffu) * weightC + 0x800080u;
    uint green = (a & 0xff00u) * weightA + (b & 0xff00u) * weightB + (c & 0xff00u) * weightC + 0x8000u;
    return ((redBlue >> 8) & 0xff00ffu) | ((green >> 8) & 0xff00u);
}

SHARED_END

#endif
