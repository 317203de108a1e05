#version 460
// What rescale.comp makes of a picture that is no larger than the eye's: each pixel lies between two old ones along each
// axis, or between their samples. A workgroup makes a band of rows, so that where a column lies is worked out once for
// all of them.
#extension GL_GOOGLE_include_directive : require

#include "render/shaders/shared/rescale.h"

layout(local_size_x_id = 0) in;
layout(constant_id = 1) const bool BY_PLACES = false;

layout(set = 0, binding = 0) uniform usamplerBuffer fromColours;
layout(set = 0, binding = 1) uniform samplerBuffer fromDepths;
layout(std430, set = 0, binding = 2) writeonly buffer Colours { uint colours[]; };
layout(std430, set = 0, binding = 3) writeonly buffer Depths { float depths[]; };
layout(push_constant) uniform Constants { RescaleConstants constants; };

uint colourAt(uint place)
{
    return texelFetch(fromColours, int(place)).x;
}

ColourSum withPixel(ColourSum sum, uint pixel, uint weight, uint kind)
{
    return addColour(sum, pixel, kindOf(pixel) == kind ? weight : 0u);
}

/// Of the four old pixels that the new one's centre lies between, by their centres.
ColourSum sumByCentres(Between row, Between column, uint kind)
{
    uint fromWidth = constants.fromWidth, above = row.first * fromWidth, below = row.last * fromWidth;
    uint aboveWeight = kWholeWeight - row.lastWeight, leftWeight = kWholeWeight - column.lastWeight;
    ColourSum sum = ColourSum(0u, 0u, 0u, 0u);
    sum = withPixel(sum, colourAt(above + column.first), aboveWeight * leftWeight, kind);
    sum = withPixel(sum, colourAt(above + column.last), aboveWeight * column.lastWeight, kind);
    sum = withPixel(sum, colourAt(below + column.first), row.lastWeight * leftWeight, kind);
    return withPixel(sum, colourAt(below + column.last), row.lastWeight * column.lastWeight, kind);
}

/// Of the nearest one and of those three that the new one's centre lies between, by where their samples are. As by
/// centres, silhouettes are mixed with what stands behind them, since old pixels are large, and what is filled with what
/// was measured. centre: from the new one's.
uint colourByPlaces(uvec2 at, ivec2 centre, uint nearest, uint kind)
{
    PlaceSteps places = constants.places;
    FourSamples samples;
    samples.own = sampleFrom(centre, placeInPixel(nearest, places));
    ivec2 way = wayAcross(samples.own), side = kPerPixel * way;
    uint x = uint(clamp(int(at.x) + way.x, 0, int(constants.fromWidth) - 1));
    uint y = uint(clamp(int(at.y) + way.y, 0, int(constants.fromHeight) - 1));
    uint ownRow = at.y * constants.fromWidth, otherRow = y * constants.fromWidth;
    uint beside = colourAt(ownRow + x), over = colourAt(otherRow + at.x), across = colourAt(otherRow + x);
    samples.beside = sampleFrom(centre + ivec2(side.x, 0), placeInPixel(beside, places));
    samples.over = sampleFrom(centre + ivec2(0, side.y), placeInPixel(over, places));
    samples.across = sampleFrom(centre + side, placeInPixel(across, places));
    samples.takesBeside = kindOf(beside) == kind;
    samples.takesOver = kindOf(over) == kind;
    samples.takesAcross = kindOf(across) == kind;
    return mixed(samples, nearest, beside, over, across);
}

void main()
{
    uint fromWidth = constants.fromWidth, width = constants.toWidth;
    uint firstRow = gl_WorkGroupID.x * kEnlargedRows;
    uint endRow = min(firstRow + kEnlargedRows, constants.toHeight);
    for (uint x = gl_LocalInvocationID.x; x < width; x += gl_WorkGroupSize.x) {
        Between column = betweenOf(x, fromWidth, width);
        uint atX = column.isNearLast != 0u ? column.last : column.first;
        int centreX = nearestCentre(x, atX, fromWidth, width);
        for (uint y = firstRow; y < endRow; ++y) {
            Between row = betweenOf(y, constants.fromHeight, constants.toHeight);
            uvec2 at = uvec2(atX, row.isNearLast != 0u ? row.last : row.first);
            uint place = y * width + x, nearestPlace = at.y * fromWidth + at.x;
            uint nearest = colourAt(nearestPlace), kind = kindOf(nearest);
            ivec2 centre = ivec2(centreX, nearestCentre(y, at.y, constants.fromHeight, constants.toHeight));
            colours[place] = BY_PLACES ? colourByPlaces(at, centre, nearest, kind)
                                       : meanColour(sumByCentres(row, column, kind), nearest);
            depths[place] = texelFetch(fromDepths, int(nearestPlace)).x;
        }
    }
}
