#version 460
// What rescale.comp makes of a picture that is no larger than the eye's: each pixel lies between two old ones along each
// axis. A workgroup makes a band of rows, so that where a column lies is worked out once for all of them.
#extension GL_GOOGLE_include_directive : require

#include "render/shaders/shared/rescale.h"

layout(local_size_x_id = 0) in;

layout(set = 0, binding = 0) uniform usamplerBuffer fromColours;
layout(set = 0, binding = 1) uniform samplerBuffer fromDepths;
layout(std430, set = 0, binding = 2) writeonly buffer Colours { uint colours[]; };
layout(std430, set = 0, binding = 3) writeonly buffer Depths { float depths[]; };
layout(push_constant) uniform Constants { RescaleConstants constants; };

uint colourAt(uint place)
{
    return texelFetch(fromColours, int(place)).x;
}

void main()
{
    uint fromWidth = constants.fromWidth, width = constants.toWidth;
    uint firstRow = gl_WorkGroupID.x * kEnlargedRows;
    uint endRow = min(firstRow + kEnlargedRows, constants.toHeight);
    for (uint x = gl_LocalInvocationID.x; x < width; x += gl_WorkGroupSize.x) {
        Between column = betweenOf(x, fromWidth, width);
        for (uint y = firstRow; y < endRow; ++y) {
            Between row = betweenOf(y, constants.fromHeight, constants.toHeight);
            uint above = row.first * fromWidth, below = row.last * fromWidth;
            uvec4 pixels = uvec4(colourAt(above + column.first), colourAt(above + column.last),
                                 colourAt(below + column.first), colourAt(below + column.last));
            uvec2 inRow = row.isNearLast != 0u ? pixels.zw : pixels.xy;
            uint nearest = column.isNearLast != 0u ? inRow.y : inRow.x, kind = kindOf(nearest);
            uint aboveWeight = kWholeWeight - row.lastWeight, leftWeight = kWholeWeight - column.lastWeight;
            uvec4 weights = uvec4(aboveWeight * leftWeight, aboveWeight * column.lastWeight, row.lastWeight * leftWeight,
                                  row.lastWeight * column.lastWeight);
            ColourSum sum = ColourSum(0u, 0u, 0u, 0u);
            sum = addColour(sum, pixels.x, kindOf(pixels.x) == kind ? weights.x : 0u);
            sum = addColour(sum, pixels.y, kindOf(pixels.y) == kind ? weights.y : 0u);
            sum = addColour(sum, pixels.z, kindOf(pixels.z) == kind ? weights.z : 0u);
            sum = addColour(sum, pixels.w, kindOf(pixels.w) == kind ? weights.w : 0u);
            uint place = y * width + x;
            colours[place] = meanColour(sum, nearest);
            uint nearestPlace =
                (row.isNearLast != 0u ? below : above) + (column.isNearLast != 0u ? column.last : column.first);
            depths[place] = texelFetch(fromDepths, int(nearestPlace)).x;
        }
    }
}
