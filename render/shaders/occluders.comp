#version 460
// What each block of the z-buffer hides (shared/occlusion.h). One invocation a block.
#extension GL_GOOGLE_include_directive : require

#include "render/shaders/shared/occlusion.h"

layout(local_size_x_id = 0) in;

layout(set = 0, binding = 4) uniform usamplerBuffer zTexels;
layout(std430, set = 0, binding = 6) buffer Occluders { Occluder occluders[]; };
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

const uint kMost = 0xffffffffu;

bool isOpen(Occluder occluder)
{
    return (occluder.openAbove | occluder.openBelow) != 0u;
}

Occluder withPixel(Occluder occluder, int x, int y, uint disparity)
{
    uint bit = disparity == 0u ? 1u << uint(kOccluderSide * (y & 3) + x) : 0u;
    if (y < 4)
        occluder.openAbove |= bit;
    else
        occluder.openBelow |= bit;
    occluder.least = min(occluder.least, disparity == 0u ? kMost : disparity);
    return occluder;
}

Occluder occluderOf(ivec2 first)
{
    Occluder occluder = Occluder(kMost, 0u, 0u, 0u);
    for (int y = 0; y < kOccluderSide; ++y)
        for (int x = 0; x < kOccluderSide; ++x)
            occluder = withPixel(occluder, x, y, disparityAt(first.x + x, first.y + y));
    return occluder;
}

Occluder occluderOfClosed(ivec2 first)
{
    Occluder occluder = Occluder(kMost, 0u, 0u, 0u);
    uint above[kRowReach], here[kRowReach], below[kRowReach];
    readRow(first.x, first.y - 1, above);
    readRow(first.x, first.y, here);
    for (int y = 0; y < kOccluderSide && !isOpen(occluder); ++y) {
        readRow(first.x, first.y + y + 1, below);
        for (int x = 1; x <= kOccluderSide; ++x)
            occluder = withPixel(occluder, x - 1, y,
                                 closedDisparity(here[x], uvec2(here[x - 1], here[x + 1]), uvec2(above[x], below[x]),
                                                 uvec2(above[x - 1], below[x + 1]), uvec2(above[x + 1], below[x - 1])));
        above = here;
        here = below;
    }
    return occluder;
}

void main()
{
    int across = occludersAlong(constants.width), row = int(gl_WorkGroupID.x);
    for (int column = int(gl_LocalInvocationID.x); column < across; column += int(gl_WorkGroupSize.x)) {
        int block = row * across + column;
        if (constants.isAgain != 0 && !isOpen(occluders[block])) continue;
        ivec2 first = ivec2(column, row) * kOccluderSide;
        Occluder occluder;
        if (constants.closesGaps != 0)
            occluder = occluderOfClosed(first);
        else
            occluder = occluderOf(first);
        // The finer the sieve, the more of what would close a gap stays behind it, and not every gap can be filled.
        if (constants.closesGaps != 0 && isOpen(occluder)) occluder.openAbove = occluder.openBelow = kMost;
        occluders[block] = occluder;
    }
}
