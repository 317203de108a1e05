#version 460
// The picture that was warped at another resolution becomes the eye's: colours are mixed, class and depth are the nearest
// pixel's (a mean of depths would stand in empty space).
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
    uint y = gl_WorkGroupID.x;
    uint fromWidth = constants.fromWidth, width = constants.toWidth;
    uint firstRow = firstPixel(y, constants.fromHeight, constants.toHeight);
    uint lastRow = lastPixel(y, constants.fromHeight, constants.toHeight);
    uint nearestRow = nearestPixel(y, constants.fromHeight, constants.toHeight) * fromWidth;
    for (uint x = gl_LocalInvocationID.x; x < width; x += gl_WorkGroupSize.x) {
        uint nearestPlace = nearestRow + nearestPixel(x, fromWidth, width);
        uint nearest = colourAt(nearestPlace), kind = kindOf(nearest);
        uint first = firstPixel(x, fromWidth, width), last = lastPixel(x, fromWidth, width);
        // Those between the first and the last are covered whole.
        uint firstWeight = weightOf(first, x, fromWidth, width), lastWeight = weightOf(last, x, fromWidth, width);
        ColourSum sum = ColourSum(0u, 0u, 0u, 0u);
        for (uint row = firstRow; row <= lastRow; ++row) {
            uint rowWeight = weightOf(row, y, constants.fromHeight, constants.toHeight);
            for (uint column = first; column <= last; ++column) {
                uint pixel = colourAt(row * fromWidth + column);
                uint weight = column == first ? firstWeight : (column == last ? lastWeight : kWholeWeight);
                sum = addColour(sum, pixel, kindOf(pixel) == kind ? rowWeight * weight : 0u);
            }
        }
        colours[y * width + x] = meanColour(sum, nearest);
        depths[y * width + x] = texelFetch(fromDepths, int(nearestPlace)).x;
    }
}
