#version 460
// Passes on those tiles of a run, and their rows, that may still change the picture (shared/occlusion.h). One invocation
// a tile.
#extension GL_GOOGLE_include_directive : require

#include "render/shaders/shared/occlusion.h"

layout(local_size_x_id = 0) in;

layout(std430, set = 0, binding = 7) writeonly buffer Passed { PassedDraw passed[]; };
layout(std430, set = 0, binding = 8) buffer PassedRuns { PassedRun runs[]; };
layout(push_constant) uniform Constants { OcclusionConstants constants; };

layout(set = 0, binding = 9) uniform usamplerBuffer occluderTexels;
layout(set = 0, binding = 10) uniform usamplerBuffer drawTexels;

uvec4 occluderTexel(uint eye, int block)
{
    return texelFetch(occluderTexels, block);
}

uvec4 drawTexel(uint eye, int at)
{
    return texelFetch(drawTexels, at);
}

#include "render/shaders/look.glsl"

void main()
{
    if (gl_GlobalInvocationID.x >= constants.count) return;
    uint number = constants.firstDraw + gl_GlobalInvocationID.x;
    TileDraw draw = drawAt(0u, number);
    uint run = uint(draw.detail.w);
    uint firstAndKind = runs[run].firstAndKind;
    uint rows = rowsSeen(0u, draw, firstAndKind, constants.width, constants.height);
    if (rows == kNoRows) return;
    passed[(firstAndKind & kFirstOfRun) + atomicAdd(runs[run].x, 1u)] = PassedDraw(number, rows);
}
