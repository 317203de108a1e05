#ifndef RENDER_SHADERS_SHARED_SAMPLE_PLACE_H
#define RENDER_SHADERS_SHARED_SAMPLE_PLACE_H
// Where in its pixel the sample stands that a pixel of the z-buffer shows (see PlaceSteps: how finely), and the colour
// that is made of it and of those beside, above and below: their mean, weighted by how near they stand to the pixel's
// centre. This is offset reconstruction (Popescu, Eyles, Lastra, Steinhurst, England, Nyland: "The WarpEngine: An
// Architecture for the Post-Polygonal Age", SIGGRAPH 2000): points and splats of one colour are seen where they stand,
// and not up to half a pixel beside it. What stands behind is mixed with rims before it, as in a photograph, but not
// these with it: it may be seen through a crack. Class and depth are those of the pixel's own sample, and what was
// measured is mixed with nothing else.

#include "render/shaders/shared/language.h"
#include "render/shaders/shared/z_key.h"

SHARED_BEGIN

/// Places are counted in steps along both axes, from -kMostPlaceSteps to that. Steps are eighths of a pixel: of what
/// stands in the pixel, and of what covers it from beside.
SHARED_CONSTANT int kMostPlaceSteps = 2, kEighths = 8;
struct PlaceSteps {
    int own;
    int rim;
};
/// A point stands in its pixel, or at its rim up to a pixel or more away; the least splats up to 0.71 of a pixel away.
SHARED_FUNCTION PlaceSteps placeStepsOfPoints() {
    PlaceSteps steps;
    steps.own = 2;
    steps.rim = 4;
    return steps;
}
SHARED_FUNCTION PlaceSteps placeStepsOfSplats() {
    PlaceSteps steps;
    steps.own = 3;
    steps.rim = 3;
    return steps;
}

/// From a sample's place, or a splat's centre, to that of a pixel.
SHARED_FUNCTION vec2 offsetOfPixel(ivec2 pixel, vec2 centre) {
    PRECISE vec2 offset = vec2(float(pixel.x), float(pixel.y)) + vec2(0.5f, 0.5f) - centre;
    return offset;
}

/// For withPlace. offset: from the sample to the pixel's centre, pixels. perPixel: steps.
SHARED_FUNCTION uint placeCode(vec2 offset, float perPixel) {
    PRECISE vec2 place = vec2(floor(0.5f - offset.x * perPixel), floor(0.5f - offset.y * perPixel));
    float most = float(kMostPlaceSteps);
    int x = int(clamp(place.x, -most, most)), y = int(clamp(place.y, -most, most));
    return uint((x < 0 ? x + 5 : x) * 5 + (y < 0 ? y + 5 : y)); // the middle is 0
}

SHARED_FUNCTION float perPixelOf(int step) {
    return float(kEighths) / float(step);
}

/// The key of a point's own pixel; of any that it covers.
SHARED_FUNCTION uvec2 keyWherePointStands(float orderDisparity, uint colour, uint levelAndClass, vec2 offset) {
    uint code = placeCode(offset, perPixelOf(placeStepsOfPoints().own));
    return withPlace(packKey(orderDisparity, colour, levelAndClass), code);
}
SHARED_FUNCTION uvec2 keyOfPoint(float orderDisparity, uint colour, uint levelAndClass, ivec2 pixel, vec2 point) {
    vec2 offset = offsetOfPixel(pixel, point);
    uint code = placeCode(offset, perPixelOf(placeStepsOfPoints().rim));
    bool isOwn = pixel.x == int(floor(point.x)) && pixel.y == int(floor(point.y));
    return isOwn ? keyWherePointStands(orderDisparity, colour, levelAndClass, offset)
                 : withPlace(packRim(orderDisparity, colour, levelAndClass), code);
}

/// From the pixel's centre to the sample, eighths of a pixel.
SHARED_FUNCTION ivec2 placeOf(uvec2 key, PlaceSteps steps) {
    int code = int((key.y & kPlaceMask) >> 1), x = (code * 13) >> 6, y = code - 5 * x;
    int step = (key.y & 1u) != 0u ? steps.rim : steps.own;
    return ivec2((x > kMostPlaceSteps ? x - 5 : x) * step, (y > kMostPlaceSteps ? y - 5 : y) * step);
}

