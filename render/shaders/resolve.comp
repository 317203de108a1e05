#version 460
// The z-buffer becomes an ordinary picture: holes are filled where both sides are known; colour with its class in the
// last byte, and depth in metres along z. A workgroup resolves one row.
#extension GL_GOOGLE_include_directive : require

#include "render/shaders/shared/hole_fill.h"
#include "render/shaders/shared/tile_draw.h"
#include "render/shaders/shared/z_key.h"

layout(local_size_x_id = 0) in;

layout(std430, set = 0, binding = 2) writeonly buffer Colours { uint colours[]; };
layout(std430, set = 0, binding = 3) writeonly buffer Depths { float depths[]; };
layout(set = 0, binding = 4) uniform usamplerBuffer zTexels;
layout(push_constant) uniform Constants { ResolveConstants constants; };

uvec2 keyAt(ivec2 pixel)
{
    bool isInside = pixel.x >= 0 && pixel.y >= 0 && pixel.x < constants.width && pixel.y < constants.height;
    return isInside ? texelFetch(zTexels, pixel.y * constants.width + pixel.x).xy : uvec2(0u);
}

void main()
{
    int y = int(gl_WorkGroupID.x), row = y * constants.width;
    for (int x = int(gl_LocalInvocationID.x); x < constants.width; x += int(gl_WorkGroupSize.x)) {
        uvec2 key = texelFetch(zTexels, row + x).xy;
        if (constants.fill.radius > 0) key = filled(ivec2(x, y), key, constants.fill);
        colours[row + x] = colourAndClassOf(key);
        depths[row + x] = depthOf(key);
    }
}
