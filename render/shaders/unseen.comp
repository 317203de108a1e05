#version 460
// Pixels whose rays meet space that nobody observed, before what is drawn there, are shown as such.
#extension GL_GOOGLE_include_directive : require

#include "render/shaders/shared/z_key.h"

layout(local_size_x_id = 0) in;

layout(constant_id = 1) const uint kBrickLevels = 2u;

layout(std430, set = 0, binding = 2) buffer Colours { uint colours[]; };
layout(std430, set = 0, binding = 3) buffer Depths { float depths[]; };
layout(set = 1, binding = 0) uniform usamplerBuffer coverageWords;
layout(set = 1, binding = 1) uniform usamplerBuffer coverageBricks;
layout(set = 1, binding = 2) uniform usamplerBuffer coverageBases;

uint coverageWord(uint index) { return texelFetch(coverageWords, int(index)).x; }
uint coverageBrick(uint index) { return texelFetch(coverageBricks, int(index)).x; }
uint coverageBase(uint index) { return texelFetch(coverageBases, int(index)).x; }

#include "render/shaders/shared/unseen.h"

layout(push_constant) uniform Constants { UnseenConstants constants; };

UnseenGrid coverageGrid()
{
    return UnseenGrid(constants.gridFirst.xyz, constants.gridFirst.w, constants.gridCount.xyz);
}

uvec2 pixelOf(uint k) { return gl_WorkGroupID.xy * kBeamPixels + uvec2(k % kBeamPixels, k / kBeamPixels); }

bool isInPicture(uvec2 at) { return at.x < uint(constants.perX.w) && at.y < uint(constants.perY.w); }

float endAt(uint i) { return unseenEnd(constants, classOfPixel(colours[i]), depths[i]); }

// A workgroup draws a block of pixels, whose rays go together where space is open for all of them.
void main()
{
    const uint all = kBeamPixels * kBeamPixels;
    uint width = uint(constants.perX.w);
    // Together they need go no farther than any of them does.
    float farthest = 0.0f;
    for (uint k = gl_LocalInvocationID.x; k < all; k += gl_WorkGroupSize.x) {
        uvec2 at = pixelOf(k);
        if (isInPicture(at)) farthest = max(farthest, endAt(at.y * width + at.x));
    }
    vec2 first = vec2(gl_WorkGroupID.xy * kBeamPixels);
    float side = float(int(kBeamPixels));
    vec2 open = openStretch(constants.eye.xyz, rayOf(constants, first.x, first.y), side * constants.perX.xyz,
                            side * constants.perY.xyz, farthest);
    for (uint k = gl_LocalInvocationID.x; k < all; k += gl_WorkGroupSize.x) {
        uvec2 at = pixelOf(k);
        if (!isInPicture(at)) continue;
        uint i = at.y * width + at.x;
        float end = endAt(i);
        if (open.x <= 0.0f && end <= open.y) continue;
        vec3 direction = rayOf(constants, float(int(at.x)) + 0.5f, float(int(at.y)) + 0.5f);
        UnseenHit hit = walkToUnseen(constants.eye.xyz, direction, constants.eye.w, end, open);
        if (hit.isUnseen) {
            colours[i] = unseenColour(constants, direction, hit.depth) | (kClassUnseen << 24);
            depths[i] = hit.depth >= kRayInfinity ? uintBitsToFloat(0x7f800000u) : hit.depth;
        }
    }
}