/// What has less than this share of a pixel's disparity may be seen through a crack beside it (HoleFill::pinholeDepth).
SHARED_CONSTANT float kLeastMixed = 0.95f;

/// What a pixel shows, ready to be mixed with its neighbours.
struct PlacedSample {
    uint pixelClass;
    float nearness; ///< 63 times the eye's disparity, 1/m
    vec2 place;     ///< from the pixel's centre to the sample, pixels
    vec3 colour;    ///< r, g, b, 0 to 255
};

SHARED_FUNCTION PlacedSample placedSampleOf(uvec2 key, PlaceSteps steps) {
    ivec2 place = placeOf(key, steps);
    PlacedSample placed;
    placed.pixelClass = key.x & 3u;
    PRECISE float ofLevel = uintBitsToFloat(key.y & ~kNotDisparity) * float(63 + int((key.x >> 2) & 63u));
    PRECISE float ofRim = ofLevel * kPerRimShare;
    placed.nearness = (key.y & 1u) != 0u ? ofRim : ofLevel;
    placed.place = vec2(float(place.x), float(place.y)) * (1.0f / float(kEighths));
    placed.colour = vec3(float(int((key.x >> 8) & 255u)), float(int((key.x >> 16) & 255u)), float(int(key.x >> 24)));
    return placed;
}

/// Weighted colours of some samples. Weights are whole 64ths, so that sums are exact, whatever their order.
struct PlacedSum {
    vec3 colour;
    float weight;
};

/// Shares fall off linearly along both axes, from 1 at a pixel's centre to 0 at the next one's.
SHARED_FUNCTION float shareOfPixel(vec2 place) {
    return (1.0f - abs(place.x)) * (1.0f - abs(place.y));
}
SHARED_FUNCTION float shareOfLeft(vec2 place) {
    return max(-place.x, 0.0f) * (1.0f - abs(place.y));
}
SHARED_FUNCTION float shareOfRight(vec2 place) {
    return max(place.x, 0.0f) * (1.0f - abs(place.y));
}
SHARED_FUNCTION float shareOfAbove(vec2 place) {
    return max(-place.y, 0.0f) * (1.0f - abs(place.x));
}
SHARED_FUNCTION float shareOfBelow(vec2 place) {
    return max(place.y, 0.0f) * (1.0f - abs(place.x));
}

/// Of the pixel's own sample alone. It may stand so far from the centre as to have no share: it has the least.
SHARED_FUNCTION PlacedSum sumOf(PlacedSample own) {
    PlacedSum sum;
    sum.weight = shareOfPixel(own.place) + 1.0f / 64.0f;
    sum.colour = own.colour * sum.weight;
    return sum;
}

/// With a sample that has a share of the pixel that shows own; what is of another class or stands behind has none.
SHARED_FUNCTION PlacedSum withSample(PlacedSum sum, PlacedSample placed, float share, PlacedSample own) {
    PRECISE float farthest = own.nearness * kLeastMixed;
    float weight = placed.pixelClass == own.pixelClass && placed.nearness >= farthest ? share : 0.0f;
    sum.colour += weight * placed.colour;
    sum.weight += weight;
    return sum;
}

/// r | g << 8 | b << 16, rounded.
SHARED_FUNCTION uint meanOf(PlacedSum sum) {
    PRECISE float perWeight = 1.0f / sum.weight;
    PRECISE vec3 mean = sum.colour * perWeight + vec3(0.5f, 0.5f, 0.5f);
    return uint(int(mean.x)) | (uint(int(mean.y)) << 8) | (uint(int(mean.z)) << 16);
}

/// What the samples about a pixel's centre make of it: of the one it shows and of those that are shown to its left and
/// right, above and below. r | g << 8 | b << 16.
SHARED_FUNCTION uint interpolatedColour(PlacedSample own, PlacedSample left, PlacedSample right, PlacedSample above,
                                        PlacedSample below) {
    PlacedSum sum = sumOf(own);
    sum = withSample(sum, left, shareOfRight(left.place), own);
    sum = withSample(sum, right, shareOfLeft(right.place), own);
    sum = withSample(sum, above, shareOfBelow(above.place), own);
    sum = withSample(sum, below, shareOfAbove(below.place), own);
    return meanOf(sum);
}

SHARED_END

#endif
