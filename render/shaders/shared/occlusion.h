#ifndef RENDER_SHADERS_SHARED_OCCLUSION_H
#define RENDER_SHADERS_SHARED_OCCLUSION_H
// Which tiles cannot change the picture any more: those that lie, with all their samples, behind what stands at every
// pixel they may touch. Exact, so that a picture is the same to the byte with and without it; unless gaps are closed
// for the test, as the hole filler closes them afterwards: then what would be seen only through such gaps is left out.
//
// The z-buffer is divided into blocks, each with the least order disparity of its pixels (z_key.h), and which of them
// hold nothing: nothing whose order disparity is below that is seen there but in those. And what stands in rows of a
// tile none of which touch a pixel where the tile may be seen is left out, too. Where gaps are closed, blocks are open
// as a whole and tiles are drawn whole.

#include "render/shaders/shared/tile_draw.h"
#include "render/shaders/shared/z_key.h"

SHARED_BEGIN

SHARED_CONSTANT int kOccluderSide = 8; ///< pixels

/// Blocks looked at for one tile at most: what covers more of the picture is near, and drawn.
SHARED_CONSTANT int kMostOccluders = 256;

/// What hides in a block: bit x of byte y, or y - 4, is pixel (x, y).
struct Occluder {
    uint least;     ///< order disparity of the pixels that hold anything; the most there is if none does
    uint openAbove; ///< pixels that hold nothing, rows 0 to 3
    uint openBelow; ///< rows 4 to 7
    uint unused;
};

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
    uint firstAndKind; ///< first draw | kSplatRun, kWholeRun
};
SHARED_CONSTANT uint kSplatRun = 0x80000000u; ///< span.x of its draws is a radius
SHARED_CONSTANT uint kWholeRun = 0x40000000u; ///< what passes is drawn with all its rows
SHARED_CONSTANT uint kFirstOfRun = 0x3fffffffu;

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

/// What a tile may touch: pixels from first to last, none if last is before first; and the greatest order disparity of
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

/// Where the samples of rows of a tile may be, from row first to row last, that one included.
SHARED_FUNCTION TileBox boxOfRows(TileDraw draw, float first, float last) {
    uint bits = placeBitsOf(draw);
    TileBox box;
    box.base = draw.base + first * draw.perY;
    box.alongX = float(int((draw.source.z >> 8) & 0xfffu) - 1) * draw.perX;
    box.alongY = (last - first) * draw.perY;
    box.alongQ = float(int((1u << (32u - 2u * bits)) - 1u)) * draw.perQ;
    return box;
}

/// How far what is drawn of a sample reaches beyond its place, pixels; and a pixel more for what rounding may do.
/// isSplats: span.x of the draw is a radius.
SHARED_FUNCTION float beyondOf(TileDraw draw, bool isSplats) {
    return (isSplats ? uintBitsToFloat(draw.span.x) : 0.5f * float(footprintOf(draw))) + 1.5f;
}

SHARED_FUNCTION Sighting sightOf(TileBox box) {
    Sighting sighting = noSighting();
    for (int corner = 0; corner < 8; ++corner)
        sighting = withPoint(sighting, cornerOf(box, corner));
    return sighting;
}

SHARED_FUNCTION TileReach reachOf(TileDraw draw, bool isSplats, int width, int height) {
    TileBox box = boxOfRows(draw, 0.0f, float(heightOf(draw)));
    float beyond = beyondOf(draw, isSplats);
    vec2 size = vec2(float(width), float(height));

    Sighting sighting = sightOf(box);
    vec2 first = clamp(sighting.least - beyond, vec2(0.0f), size);
    vec2 last = clamp(sighting.most + beyond, vec2(-1.0f), size - 1.0f);
    TileReach reach;
    reach.first = ivec2(int(floor(first.x)), int(floor(first.y)));
    reach.last = ivec2(int(floor(last.x)), int(floor(last.y)));
    // Facets may leave their samples by less. Few tiles reach behind the eye, and those are near.
    reach.nearest = sighting.isAllBefore ? sighting.nearest * 1.01f : -1.0f;
    return reach;
}

/// Where a tile may be seen: pixels from first to last, none if last is before first.
struct Opening {
    ivec2 first;
    ivec2 last;
};

SHARED_FUNCTION Opening noOpening() {
    Opening none;
    none.first = ivec2(0x7fffffff);
    none.last = ivec2(-1);
    return none;
}

/// Bits of those of four rows that come before one.
SHARED_FUNCTION uint bitsBefore(int row) {
    return row <= 0 ? 0u : row >= 4 ? 0xffffffffu : (1u << uint(8 * row)) - 1u;
}

/// And what a block, of those that the tile may touch, leaves open of it.
SHARED_FUNCTION Opening withBlock(Opening opening, TileReach reach, ivec2 block, Occluder occluder) {
    ivec2 corner = block * kOccluderSide;
    ivec2 first = max(reach.first - corner, ivec2(0)), last = min(reach.last - corner, ivec2(kOccluderSide - 1));
    uint columns = ((2u << uint(last.x)) - (1u << uint(first.x))) * 0x01010101u;
    uint above = occluder.openAbove & columns & bitsBefore(last.y + 1) & ~bitsBefore(first.y);
    uint below = occluder.openBelow & columns & bitsBefore(last.y - 3) & ~bitsBefore(first.y - 4);
    if (occluder.least > floatBitsToUint(reach.nearest)) {
        uint both = above | below;
        if (both == 0u) return opening;
        both |= both >> 16;
        both = (both | (both >> 8)) & 0xffu;
        first = ivec2(findLSB(both), above != 0u ? findLSB(above) / 8 : 4 + findLSB(below) / 8);
        last = ivec2(findMSB(both), below != 0u ? 4 + findMSB(below) / 8 : findMSB(above) / 8);
    }
    opening.first = min(opening.first, corner + first);
    opening.last = max(opening.last, corner + last);
    return opening;
}

/// Samples of a tile, and its squares, stand row by row (scene/tile.cpp): but those of scraps, and what stands in for
/// damaged tiles (render/chunk_bytes.h).
SHARED_FUNCTION bool comesRowByRow(TileDraw draw) {
    return placeBitsOf(draw) == kRowPlaceBits && (levelAndClassOf(draw) & 3u) != kClassUnseen;
}

/// Rows (PassedDraw) of whose samples (squares: between that row and the next) any may be seen, in whole bands. Not
/// asked: all.
SHARED_FUNCTION uint rowsIn(Opening opening, TileDraw draw, bool isSplats, bool asks) {
    const int bands = 8;
    int height = heightOf(draw), deep = (height + bands - 1) / bands;
    float beyond = beyondOf(draw, isSplats);
    int first = height, end = 0;
    bool isWhole = !asks || !comesRowByRow(draw);
    // As the end of a loop, not a branch: processors take several tiles at once, and only loops are left early.
    int rows = isWhole ? 0 : height;
    for (int row = 0; row < rows; row += deep) {
        Sighting sighting = sightOf(boxOfRows(draw, float(row), float(row + deep)));
        isWhole = isWhole || !sighting.isAllBefore;
        vec2 low = sighting.least - beyond, high = sighting.most + beyond;
        bool isIn = high.x >= float(opening.first.x) && low.x <= float(opening.last.x + 1) &&
                    high.y >= float(opening.first.y) && low.y <= float(opening.last.y + 1);
        if (isIn) first = min(first, row), end = row + deep;
    }
    if (isWhole) return kAllRows;
    return end == 0 ? kNoRows : uint(first) | (uint(end) << 8);
}

SHARED_END

#endif
