// What the workgroup's tile is told by (TileDraw), for shaders that draw one tile by one workgroup.
//
// All invocations want the same words. A graphics card reads them once for all; lavapipe reads each word for each
// invocation, one after the other, and small tiles take longer to read than to draw. There each invocation reads some of
// the words, and all are told them.
#extension GL_KHR_shader_subgroup_ballot : require

layout(constant_id = 1) const uint SHARES_READING = 0u; // 1: the workgroup is one subgroup of 8 invocations

// What tiles the pipeline draws. A software driver goes through every branch, and once through
// every loop, with all its lanes, whether one of them wants to or not: what few tiles need has a pipeline of its own.
layout(constant_id = 2) const uint DRAWN_TILES = kDrawsAll;
const bool IS_PLAIN = DRAWN_TILES == kDrawsPlain, IS_SMALL = DRAWN_TILES == kDrawsSmall;

layout(std430, set = 1, binding = 0) readonly buffer Draws { TileDraw draws[]; };
layout(std430, set = 1, binding = 0) readonly buffer DrawWords { uint drawWords[]; };

const uint kDrawWords = 28u; // tile_draw.h asserts that they are 112 bytes

#define TOLD_BY(word, first)                                                                                           \
    uvec4(subgroupBroadcast(word, first), subgroupBroadcast(word, (first) + 1u), subgroupBroadcast(word, (first) + 2u), \
          subgroupBroadcast(word, (first) + 3u))

layout(std430, set = 1, binding = 7) readonly buffer Passed { PassedDraw passed[]; };

/// Which draw is this workgroup's, and which of its rows.
PassedDraw drawOf(uint firstDraw, uint workgroup)
{
    if ((firstDraw & kAmongPassed) != 0u) return passed[(firstDraw & ~kAmongPassed) + workgroup];
    return PassedDraw(firstDraw + workgroup, kAllRows);
}

TileDraw readDraw(uint number)
{
    if (SHARES_READING == 0u) return draws[number];
    uint first = kDrawWords * number, lane = gl_SubgroupInvocationID;
    uint a = drawWords[first + lane], b = drawWords[first + 8u + lane], c = drawWords[first + 16u + lane],
         d = drawWords[first + 24u + (lane & 3u)];
    TileDraw draw;
    draw.base = uintBitsToFloat(TOLD_BY(a, 0u));
    draw.perX = uintBitsToFloat(TOLD_BY(a, 4u));
    draw.perY = uintBitsToFloat(TOLD_BY(b, 0u));
    draw.perQ = uintBitsToFloat(TOLD_BY(b, 4u));
    draw.span = TOLD_BY(c, 0u);
    draw.source = TOLD_BY(c, 4u);
    draw.detail = uintBitsToFloat(TOLD_BY(d, 0u));
    return draw;
}
