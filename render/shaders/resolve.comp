#version 460
// The z-buffer becomes an ordinary picture: colour with its class in the last byte, and depth in metres along z.
#extension GL_GOOGLE_include_directive : require

#include "render/shaders/shared/tile_draw.h"
#include "render/shaders/shared/z_key.h"

layout(local_size_x_id = 0) in;

layout(std430, set = 0, binding = 2) writeonly buffer Colours { uint colours[]; };
layout(std430, set = 0, binding = 3) writeonly buffer Depths { float depths[]; };
layout(set = 0, binding = 4) uniform usamplerBuffer zTexels;
layout(push_constant) uniform Constants { ResolveConstants constants; };

void main()
{
    uint end = (gl_WorkGroupID.x + 1u) * constants.width;
    for (uint i = gl_WorkGroupID.x * constants.width + gl_LocalInvocationID.x; i < end; i += gl_WorkGroupSize.x) {
        uvec2 key = texelFetch(zTexels, int(i)).xy;
        colours[i] = colourAndClassOf(key);
        depths[i] = depthOf(key);
    }
}
