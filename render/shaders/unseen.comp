#version 460
// Pixels whose rays meet space that nobody observed, before what is drawn there, are shown as such.
#extension GL_GOOGLE_include_directive : require

#include "render/shaders/shared/z_key.h"

layout(local_size_x_id = 0) in;

layout(std430, set = 0, binding = 2) buffer Colours { uint colours[]; };
layout(std430, set = 0, binding = 3) buffer Depths { float depths[]; };
layout(set = 1, binding = 0) uniform usamplerBuffer coverageNodes;

uvec2 coverageTexel(uint index) { return texelFetch(coverageNodes, int(index)).xy; }

#include "render/shaders/shared/unseen.h"

layout(push_constant) uniform Constants { UnseenConstants constants; };

void main()
{
    uint width = uint(constants.perX.w);
    uint y = gl_WorkGroupID.x;
    for (uint x = gl_LocalInvocationID.x; x < width; x += gl_WorkGroupSize.x) {
        uint i = y * width + x;
        uint colourAndClass = colours[i];
        float end = unseenEnd(constants, colourAndClass >> 24, depths[i]);
        vec3 direction = rayOf(constants, float(int(x)) + 0.5f, float(int(y)) + 0.5f);
        UnseenHit hit = walkToUnseen(constants.eye.xyz, direction, constants.eye.w, end);
        if (hit.isUnseen) {
            colours[i] = unseenColour(constants, direction, hit.depth) | (kClassUnseen << 24);
            depths[i] = hit.depth >= kRayInfinity ? uintBitsToFloat(0x7f800000u) : hit.depth;
        }
    }
}
