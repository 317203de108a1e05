#version 460
// occlusion.comp for two eyes: passes on those pairs of a run that may still change a picture, for the eyes whose
// picture that is. One invocation a pair.
#extension GL_GOOGLE_include_directive : require

#include "render/shaders/shared/occlusion.h"
#include "render/shaders/shared/stereo.h"

layout(local_size_x_id = 0) in;

layout(std430, set = 0, binding = 0) readonly buffer LeftDraws { TileDraw leftDraws[]; };
layout(std430, set = 0, binding = 6) readonly buffer LeftOccluders { uint leftLeast[]; };
layout(std430, set = 1, binding = 0) readonly buffer RightDraws { TileDraw rightDraws[]; };
layout(std430, set = 1, binding = 6) readonly buffer RightOccluders { uint rightLeast[]; };
layout(std430, set = 2, binding = 0) readonly buffer Pairs { PairDraw pairs[]; };
layout(std430, set = 2, binding = 1) writeonly buffer Passed { PairDraw passed[]; };
layout(std430, set = 2, binding = 2) buffer PassedRuns { PassedRun runs[]; };
layout(push_constant) uniform Constants { PairTestConstants constants; };

uint leastDisparity(bool isLeft, int block)
{
    return isLeft ? leftLeast[block] : rightLeast[block];
}

bool mayBeSeen(bool isLeft, TileDraw draw, bool isSplats)
{
    TileReach reach = reachOf(draw, isSplats, constants.width, constants.height);
    if (reach.nearest < 0.0f) return true;
    ivec2 size = reach.last - reach.first + 1;
    if (size.x <= 0 || size.y <= 0) return false;
    if (size.x * size.y > kMostOccluders) return true;
    int across = occludersAlong(constants.width);
    uint nearest = floatBitsToUint(reach.nearest);
    for (int y = reach.first.y; y <= reach.last.y; ++y)
        for (int x = reach.first.x; x <= reach.last.x; ++x)
            if (leastDisparity(isLeft, y * across + x) <= nearest) return true;
    return false;
}

void main()
{
    if (gl_GlobalInvocationID.x >= constants.count) return;
    PairDraw pair = pairs[constants.firstPair + gl_GlobalInvocationID.x];
    uint firstAndKind = runs[pair.run].firstAndKind;
    bool isSplats = (firstAndKind & kSplatRun) != 0u;
    if (pair.left != kNoDraw && !mayBeSeen(true, leftDraws[pair.left], isSplats)) pair.left = kNoDraw;
    if (pair.right != kNoDraw && !mayBeSeen(false, rightDraws[pair.right], isSplats)) pair.right = kNoDraw;
    if (pair.left == kNoDraw && pair.right == kNoDraw) return;
    passed[(firstAndKind & ~kSplatRun) + atomicAdd(runs[pair.run].x, 1u)] = pair;
}
