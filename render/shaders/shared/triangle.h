#ifndef RENDER_SHADERS_SHARED_TRIANGLE_H
#define RENDER_SHADERS_SHARED_TRIANGLE_H
// Triangles on the pixel grid, for the mesh warp (Nyland et al. 1999, section 5.2).
//
// Disparity is affine on the screen (a plane is affine in (u, v, d / w)), so it is interpolated without a division. Colour
// is interpolated affinely too: a triangle spans one sample, and perspective shows only where its depth changes over it.
//
// Watertight: a pixel belongs to every triangle that its centre is inside of or less than kFatEdge outside of. Edges
// shared by two tiles differ by rounding and quantisation, far less than that; what is drawn twice costs nothing, since
// the z-buffer takes the nearer whichever comes first. Seen from behind a triangle is drawn as well.

#include "render/shaders/shared/language.h"
#include "render/shaders/shared/z_key.h"

SHARED_BEGIN

SHARED_CONSTANT float kFatEdge = 1.0f / 64.0f; ///< pixels

/// A projected sample: (u, v, eye disparity), and its colour r | g << 8 | b << 16.
struct Corner {
    vec3 seen;
    uint colour;
};

/// The pixels of a box, first to last; empty if last < first.
struct PixelBox {
    ivec2 first;
    ivec2 last;
};

/// Twice the signed area of (a, b, p). Exactly negated when a and b change places.
SHARED_FUNCTION float edge(vec3 a, vec3 b, vec2 p)
{
    PRECISE float twiceArea = (a.x - p.x) * (b.y - p.y) - (a.y - p.y) * (b.x - p.x);
    return twiceArea;
}

/// How much twice the area may miss for a point kFatEdge outside of the edge; a little more on diagonals.
SHARED_FUNCTION float fatEdge(vec3 a, vec3 b)
{
    return kFatEdge * (abs(a.x - b.x) + abs(a.y - b.y));
}

/// Where pixel centres may lie inside of the box between two positions, on the screen.
SHARED_FUNCTION PixelBox pixelsOf(vec2 low, vec2 high, vec2 size)
{
    // Clamped as floats: far outside, the conversion to int is undefined.
    vec2 first = clamp(ceil(low - vec2(0.5f + kFatEdge)), vec2(0.0f), size);
    vec2 last = clamp(floor(high - vec2(0.5f - kFatEdge)), vec2(-1.0f), size - vec2(1.0f));
    PixelBox box;
    box.first = ivec2(first);
    box.last = ivec2(last);
    return box;
}

SHARED_FUNCTION float channel(uint colour, uint shift)
{
    return float(int((colour >> shift) & 255u));
}

SHARED_FUNCTION uint interpolate(uint a, uint b, uint c, float ofB, float ofC, uint shift)
{
    float atA = channel(a, shift);
    PRECISE float value = atA + ofB * (channel(b, shift) - atA) + ofC * (channel(c, shift) - atA);
    return uint(int(clamp(value + 0.5f, 0.0f, 255.0f))) << shift;
}

/// The z-buffer key of a triangle at a pixel centre; (0, 0) if the pixel is not covered.
SHARED_FUNCTION uvec2 keyOfTriangle(Corner a, Corner b, Corner c, vec2 centre)
{
    float area = edge(a.seen, b.seen, vec2(c.seen.x, c.seen.y));
    float toward = area < 0.0f ? -1.0f : 1.0f;
    float inA = edge(b.seen, c.seen, centre);
    float inB = edge(c.seen, a.seen, centre);
    float inC = edge(a.seen, b.seen, centre);
    if (area == 0.0f || inA * toward < -fatEdge(b.seen, c.seen) || inB * toward < -fatEdge(c.seen, a.seen) ||
        inC * toward < -fatEdge(a.seen, b.seen))
        return uvec2(0u);

    PRECISE float ofB = inB / area;
    PRECISE float ofC = inC / area;
    PRECISE float disparity = a.seen.z + ofB * (b.seen.z - a.seen.z) + ofC * (c.seen.z - a.seen.z);
    // Thin triangles must not shoot forward where a fat edge extends them.
    float nearest = max(max(a.seen.z, b.seen.z), c.seen.z);
    float farthest = min(min(a.seen.z, b.seen.z), c.seen.z);
    uint colour = interpolate(a.colour, b.colour, c.colour, ofB, ofC, 0u) |
                  interpolate(a.colour, b.colour, c.colour, ofB, ofC, 8u) |
                  interpolate(a.colour, b.colour, c.colour, ofB, ofC, 16u);
    return packKey(clamp(disparity, farthest, nearest), colour, kClassSeen);
}

SHARED_END

#endif
