#version 460
// An eye's depth as displays' runtimes take it, to be copied into their image (shared/eye_output.h).

#extension GL_GOOGLE_include_directive : require

#include "render/shaders/shared/eye_output.h"

layout(local_size_x_id = 0) in;

layout(std430, set = 0, binding = 0) readonly buffer Depths { float depths[]; };
layout(std430, set = 0, binding = 1) writeonly buffer Reversed { float reversed[]; };
layout(push_constant) uniform Constants { EyeOutputConstants constants; };

void main()
{
    uint width = uint(constants.width), end = (gl_WorkGroupID.x + 1u) * width;
    for (uint i = gl_WorkGroupID.x * width + gl_LocalInvocationID.x; i < end; i += gl_WorkGroupSize.x)
        reversed[i] = nearOverDepth(constants.nearMetres, depths[i]);
}
