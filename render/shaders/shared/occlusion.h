#ifndef RENDER_SHADERS_SHARED_OCCLUSION_H
#define RENDER_SHADERS_SHARED_OCCLUSION_H
// Which tiles cannot change the picture any more: those that lie, with all their samples, behind what stands at every
// pixel they may touch. Exact, so that a picture is the same to the byte with and without it; unless gaps are closed
// for the test, as the hole filler closes them afterwards: then what would be seen only through such gaps is left out.
//
// The z-buffer is divided into blocks, each with the least order disparity of its pixels (z_key.h): nothing whose
// order disparity is below that is seen there.

#include "render/shaders/shared/tile_draw.h"

SHARED_BEGIN

SHARED_CONSTANT int kOccluderSide = 8; ///< pixels

/// Blocks looked at for one tile at most: what covers more of the picture is near, and drawn.
SHARED_CONSTANT int kMostOccluders = 256;

struct OccluderConstants {
    int width; ///< of the eye's image, pixels
    int height;
    int closesGaps; ///< 1: a pixel counts as what stands to both sides of it, so that gaps of one pixel within a
                    ///< surface hide what is behind them; 0: exact
    int isAgain;    ///< 1: only blocks with nothing in some pixel yet are looked at. The others hide no less than they
                    ///< did, and what is drawn later is farther, so that they hardly hide more
};

struct OcclusionConstants {
    uint firstDraw;
    uint count;
    int width;
    int height;
};

/// How many draws of a run have passed, as an indirect dispatch wants it, and where they go.
struct PassedRun {
    uint x;
    uint y;
    uint z;
    uint firstAndKind; ///< first draw | kSplatRun
};
SHARED_CONSTANT uint kSplatRun = 0x80000000u; ///< span.x of its draws is a radius

/// What a pixel counts as where gaps are closed: what stands there, or of two opposite neighbours the farther, of the
/// four pairs the nearest. The hole filler may put that between them: within a surface its own, and in a gap beside a
/// silhouette the surface behind, never the one before.
SHARED_FUNCTION uint closedDisparity(uint here, uvec2 across, uvec2 upright, uvec2 falling, uvec2 rising) {
    return max(here, max(max(min(across.x, across.y), min(upright.x, upright.y)),
                         max(min(falling.x, falling.y), min(rising.x, rising.y))));
}

SHARED_FUNCTION int occludersAlong(int pixels) {
    return (pixels + kOccluderSide - 1) / kOccluderSide;
}

/// What a tile may touch: blocks from first to last, none if last is before first; and the greatest order disparity of
/// its samples there. Negative if that cannot be told, since the tile reaches behind the eye.
struct TileReach {
    ivec2 first;
    ivec2 last;
    float nearest;
};

/// The tile's samples lie in a box in (x, y, q).
struct TileBox {
    vec4 base;
    vec4 alongX;
    vec4 alongY;
    vec4 alongQ;
};

SHARED_FUNCTION vec4 cornerOf(TileBox box, int corner) {
    return box.base + ((corner & 1) != 0 ? 1.0f : 0.0f) * box.alongX + ((corner & 2) != 0 ? 1.0f : 0.0f) * box.alongY +
           ((corner & 4) != 0 ? 1.0f : 0.0f) * box.alongQ;
}

/// What is before the eye of points that were seen: where, and how near at most.
struct Sighting {
    vec2 least;
    vec2 most;
    float nearest;
    bool isAllBefore;
};

SHARED_FUNCTION Sighting noSighting() {
    Sighting sighting;
    sighting.least = vec2(3.0e38f);
    sighting.most = vec2(-3.0e38f);
    sighting.nearest = 0.0f;
    sighting.isAllBefore = true;
    return sighting;
}

