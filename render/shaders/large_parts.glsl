// The list of large pieces' parts (shared/large_part.h), for warps that draw pieces of more than one pixel.
#include "render/shaders/shared/large_part.h"
#include "render/shaders/shared/triangle.h"

layout(constant_id = 3) const uint LARGE_PIECES = kDrawsLarge;
layout(constant_id = 4) const uint LARGE_PIXELS = 256u; // pieces of more are drawn by all lanes of a subgroup
layout(constant_id = 5) const uint MOST_STEPS = 0u;     // 0: very large pieces are listed; else what takes more steps
layout(constant_id = 6) const uint MOST_GROUPS = 1024u; // that draw what is listed

layout(std430, set = 1, binding = 5) buffer LargeParts { uint wanted; uint groups[3]; LargePart parts[]; };

uint stepsTaken = 0u; // through loops over pixels of large pieces

ivec2 extentOf(PixelBox box)
{
    return max(box.last - box.first + 1, 0);
}

/// Whether a piece is to be listed rather than drawn by these lanes.
bool isForOthers(ivec2 extent, int lanes)
{
    if (MOST_STEPS == 0u) return extent.x * extent.y > kPartSide * kPartSide;
    uint steps = uint(extent.x * extent.y / lanes + extent.x + extent.y) + 1u;
    if (stepsTaken + steps > MOST_STEPS) return true;
    stepsTaken += steps;
    return false;
}

/// Asks whether the parts of a piece are on the list now; else it must be drawn. By all lanes that are there of a
/// subgroup: they are `lanes`, and this one is number myPlace.
bool listParts(uint draw, uint item, PixelBox box, int myPlace, int lanes)
{
    ivec2 extent = extentOf(box);
    if (LARGE_PIECES != kListsLarge || !isForOthers(extent, lanes)) return false;
    uint count = partsOf(extent), room = uint(parts.length()), first = room;
    if (myPlace == 0 && wanted < room) {
        first = atomicAdd(wanted, count);
        atomicMax(groups[0], min(first + count, MOST_GROUPS));
        groups[1] = groups[2] = 1u;
    }
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

/// Pieces that all lanes of a subgroup draw together are looked for so many turns at a time, and only then drawn: a
/// software driver goes once through every loop within a loop, and would go through the drawing in every turn.
const uint kTurns = 32u;

uint endOfTurns(uint start, uint end)
{
    return min(start + kTurns * gl_WorkGroupSize.x, end);
}

/// The number of a piece that some lane wants drawn. start: of the first turn's first piece. marks: bit i is set where
/// the lane's piece of turn i is wanted, and cleared. wanting: the lanes that have any.
uint takeMarked(uint start, inout uint marks, uvec4 wanting)
{
    uint lane = subgroupBallotFindLSB(wanting), turn = uint(findLSB(subgroupBroadcast(marks, lane)));
    if (gl_SubgroupInvocationID == lane) marks &= marks - 1u;
    return start + turn * gl_WorkGroupSize.x + subgroupBroadcast(gl_LocalInvocationID.x, lane);
}
