#version 460
// The z-buffer becomes an ordinary picture: holes are filled where both sides are known; colour with its class in the
// last byte, and depth in metres along z. A workgroup resolves one row.
#extension GL_GOOGLE_include_directive : require

#include "render/shaders/shared/hole_fill.h"
#include "render/shaders/shared/tile_draw.h"
#include "render/shaders/shared/z_key.h"

layout(local_size_x_id = 0) in;
layout(constant_id = 1) const bool FILLS = true; // else holes stay

layout(std430, set = 0, binding = 2) writeonly buffer Colours { uint colours[]; };
layout(std430, set = 0, binding = 3) writeonly buffer Depths { float depths[]; };
layout(set = 0, binding = 4) uniform usamplerBuffer zTexels;
layout(std430, set = 0, binding = 5) readonly buffer Blocks { uint isOccupied[]; };
layout(push_constant) uniform Constants { ResolveConstants constants; };

uvec2 keyAt(ivec2 pixel)
{
    bool isInside = pixel.x >= 0 && pixel.y >= 0 && pixel.x < constants.width && pixel.y < constants.height;
    return isInside ? texelFetch(zTexels, pixel.y * constants.width + pixel.x).xy : uvec2(0u);
}

/// Whether anything can be within the radius of a hole.
bool isNearSomething(ivec2 pixel, bool hole)
{
    int radius = constants.fill.radius, across = holeBlocksAcross(constants.width);
    ivec2 end = ivec2(constants.width, constants.height) - 1;
    ivec2 first = max(pixel - radius, ivec2(0)) / kHoleBlockSide, last = min(pixel + radius, end) / kHoleBlockSide;
    uint found = 0u;
    last.y = hole ? last.y : -1; // what is no hole must not wait for the loop's end
    for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; ++x)
            found |= isOccupied[y * across + x];
    return found != 0u;
}

void main()
{
    int y = int(gl_WorkGroupID.x), row = y * constants.width;
    for (int x = int(gl_LocalInvocationID.x); x < constants.width; x += int(gl_WorkGroupSize.x)) {
        ivec2 pixel = ivec2(x, y);
        uvec2 key = texelFetch(zTexels, row + x).xy;
        if (FILLS) key = filled(pixel, key, isNearSomething(pixel, isHole(key)), constants.fill);
        colours[row + x] = colourAndClassOf(key);
        depths[row + x] = depthOf(key);
    }
}
