#version 460
// The z-buffer becomes an ordinary picture: colour with its class in the last byte, and depth in metres along z. Which
// pixels hold anything, and which may be seen through a crack, is told by a bit each on the way, for the hole filler
// (list_holes.comp, fill_holes.comp); and no holes are on any row's list yet. Colours may be interpolated between samples
// (between_samples.h).
//
// On a graphics card an invocation resolves a pixel: neighbours read and write what stands beside one another. On a
// processor it resolves 32, a word of bits, one after the other, and keeps the one to the left.
#extension GL_GOOGLE_include_directive : require

#include "render/shaders/shared/between_samples.h"
#include "render/shaders/shared/hole_fill.h"
#include "render/shaders/shared/hole_words.h"
#include "render/shaders/shared/z_key.h"

layout(local_size_x_id = 0) in;
layout(constant_id = 1) const bool MARKS_HOLES = true;
layout(constant_id = 2) const bool BY_WORDS = false;
layout(constant_id = 3) const bool INTERPOLATES = false;

layout(std430, set = 0, binding = 2) writeonly buffer Colours { uint colours[]; };
layout(std430, set = 0, binding = 3) writeonly buffer Depths { float depths[]; };
layout(set = 0, binding = 4) uniform usamplerBuffer zTexels;
layout(std430, set = 0, binding = 5) writeonly buffer Holes { uint holes[]; };
layout(push_constant) uniform Constants { ResolveConstants constants; };

const uint kMostWords = 32u; // of a workgroup
shared uint empty[kMostWords], pinholes[kMostWords];

uvec2 keyAt(int x, int y)
{
    bool isInside = uint(x) < uint(constants.width) && uint(y) < uint(constants.height);
    return isInside ? texelFetch(zTexels, y * constants.width + x).xy : uvec2(0u);
}

/// What a pixel shows: r | g << 8 | b << 16 | class << 24. left, right: the keys beside it.
uint colourOf(int x, int y, uvec2 own, uvec2 left, uvec2 right)
{
    if (!INTERPOLATES) return colourAndClassOf(own) | (constants.places.own == 0 ? 0u : placeKept(own));
    ivec2 way = wayAcross(placeOf(own, constants.places));
    uvec2 beside = way.x < 0 ? left : right, over = keyAt(x, y + way.y), across = keyAt(x + way.x, y + way.y);
    return interpolatedColour(own, beside, over, across, way, constants.places);
}

void put(int x, int y, uvec2 key, uint colour)
{
    colours[y * constants.width + x] = isHole(key) ? 0u : colour;
    depths[y * constants.width + x] = depthOf(key);
}

void putWord(int word, int y, uint held, uint cracks)
{
    holes[y * holeWordsAcross(constants.width) + word] = held;
    holes[pinholesAt(constants.width, constants.height, y) + word] = cracks;
}

void resolveWord(int word, int y)
{
    int first = word * kHoleWordBits, pixels = min(kHoleWordBits, constants.width - first);
    uint held = 0u, cracks = 0u;
    uvec2 left = keyAt(first - 1, y), own = keyAt(first, y);
    for (int i = 0; i < pixels; ++i) {
        int x = first + i;
        uvec2 right = keyAt(x + 1, y);
        put(x, y, own, colourOf(x, y, own, left, right));
        if (MARKS_HOLES) {
            held |= isHole(own) ? 0u : 1u << i;
            cracks |= isPinhole(own, left, keyAt(x, y - 1), constants.fill) ? 1u << i : 0u;
        }
        left = own, own = right;
    }
    if (MARKS_HOLES) putWord(word, y, held, cracks);
}

void resolvePixel(int x, int y, uint lane)
{
    uint word = lane / uint(kHoleWordBits), bit = 1u << (lane & uint(kHoleWordBits - 1));
    if (MARKS_HOLES) {
        if (bit == 1u) empty[word] = pinholes[word] = 0u;
        barrier();
    }
    if (x < constants.width) {
        uvec2 own = keyAt(x, y), left = keyAt(x - 1, y);
        put(x, y, own, colourOf(x, y, own, left, keyAt(x + 1, y)));
        // Few are: most invocations have nothing to say.
        if (MARKS_HOLES && isHole(own)) atomicOr(empty[word], bit);
        if (MARKS_HOLES && isPinhole(own, left, keyAt(x, y - 1), constants.fill)) atomicOr(pinholes[word], bit);
    }
    if (MARKS_HOLES) {
        barrier();
        int at = x / kHoleWordBits;
        if (bit == 1u && at < holeWordsAcross(constants.width))
            putWord(at, y, ~empty[word] & pixelsInWord(constants.width, at), pinholes[word]);
    }
}

void main()
{
    int y = int(gl_WorkGroupID.y), across = holeWordsAcross(constants.width);
    if (MARKS_HOLES && gl_GlobalInvocationID.x == 0u) holes[holeCountAt(constants.width, constants.height, y)] = 0u;
    if (!BY_WORDS) {
        resolvePixel(int(gl_GlobalInvocationID.x), y, gl_LocalInvocationID.x);
        return;
    }
    for (int word = int(gl_LocalInvocationID.x); word < across; word += int(gl_WorkGroupSize.x)) resolveWord(word, y);
}
