#ifndef RENDER_SHADERS_SHARED_LARGE_PART_H
#define RENDER_SHADERS_SHARED_LARGE_PART_H
// Pieces of a tile (squares of the mesh, facets) that cover many pixels: right before a wall a few of them cover the
// picture, and the one workgroup that draws their tile would be all that works. A graphics card puts parts of them on a
// list instead, and as many workgroups as it has draw those.
//
// Lavapipe has no more workers than tiles, and draws them at once, but ends loops silently: an invocation goes 65,535
// times through loops, all of them together, and no farther. There a workgroup lists what would take it too far.
//
// The list lies where the holes of the picture do (shared/hole_words.h), which are looked for later: the number of
// parts that wanted to be on it, how many workgroups draw them (as an indirect dispatch has it), and the parts.

#include "render/shaders/shared/language.h"

SHARED_BEGIN

SHARED_CONSTANT int kPartSide = 32; ///< pixels

struct LargePart {
    uint draw;  ///< of the list of draws, or kNoPart: nothing
    uint item;  ///< of the draw, as its warp numbers them
    uint first; ///< its first pixel on the screen, x | y << 16; it is kPartSide wide and high
};

SHARED_CONSTANT uint kNoPart = 0xffffffffu;
SHARED_CONSTANT uint kLargePartsHead = 4u;   ///< words before the first
SHARED_CONSTANT uint kLargePartsGroups = 1u; ///< word from which on the workgroups stand

/// What a pipeline does with large pieces: draws them; lists them; draws those that are listed.
SHARED_CONSTANT uint kDrawsLarge = 0u, kListsLarge = 1u, kDrawsListed = 2u;

#ifdef __cplusplus
static_assert(sizeof(LargePart) == 12);
#endif

/// Part of a box of pixels, from its first on.
struct BoxPart {
    ivec2 first;
    ivec2 extent;
};

SHARED_FUNCTION uint partsOf(ivec2 extent) {
    int across = (extent.x + kPartSide - 1) / kPartSide, down = (extent.y + kPartSide - 1) / kPartSide;
    return uint(across * down);
}

/// Where part number i of a box lies, row by row: what LargePart::first says.
SHARED_FUNCTION uint firstOfPart(ivec2 boxFirst, ivec2 extent, uint i) {
    int across = (extent.x + kPartSide - 1) / kPartSide;
    int x = boxFirst.x + kPartSide * (int(i) % across), y = boxFirst.y + kPartSide * (int(i) / across);
    return uint(x) | (uint(y) << 16);
}

/// What of a box such a part has. Whoever listed it may have rounded the box another way.
SHARED_FUNCTION BoxPart partOf(ivec2 boxFirst, ivec2 extent, uint first) {
    ivec2 offset = ivec2(int(first & 0xffffu), int(first >> 16)) - boxFirst;
    BoxPart part;
    part.first = max(offset, ivec2(0, 0));
    part.extent = max(min(offset + kPartSide, extent) - part.first, ivec2(0, 0));
    return part;
}

SHARED_FUNCTION BoxPart wholeOf(ivec2 extent) {
    BoxPart part;
    part.first = ivec2(0, 0);
    part.extent = extent;
    return part;
}

SHARED_END

#endif
