#ifndef RENDER_SHADERS_SHARED_SAMPLE_PLACE_H
#define RENDER_SHADERS_SHARED_SAMPLE_PLACE_H
// Where in its pixel the sample stands that a pixel of the z-buffer shows (see PlaceSteps: how finely): keys tell, and
// so may pictures that are yet to be enlarged. between_samples.h makes colours of it.

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

/// Where a picture is yet to be enlarged, its pixels keep their samples' places in the bits above their class.
SHARED_FUNCTION uint placeKept(uvec2 key) {
    return (key.y & kNotDisparity) << kPlaceShift;
}
SHARED_FUNCTION ivec2 placeInPixel(uint pixel, PlaceSteps steps) {
    return placeOf(uvec2(0u, pixel >> kPlaceShift), steps);
}

SHARED_END

#endif
