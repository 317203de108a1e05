#version 460
// The z-buffer becomes an ordinary picture: colour with its class in the last byte, and depth in metres along z. A
// workgroup resolves one row. What may have to be filled goes on the row's list, too, and is drawn over (fill_holes.comp):
// few pixels are holes, and the others must not wait for them.
#extension GL_GOOGLE_include_directive : require

#include "render/shaders/shared/hole_fill.h"
#include "render/shaders/shared/hole_words.h"
#include "render/shaders/shared/tile_draw.h"
#include "render/shaders/shared/z_key.h"

layout(local_size_x_id = 0) in;
layout(constant_id = 1) const bool LISTS = true; // what may have to be filled

layout(std430, set = 0, binding = 2) writeonly buffer Colours { uint colours[]; };
layout(std430, set = 0, binding = 3) writeonly buffer Depths { float depths[]; };
layout(set = 0, binding = 4) uniform usamplerBuffer zTexels;
layout(std430, set = 0, binding = 5) buffer Holes { uint holes[]; };
layout(push_constant) uniform Constants { ResolveConstants constants; };

uint heldAt(int row, int word)
{
    int across = holeWordsAcross(constants.width);
    bool isInside = row >= 0 && row < constants.height && word >= 0 && word < across;
    return isInside ? holes[row * across + word] : 0u;
}

void list(int row, int x)
{
    uint place = atomicAdd(holes[holeCountAt(constants.width, constants.height, row)], 1u);
    holes[holeColumnsAt(constants.width, constants.height, row) + int(place)] = uint(x);
}

void listHoles(int row)
{
    int across = holeWordsAcross(constants.width);
    for (int word = int(gl_LocalInvocationID.x); word < across; word += int(gl_WorkGroupSize.x)) {
        uint asked = ~heldAt(row, word) & pixelsInWord(constants.width, word);
        uint toFill = withBothEnds(row, word, asked, constants.fill.radius) |
                      holes[pinholesAt(constants.width, constants.height, row) + word];
        for (; toFill != 0u; toFill &= toFill - 1u)
            list(row, word * kHoleWordBits + findLSB(toFill));
    }
}

void main()
{
    int y = int(gl_WorkGroupID.x), row = y * constants.width;
    if (LISTS) listHoles(y);
    for (int x = int(gl_LocalInvocationID.x); x < constants.width; x += int(gl_WorkGroupSize.x)) {
        uvec2 key = texelFetch(zTexels, row + x).xy;
        colours[row + x] = colourAndClassOf(key);
        depths[row + x] = depthOf(key);
    }
}
