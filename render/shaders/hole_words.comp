#version 460
// Which pixels hold anything, and which may be seen through a crack, a bit each, for the hole filler; and no holes are on
// any row's list yet. A workgroup looks at one row, an invocation at 32 pixels at a time.
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
        uint held = 0u, pinholes = 0u;
        uvec2 left = first > 0 ? texelFetch(zTexels, row + first - 1).xy : uvec2(0u);
        for (int i = 0; i < pixels; ++i) {
            uvec2 own = texelFetch(zTexels, row + first + i).xy;
            uvec2 above = y > 0 ? texelFetch(zTexels, row - constants.width + first + i).xy : uvec2(0u);
            held |= isHole(own) ? 0u : 1u << i;
            pinholes |= isPinhole(own, left, above, constants.fill) ? 1u << i : 0u;
            left = own;
        }
        holes[y * across + word] = held;
        holes[pinholesAt(constants.width, constants.height, y) + word] = pinholes;
    }
    if (gl_LocalInvocationID.x == 0u) holes[holeCountAt(constants.width, constants.height, y)] = 0u;
}
