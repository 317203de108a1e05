#ifndef RENDER_SHADERS_SHARED_FACET_H
#define RENDER_SHADERS_SHARED_FACET_H
// Facets on the pixel grid, for the adaptive mesh (scene/facets.h).
//
// Over a facet disparity is affine in the source's (x, y), so the warp is a homography. It is turned round: for each
// pixel, where in the facet it looks. What lies inside is decided there, in samples, where neighbours share exact
// edges; nothing is clipped, since behind the eye the turned homography has a negative sign; and texture is read with
// perspective. Eye disparity stays affine on the screen.

#include "render/shaders/shared/tile_draw.h"
#include "render/shaders/shared/triangle.h"

SHARED_BEGIN

/// How far beyond its edges a facet is drawn, in samples: what neighbours may part by.
SHARED_CONSTANT float kFacetEdge = 1.0f / 16.0f;

struct Facet {
    vec4 corner; ///< h of its top left sample (shared/tile_draw.h)
    vec4 perX;   ///< what one sample to the right adds, disparity along
    vec4 perY;
    float side; ///< samples
    bool isUpper, isLower;
};

/// mark, q, perX, perY as in scene::TileFacet.
SHARED_FUNCTION Facet facetOf(TileDraw draw, uint mark, float q, float perX, float perY) {
    Facet facet;
    float x = float(int(mark & 63u)), y = float(int((mark >> 6) & 63u));
    PRECISE vec4 corner = draw.base + x * draw.perX + y * draw.perY + q * draw.perQ;
    PRECISE vec4 right = draw.perX + perX * draw.perQ;
    PRECISE vec4 down = draw.perY + perY * draw.perQ;
    facet.corner = corner;
    facet.perX = right;
    facet.perY = down;
    facet.side = float(int(1u << ((mark >> 12) & 7u)));
    facet.isUpper = (mark & (1u << 16)) != 0u;
    facet.isLower = (mark & (1u << 17)) != 0u;
    return facet;
}

/// Where an edge passes the nearest that is drawn, on the screen. before: can be projected; behind: cannot.
SHARED_FUNCTION vec2 cutAtNearest(vec4 before, vec4 behind) {
    // Affine along the edge: at least 0 where the edge is drawn.
    float here = kMaxEyeDisparity * before.z - before.w, there = kMaxEyeDisparity * behind.z - behind.w;
    vec4 h = before + clamp(here / max(here - there, 1e-30f), 0.0f, 1.0f) * (behind - before);
    float inverse = 1.0f / max(h.z, 1e-30f);
    return vec2(h.x * inverse, h.y * inverse);
}

/// Whether all of four corners (a triangle has two alike) are beyond one edge of the image, and so is all between them.
/// Affine in h, so that it does not matter which can be projected.
SHARED_FUNCTION bool isBeside(vec4 a, vec4 b, vec4 c, vec4 d, vec2 size) {
    const float beyond = 2.0f; // pixels, since facets are drawn a little beyond their edges
    vec2 most = size + beyond;
    float left = max(max(a.x + beyond * a.z, b.x + beyond * b.z), max(c.x + beyond * c.z, d.x + beyond * d.z));
    float right = max(max(most.x * a.z - a.x, most.x * b.z - b.x), max(most.x * c.z - c.x, most.x * d.z - d.x));
    float top = max(max(a.y + beyond * a.z, b.y + beyond * b.z), max(c.y + beyond * c.z, d.y + beyond * d.z));
    float bottom = max(max(most.y * a.z - a.y, most.y * b.z - b.y), max(most.y * c.z - c.y, most.y * d.z - d.y));
    return min(min(left, right), min(top, bottom)) < 0.0f;
}

/// The pixels that may see a polygon of four corners in turn (a triangle has two alike), some of which cannot be
/// projected.
SHARED_FUNCTION PixelBox boxOfCut(vec4 a, vec4 b, vec4 c, vec4 d, vec2 size) {
    vec2 low = vec2(1e30f), high = vec2(-1e30f);
    for (int i = 0; i < 4; ++i) {
        vec4 from = i == 0 ? a : i == 1 ? b : i == 2 ? c : d, to = i == 0 ? b : i == 1 ? c : i == 2 ? d : a;
        bool isBefore = isBeforeEye(from);
        if (isBefore) {
            vec3 seen = project(from);
            low = min(low, vec2(seen.x, seen.y));
            high = max(high, vec2(seen.x, seen.y));
        }
        if (isBefore == isBeforeEye(to)) continue;
        vec2 cut = isBefore ? cutAtNearest(from, to) : cutAtNearest(to, from);
        low = min(low, cut);
        high = max(high, cut);
    }
    return pixelsOf(low, high, size);
}

