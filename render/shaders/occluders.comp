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

const int kRowReach = kOccluderSide + 2; // a row of a block, and the pixels beside it

void readRow(int x, int y, out uint row[kRowReach])
{
    for (int i = 0; i < kRowReach; ++i) row[i] = disparityAt(x - 1 + i, y);
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
    uint above[kRowReach], here[kRowReach], below[kRowReach];
    readRow(first.x, first.y - 1, above);
    readRow(first.x, first.y, here);
    for (int y = 1; y <= kOccluderSide && least > 0u; ++y) {
        readRow(first.x, first.y + y, below);
        for (int x = 1; x <= kOccluderSide; ++x)
            least = min(least, closedDisparity(here[x], uvec2(here[x - 1], here[x + 1]), uvec2(above[x], below[x]),
                                               uvec2(above[x - 1], below[x + 1]), uvec2(above[x + 1], below[x - 1])));
        above = here;
        here = below;
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
