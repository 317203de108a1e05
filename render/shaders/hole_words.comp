#version 460
// Which pixels hold anything, a bit each, for the hole filler; and no holes are on any row's list yet. A workgroup looks
// at one row, an invocation at 32 pixels at a time.
#extension GL_GOOGLE_include_directive : require

#include "render/shaders/shared/hole_fill.h"
#include "render/shaders/shared/hole_words.h"

layout(local_size_x_id = 0) in;

layout(set = 0, binding = 4) uniform usamplerBuffer zTexels;
layout(std430, set = 0, binding = 5) writeonly buffer Holes { uint holes[]; };
layout(push_constant) uniform Constants { ResolveConstants constants; };

void main()
{
    int across = holeWordsAcross(constants.width), y = int(gl_WorkGroupID.x);
    for (int word = int(gl_LocalInvocationID.x); word < across; word += int(gl_WorkGroupSize.x)) {
        int first = word * kHoleWordBits, row = y * constants.width;
        int pixels = min(kHoleWordBits, constants.width - first);
        uint held = 0u;
        for (int i = 0; i < pixels; ++i)
            held |= isHole(texelFetch(zTexels, row + first + i).xy) ? 0u : 1u << i;
        holes[y * across + word] = held;
    }
    if (gl_LocalInvocationID.x == 0u) holes[holeCountAt(constants.width, constants.height, y)] = 0u;
}