/// The pixels that may see it: the box of its corners, or the whole image where one of them cannot be projected.
SHARED_FUNCTION PixelBox boxOf(Facet facet, vec2 size) {
    vec4 right = facet.corner + facet.side * facet.perX, down = facet.corner + facet.side * facet.perY;
    vec4 across = right + facet.side * facet.perY;
    bool a = isBeforeEye(facet.corner), b = isBeforeEye(right), c = isBeforeEye(down), d = isBeforeEye(across);
    PixelBox box;
    box.first = ivec2(0);
    box.last = ivec2(-1);
    if (!a && !b && !c && !d) return box;
    if (!(a && b && c && d)) {
        if (!isBeside(facet.corner, right, across, down, size)) box.last = ivec2(size) - 1;
        return box;
    }
    vec3 p = project(facet.corner), q = project(right), r = project(down), s = project(across);
    vec2 low = min(min(vec2(p.x, p.y), vec2(q.x, q.y)), min(vec2(r.x, r.y), vec2(s.x, s.y)));
    vec2 high = max(max(vec2(p.x, p.y), vec2(q.x, q.y)), max(vec2(r.x, r.y), vec2(s.x, s.y)));
    return pixelsOf(low, high, size);
}

/// A triangle (a, b, c), some of whose corners cannot be projected: half of a facet, one sample wide.
SHARED_FUNCTION Facet facetOfTriangle(vec4 a, vec4 b, vec4 c) {
    Facet facet;
    facet.corner = a;
    facet.perX = b - a;
    facet.perY = c - a;
    facet.side = 1.0f;
    facet.isUpper = true;
    facet.isLower = false;
    return facet;
}

/// Turned round, with (u, v, 1) from some pixel's centre: x = dot(x, (u, v, 1)) / dot(perW, (u, v, 1)), y alike;
/// perW is 1 / w, and disparity the eye's. All zero where the facet is seen edge-on.
struct FacetView {
    vec3 x, y, perW, disparity;
};

SHARED_FUNCTION FacetView turnRound(Facet facet, vec2 origin) {
    PRECISE vec3 h =
        vec3(facet.corner.x - origin.x * facet.corner.z, facet.corner.y - origin.y * facet.corner.z, facet.corner.z);
    PRECISE vec3 a = vec3(facet.perX.x - origin.x * facet.perX.z, facet.perX.y - origin.y * facet.perX.z, facet.perX.z);
    PRECISE vec3 b = vec3(facet.perY.x - origin.x * facet.perY.z, facet.perY.y - origin.y * facet.perY.z, facet.perY.z);
    PRECISE vec3 rx = vec3(b.y * h.z - b.z * h.y, b.z * h.x - b.x * h.z, b.x * h.y - b.y * h.x);
    PRECISE vec3 ry = vec3(h.y * a.z - h.z * a.y, h.z * a.x - h.x * a.z, h.x * a.y - h.y * a.x);
    PRECISE vec3 rw = vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
    PRECISE float determinant = a.x * rx.x + a.y * rx.y + a.z * rx.z;
    bool hasArea = abs(determinant) > 1e-30f;
    PRECISE float inverse = hasArea ? 1.0f / determinant : 0.0f;
    FacetView view;
    view.x = rx * inverse;
    view.y = ry * inverse;
    view.perW = rw * inverse;
    PRECISE vec3 disparity = facet.corner.w * view.perW + facet.perX.w * view.x + facet.perY.w * view.y;
    view.disparity = disparity;
    return view;
}

/// What a pixel sees of a facet.
struct FacetSight {
    float x, y;      ///< samples from its top left one
    float w;         ///< as of a warped sample
    float disparity; ///< negative if it is not seen
};

SHARED_FUNCTION FacetSight look(Facet facet, FacetView view, vec2 offset) {
    PRECISE float perW = view.perW.x * offset.x + view.perW.y * offset.y + view.perW.z;
    PRECISE float x = view.x.x * offset.x + view.x.y * offset.y + view.x.z;
    PRECISE float y = view.y.x * offset.x + view.y.y * offset.y + view.y.z;
    PRECISE float disparity = view.disparity.x * offset.x + view.disparity.y * offset.y + view.disparity.z;
    FacetSight sight;
    PRECISE float w = perW > 0.0f ? 1.0f / perW : 0.0f;
    sight.w = w;
    PRECISE vec2 place = vec2(x * w, y * w);
    sight.x = place.x;
    sight.y = place.y;
    bool isInside = w > 0.0f && sight.x >= -kFacetEdge && sight.y >= -kFacetEdge &&
                    sight.x <= facet.side + kFacetEdge && sight.y <= facet.side + kFacetEdge &&
                    disparity <= kMaxEyeDisparity;
    if (!facet.isLower) isInside = isInside && sight.x + sight.y <= facet.side + kFacetEdge;
    if (!facet.isUpper) isInside = isInside && sight.x + sight.y >= facet.side - kFacetEdge;
    sight.disparity = isInside ? max(disparity, 0.0f) : -1.0f;
    return sight;
}

/// Two colours mixed, a share of 256 of the second.
SHARED_FUNCTION uint mixTwo(uint a, uint b, uint ofB) {
    uint ofA = 256u - ofB;
    uint redBlue = (a & 0xff00ffu) * ofA + (b & 0xff00ffu) * ofB + 0x800080u;
    uint green = (a & 0xff00u) * ofA + (b & 0xff00u) * ofB + 0x8000u;
    return ((redBlue >> 8) & 0xff00ffu) | ((green >> 8) & 0xff00u);
}

SHARED_FUNCTION uint shareOf256(float share) {
    return uint(int(clamp(share, 0.0f, 1.0f) * 256.0f + 0.5f));
}

SHARED_END

#endif
