#version 460
// Pixels whose rays meet space that nobody observed, before what is drawn there, are shown as such.
#extension GL_GOOGLE_include_directive : require

#include "render/shaders/shared/z_key.h"

layout(local_size_x_id = 0) in;

layout(std430, set = 0, binding = 2) buffer Colours { uint colours[]; };
layout(std430, set = 0, binding = 3) buffer Depths { float depths[]; };
layout(set = 1, binding = 0) uniform usamplerBuffer coverageTexels;

uvec4 coverageTexel(uint index) { return texelFetch(coverageTexels, int(index)); }

#include "render/shaders/shared/unseen.h"

layout(push_constant) uniform Constants { UnseenConstants constants; };

// A workgroup draws a block of pixels, whose rays go together as far as space is open for all of them.
void main()
{
    uint width = uint(constants.perX.w), height = uint(constants.perY.w);
    uvec2 first = gl_WorkGroupID.xy * kBeamPixels;
    float side = float(int(kBeamPixels));
    float open = openDepth(constants.eye.xyz, rayOf(constants, float(int(first.x)), float(int(first.y))),
                           side * constants.perX.xyz, side * constants.perY.xyz);
    for (uint k = gl_LocalInvocationID.x; k < kBeamPixels * kBeamPixels; k += gl_WorkGroupSize.x) {
        uint x = first.x + k % kBeamPixels, y = first.y + k / kBeamPixels;
        if (x >= width || y >= height) continue;
        uint i = y * width + x;
        uint colourAndClass = colours[i];
        float end = unseenEnd(constants, colourAndClass >> 24, depths[i]);
        if (end <= open) continue;
        vec3 direction = rayOf(constants, float(int(x)) + 0.5f, float(int(y)) + 0.5f);
        UnseenHit hit = walkToUnseen(constants.eye.xyz, direction, constants.eye.w, end, open);
        if (hit.isUnseen) {
            colours[i] = unseenColour(constants, direction, hit.depth) | (kClassUnseen << 24);
            depths[i] = hit.depth >= kRayInfinity ? uintBitsToFloat(0x7f800000u) : hit.depth;
        }
    }
}
