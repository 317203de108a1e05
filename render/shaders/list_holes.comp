#version 460
// What may have to be filled goes on its row's list, to be drawn over (fill_holes.comp): few pixels are holes, and the
// others must not wait for them. A workgroup looks at one row, an invocation at 32 pixels at a time.
#extension GL_GOOGLE_include_directive : require

#include "render/shaders/shared/hole_fill.h"
#include "render/shaders/shared/hole_words.h"

layout(local_size_x_id = 0) in;

layout(std430, set = 0, binding = 5) buffer Holes { uint holes[]; };
layout(push_constant) uniform Constants { ResolveConstants constants; };

uint heldAt(int row, int word)
{
    int across = holeWordsAcross(constants.width);
    bool isInside = row >= 0 && row < constants.height && word >= 0 && word < across;
    return isInside ? holes[row * across + word] : 0u;
}

void main()
{
    int row = int(gl_WorkGroupID.y), across = holeWordsAcross(constants.width);
    int count = holeCountAt(constants.width, constants.height, row);
    int columns = holeColumnsAt(constants.width, constants.height, row);
    for (int word = int(gl_LocalInvocationID.x); word < across; word += int(gl_WorkGroupSize.x)) {
        uint asked = ~heldAt(row, word) & pixelsInWord(constants.width, word);
        uint toFill = withBothEnds(row, word, asked, constants.fill.radius) |
                      holes[pinholesAt(constants.width, constants.height, row) + word] |
                      (asked & rimInWord(constants.width, constants.height, row, word));
        if (toFill == 0u) continue;
        int place = columns + int(atomicAdd(holes[count], uint(bitCount(toFill))));
        for (; toFill != 0u; toFill &= toFill - 1u) {
            holes[place] = uint(word * kHoleWordBits + findLSB(toFill));
            ++place;
        }
    }
}
