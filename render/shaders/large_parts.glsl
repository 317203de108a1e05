// The list of large pieces' parts (shared/large_part.h), for warps that draw pieces of more than one pixel.
#include "render/shaders/shared/large_part.h"
#include "render/shaders/shared/triangle.h"

layout(constant_id = 3) const uint LARGE_PIECES = kDrawsLarge;
layout(constant_id = 4) const uint LARGE_PIXELS = 256u; // pieces of more are drawn by all lanes of a subgroup

layout(std430, set = 1, binding = 5) buffer LargeParts { uint wanted; uint unused[3]; LargePart parts[]; };

ivec2 extentOf(PixelBox box)
{
    return max(box.last - box.first + 1, 0);
}

/// Asks whether the parts of a piece are on the list now; else it must be drawn. By all lanes that are there of a
/// subgroup: they are `lanes`, and this one is number myPlace.
bool listParts(uint draw, uint item, PixelBox box, int myPlace, int lanes)
{
    ivec2 extent = extentOf(box);
    if (LARGE_PIECES != kListsLarge || extent.x * extent.y <= kPartSide * kPartSide) return false;
    uint count = partsOf(extent), room = uint(parts.length()), first = room;
    if (myPlace == 0 && wanted < room) first = atomicAdd(wanted, count);
    first = subgroupBroadcastFirst(first);
    bool fits = count <= room && first <= room - count;
    for (uint i = uint(myPlace); i < count && first + i < room; i += uint(lanes))
        parts[first + i] = LargePart(fits ? draw : kNoPart, item, firstOfPart(box.first, extent, i));
    return fits;
}

bool isOfRun(LargePart part, WarpConstants run)
{
    return part.draw >= run.firstDraw && part.draw - run.firstDraw < run.count;
}