SHARED_FUNCTION Sighting withPoint(Sighting sighting, vec4 h) {
    float inverse = 1.0f / max(h.z, 1e-6f);
    sighting.least = min(sighting.least, vec2(h.x * inverse, h.y * inverse));
    sighting.most = max(sighting.most, vec2(h.x * inverse, h.y * inverse));
    sighting.nearest = max(sighting.nearest, h.w * inverse);
    sighting.isAllBefore = sighting.isAllBefore && h.z > 1e-6f;
    return sighting;
}

/// Positive within one edge of the image moved out by `beyond` pixels; affine in h.
SHARED_FUNCTION float withinEdge(int edge, vec4 h, float beyond, vec2 size) {
    if (edge == 0) return h.x + beyond * h.z;
    if (edge == 1) return (size.x + beyond) * h.z - h.x;
    if (edge == 2) return h.y + beyond * h.z;
    return (size.y + beyond) * h.z - h.y;
}

/// The part of a box that is within one edge: its corners there, and where the edge cuts the box's own.
SHARED_FUNCTION Sighting sightWithin(TileBox box, int edge, float beyond, vec2 size) {
    Sighting sighting = noSighting();
    for (int corner = 0; corner < 8; ++corner) {
        vec4 from = cornerOf(box, corner);
        float here = withinEdge(edge, from, beyond, size);
        if (here >= 0.0f) sighting = withPoint(sighting, from);
        for (int axis = 1; axis < 8; axis *= 2) {
            if ((corner & axis) != 0) continue;
            vec4 to = cornerOf(box, corner | axis);
            float there = withinEdge(edge, to, beyond, size);
            if ((here >= 0.0f) != (there >= 0.0f))
                sighting = withPoint(sighting, from + (here / (here - there)) * (to - from));
        }
    }
    return sighting;
}

/// isSplats: span.x of the draw is a radius.
SHARED_FUNCTION TileReach reachOf(TileDraw draw, bool isSplats, int width, int height) {
    uint bits = placeBitsOf(draw);
    TileBox box;
    box.base = draw.base;
    box.alongX = float(int((draw.source.z >> 8) & 0xfffu) - 1) * draw.perX;
    box.alongY = float(int(draw.source.z >> 20)) * draw.perY;
    box.alongQ = float(int((1u << (32u - 2u * bits)) - 1u)) * draw.perQ;
    // What is drawn of a sample reaches beyond its place; and a pixel more for what rounding may do.
    float beyond = (isSplats ? uintBitsToFloat(draw.span.x) : 0.5f * float(footprintOf(draw))) + 1.5f;
    vec2 size = vec2(float(width), float(height));

    Sighting sighting = noSighting();
    for (int corner = 0; corner < 8; ++corner)
        sighting = withPoint(sighting, cornerOf(box, corner));
    // A wall that passes beside the eye, from before it to behind, is seen only from where it comes into the image on.
    // Each edge by itself bounds that.
    bool isCut = !sighting.isAllBefore;
    if (isCut) {
        sighting.least = vec2(-3.0e38f);
        sighting.most = vec2(3.0e38f);
        sighting.nearest = -1.0f;
    }
    for (int edge = isCut ? 0 : 4; edge < 4; ++edge) {
        Sighting part = sightWithin(box, edge, beyond, size);
        if (!part.isAllBefore) continue;
        sighting.least = max(sighting.least, part.least);
        sighting.most = min(sighting.most, part.most);
        sighting.nearest = sighting.nearest < 0.0f ? part.nearest : min(sighting.nearest, part.nearest);
    }

    vec2 first = clamp((sighting.least - beyond) / float(kOccluderSide), vec2(0.0f), size / float(kOccluderSide));
    vec2 last =
        clamp((sighting.most + beyond) / float(kOccluderSide), vec2(-1.0f), (size - 1.0f) / float(kOccluderSide));
    TileReach reach;
    reach.first = ivec2(int(floor(first.x)), int(floor(first.y)));
    reach.last = ivec2(int(floor(last.x)), int(floor(last.y)));
    reach.nearest = sighting.nearest * 1.01f; // facets may leave their samples by less
    return reach;
}

SHARED_END

#endif
