#version 460
// occlusion.comp for two eyes: passes on those pairs of a run that may still change a picture, for the eyes whose
// picture that is. One invocation a pair.
#extension GL_GOOGLE_include_directive : require

#include "render/shaders/shared/occlusion.h"
#include "render/shaders/shared/stereo.h"

layout(local_size_x_id = 0) in;

layout(set = 0, binding = 9) uniform usamplerBuffer leftOccluders;
layout(set = 0, binding = 10) uniform usamplerBuffer leftDraws;
layout(set = 1, binding = 9) uniform usamplerBuffer rightOccluders;
layout(set = 1, binding = 10) uniform usamplerBuffer rightDraws;
layout(std430, set = 2, binding = 0) readonly buffer Pairs { PairDraw pairs[]; };
layout(std430, set = 2, binding = 1) writeonly buffer Passed { PairDraw passed[]; };
layout(std430, set = 2, binding = 2) buffer PassedRuns { PassedRun runs[]; };
layout(push_constant) uniform Constants { PairTestConstants constants; };

uvec4 occluderTexel(uint eye, int block)
{
    return eye == kLeft ? texelFetch(leftOccluders, block) : texelFetch(rightOccluders, block);
}

uvec4 drawTexel(uint eye, int at)
{
    return eye == kLeft ? texelFetch(leftDraws, at) : texelFetch(rightDraws, at);
}

#include "render/shaders/look.glsl"

void main()
{
    if (gl_GlobalInvocationID.x >= constants.count) return;
    PairDraw pair = pairs[constants.firstPair + gl_GlobalInvocationID.x];
    uint firstAndKind = runs[pair.run].firstAndKind;
    if (pair.left != kNoDraw)
        pair.leftRows = rowsSeen(kLeft, drawAt(kLeft, pair.left), firstAndKind, constants.width, constants.height);
    if (pair.right != kNoDraw)
        pair.rightRows = rowsSeen(kRight, drawAt(kRight, pair.right), firstAndKind, constants.width, constants.height);
    if (pair.leftRows == kNoRows) pair.left = kNoDraw;
    if (pair.rightRows == kNoRows) pair.right = kNoDraw;
    if (pair.left == kNoDraw && pair.right == kNoDraw) return;
    passed[(firstAndKind & kFirstOfRun) + atomicAdd(runs[pair.run].x, 1u)] = pair;
}
