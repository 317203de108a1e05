#version 460
// Passes on those tiles of a run that may still change the picture (shared/occlusion.h). One invocation a tile.
#extension GL_GOOGLE_include_directive : require

#include "render/shaders/shared/occlusion.h"

layout(local_size_x_id = 0) in;

layout(std430, set = 0, binding = 0) readonly buffer Draws { TileDraw draws[]; };
layout(std430, set = 0, binding = 6) readonly buffer Occluders { uint leastDisparity[]; };
layout(std430, set = 0, binding = 7) writeonly buffer Passed { TileDraw passed[]; };
layout(std430, set = 0, binding = 8) buffer PassedRuns { PassedRun runs[]; };
layout(push_constant) uniform Constants { OcclusionConstants constants; };

bool mayBeSeen(TileDraw draw, bool isSplats)
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
            if (leastDisparity[y * across + x] <= nearest) return true;
    return false;
}

void main()
{
    if (gl_GlobalInvocationID.x >= constants.count) return;
    TileDraw draw = draws[constants.firstDraw + gl_GlobalInvocationID.x];
    uint run = uint(draw.detail.w);
    uint firstAndKind = runs[run].firstAndKind;
    if (!mayBeSeen(draw, (firstAndKind & kSplatRun) != 0u)) return;
    passed[(firstAndKind & ~kSplatRun) + atomicAdd(runs[run].x, 1u)] = draw;
}
