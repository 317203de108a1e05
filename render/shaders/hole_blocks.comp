#version 460
// Which blocks of the z-buffer hold anything, for the hole filler. An invocation looks at a block until it finds
// something, so that only empty ones are read whole.
#extension GL_GOOGLE_include_directive : require

#include "render/shaders/shared/hole_fill.h"

layout(local_size_x_id = 0) in;

layout(set = 0, binding = 4) uniform usamplerBuffer zTexels;
layout(std430, set = 0, binding = 5) writeonly buffer Blocks { uint isOccupied[]; };
layout(push_constant) uniform Constants { ResolveConstants constants; };

uvec2 keyAt(ivec2 pixel)
{
    return texelFetch(zTexels, pixel.y * constants.width + pixel.x).xy;
}

void main()
{
    int across = holeBlocksAcross(constants.width), row = int(gl_WorkGroupID.x);
    for (int column = int(gl_LocalInvocationID.x); column < across; column += int(gl_WorkGroupSize.x)) {
        ivec2 first = ivec2(column, row) * kHoleBlockSide;
        ivec2 size = min(ivec2(kHoleBlockSide), ivec2(constants.width, constants.height) - first);
        int pixels = size.x * size.y;
        bool found = false;
        for (int i = 0; i < pixels && !found; ++i)
            found = !isHole(keyAt(first + ivec2(i % size.x, i / size.x)));
        isOccupied[row * across + column] = found ? 1u : 0u;
    }
}
