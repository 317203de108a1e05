#version 460
// The z-buffer becomes an ordinary picture: colour with its class in the last byte, and depth in metres along z.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require

#include "render/shaders/shared/tile_draw.h"
#include "render/shaders/shared/z_key.h"

layout(local_size_x_id = 0) in;

layout(std430, set = 0, binding = 1) readonly buffer ZBuffer { uint64_t zBuffer[]; };
layout(std430, set = 0, binding = 2) writeonly buffer Colours { uint colours[]; };
layout(std430, set = 0, binding = 3) writeonly buffer Depths { float depths[]; };
layout(push_constant) uniform Constants { ResolveConstants constants; };

void main()
{
    uint end = (gl_WorkGroupID.x + 1u) * constants.width;
    for (uint i = gl_WorkGroupID.x * constants.width + gl_LocalInvocationID.x; i < end; i += gl_WorkGroupSize.x) {
        uvec2 key = unpackUint2x32(zBuffer[i]);
        colours[i] = colourAndClassOf(key);
        depths[i] = depthOf(key);
    }
}
