#version 460
// The mean of what was added replaces the resolved colour; where nothing was added the front surface's own stays.
#extension GL_GOOGLE_include_directive : require

#include "render/shaders/shared/blend.h"
#include "render/shaders/shared/hole_fill.h"

layout(local_size_x_id = 0) in;

layout(std430, set = 0, binding = 2) buffer Colours { uint colours[]; };
layout(set = 0, binding = 4) uniform usamplerBuffer zTexels;
layout(std430, set = 1, binding = 1) readonly buffer Sums { uvec4 sums[]; };
layout(push_constant) uniform Constants { BlendResolveConstants constants; };

void main()
{
    int end = int(gl_WorkGroupID.x + 1u) * constants.width;
    for (int i = end - constants.width + int(gl_LocalInvocationID.x); i < end; i += int(gl_WorkGroupSize.x)) {
        uvec4 sum = sums[i];
        // What was filled is not what the samples were compared with.
        bool isFront = colours[i] == colourAndClassOf(texelFetch(zTexels, i).xy);
        if (sum.w != 0u && isFront) colours[i] = (colours[i] & 0xff000000u) | meanColourOf(sum.xy, sum.zw);
    }
}
