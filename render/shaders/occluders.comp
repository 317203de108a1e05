#version 460
// The least order disparity in each block of the z-buffer (shared/occlusion.h). One invocation a block.
#extension GL_GOOGLE_include_directive : require

#include "render/shaders/shared/occlusion.h"

layout(local_size_x_id = 0) in;

layout(set = 0, binding = 4) uniform usamplerBuffer zTexels;
layout(std430, set = 0, binding = 6) writeonly buffer Occluders { uint leastDisparity[]; };
layout(push_constant) uniform Constants { OccluderConstants constants; };

uint disparityAt(int x, int y)
{
    ivec2 last = ivec2(constants.width, constants.height) - 1;
    return texelFetch(zTexels, clamp(y, 0, last.y) * constants.width + clamp(x, 0, last.x)).y;
}

/// The greatest of three beside one another.
uint acrossAt(int x, int y)
{
    return max(disparityAt(x, y), max(disparityAt(x - 1, y), disparityAt(x + 1, y)));
}

uint leastOf(ivec2 first, ivec2 end)
{
    uint least = 0xffffffffu;
    for (int y = first.y; y < end.y && least > 0u; ++y)
        for (int x = first.x; x < end.x; ++x) least = min(least, disparityAt(x, y));
    return least;
}

uint leastOfClosed(ivec2 first, ivec2 end)
{
    uint least = 0xffffffffu;
    for (int x = first.x; x < end.x && least > 0u; ++x) {
        uint above = acrossAt(x, first.y - 1), here = acrossAt(x, first.y);
        for (int y = first.y; y < end.y; ++y) {
            uint below = acrossAt(x, y + 1);
            least = min(least, max(here, max(above, below)));
            above = here;
            here = below;
        }
    }
    return least;
}

void main()
{
    int across = occludersAlong(constants.width), row = int(gl_WorkGroupID.x);
    for (int column = int(gl_LocalInvocationID.x); column < across; column += int(gl_WorkGroupSize.x)) {
        ivec2 first = ivec2(column, row) * kOccluderSide;
        ivec2 end = min(first + kOccluderSide, ivec2(constants.width, constants.height));
        leastDisparity[row * across + column] =
            constants.closesGaps != 0 ? leastOfClosed(first, end) : leastOf(first, end);
    }
}
