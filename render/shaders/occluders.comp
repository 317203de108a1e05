#version 460
// The least order disparity in each block of the z-buffer (shared/occlusion.h). One invocation a block.
#extension GL_GOOGLE_include_directive : require

#include "render/shaders/shared/occlusion.h"

layout(local_size_x_id = 0) in;

layout(set = 0, binding = 4) uniform usamplerBuffer zTexels;
layout(std430, set = 0, binding = 6) buffer Occluders { uint leastDisparity[]; };
layout(push_constant) uniform Constants { OccluderConstants constants; };

/// Beyond the image its rim goes on.
uint disparityAt(int x, int y)
{
    ivec2 last = ivec2(constants.width, constants.height) - 1;
    return texelFetch(zTexels, clamp(y, 0, last.y) * constants.width + clamp(x, 0, last.x)).y;
}

/// Of the pixels of a row of a block, the greatest of each and of those beside it.
void readAcross(int x, int y, out uint across[kOccluderSide])
{
    uint before = disparityAt(x - 1, y), here = disparityAt(x, y);
    for (int i = 0; i < kOccluderSide; ++i) {
        uint next = disparityAt(x + i + 1, y);
        across[i] = max(here, max(before, next));
        before = here;
        here = next;
    }
}

uint leastOf(ivec2 first)
{
    uint least = 0xffffffffu;
    for (int y = 0; y < kOccluderSide && least > 0u; ++y)
        for (int x = 0; x < kOccluderSide; ++x) least = min(least, disparityAt(first.x + x, first.y + y));
    return least;
}

uint leastOfClosed(ivec2 first)
{
    uint least = 0xffffffffu;
    uint above[kOccluderSide], here[kOccluderSide], below[kOccluderSide];
    readAcross(first.x, first.y - 1, above);
    readAcross(first.x, first.y, here);
    for (int y = 1; y <= kOccluderSide && least > 0u; ++y) {
        readAcross(first.x, first.y + y, below);
        for (int x = 0; x < kOccluderSide; ++x) {
            least = min(least, max(here[x], max(above[x], below[x])));
            above[x] = here[x];
            here[x] = below[x];
        }
    }
    return least;
}

void main()
{
    int across = occludersAlong(constants.width), row = int(gl_WorkGroupID.x);
    for (int column = int(gl_LocalInvocationID.x); column < across; column += int(gl_WorkGroupSize.x)) {
        int block = row * across + column;
        if (constants.isAgain != 0 && leastDisparity[block] > 0u) continue;
        ivec2 first = ivec2(column, row) * kOccluderSide;
        leastDisparity[block] = constants.closesGaps != 0 ? leastOfClosed(first) : leastOf(first);
    }
}
