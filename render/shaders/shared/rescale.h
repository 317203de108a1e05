#ifndef RENDER_SHADERS_SHARED_RESCALE_H
#define RENDER_SHADERS_SHARED_RESCALE_H
// A picture of one size becomes one of another. Along each axis a pixel of the new picture takes several of the old
// one, with whole-numbered weights, so that every device gives the same bytes: to a larger picture linearly between the
// two pixels about its centre, to a smaller one by the shares of its own width that they cover (a box filter, which is
// what supersampling wants).
//
// To a larger picture it may also be linear between the samples that the old pixels show, where those stand
// (between_samples.h), and not between the pixels' centres.
//
// New sizes up to 16384 and at most 4 old pixels along a new one: no sum leaves 32 bits.

#include "render/shaders/shared/between_samples.h"
#include "render/shaders/shared/language.h"
#include "render/shaders/shared/sample_place.h"

SHARED_BEGIN

struct RescaleConstants {
    uint fromWidth, fromHeight;
    uint toWidth, toHeight;
    PlaceSteps places; ///< of the samples in the old picture, where its pixels tell them
};

SHARED_CONSTANT uint kWholeWeight = 256u;

/// The old pixel in which the new one's centre lies.
SHARED_FUNCTION uint nearestPixel(uint i, uint from, uint to) {
    return quotient((2u * i + 1u) * from, 2u * to);
}

/// The new pixel's centre counted from the first old centre, in 1 / (2 to); negative before it.
SHARED_FUNCTION int centreOf(uint i, uint from, uint to) {
    return int((2u * i + 1u) * from) - int(to);
}

/// Old pixels first to last have a share in new pixel i.
SHARED_FUNCTION uint firstPixel(uint i, uint from, uint to) {
    if (from > to) return quotient(i * from, to);
    return quotient(uint(max(centreOf(i, from, to), 0)), 2u * to);
}
SHARED_FUNCTION uint lastPixel(uint i, uint from, uint to) {
    if (from > to) return quotient((i + 1u) * from - 1u, to);
    if (centreOf(i, from, to) <= 0) return 0u;
    return min(firstPixel(i, from, to) + 1u, from - 1u);
}

/// The share of old pixel p, one of those, in 1 / kWholeWeight; the nearest pixel's is never 0.
SHARED_FUNCTION uint weightOf(uint p, uint i, uint from, uint to) {
    if (from > to) {
        uint begin = max(i * from, p * to), end = min((i + 1u) * from, (p + 1u) * to);
        return quotient((end - begin) * kWholeWeight + to / 2u, to);
    }
    uint first = firstPixel(i, from, to), last = lastPixel(i, from, to);
    if (first == last) return kWholeWeight;
    uint second = quotient((uint(centreOf(i, from, to)) - first * 2u * to) * kWholeWeight + to, 2u * to);
    return p == first ? kWholeWeight - second : second;
}

/// Where to >= from: the old pixels that new pixel i lies between, the share of the last, and which is the nearest. The
/// same as the functions above say.
struct Between {
    uint first, last;
    uint lastWeight; ///< in 1 / kWholeWeight
    uint isNearLast; ///< 1: the last is the nearest, 0: the first
};
SHARED_FUNCTION Between betweenOf(uint i, uint from, uint to) {
    int centre = centreOf(i, from, to);
    uint beyond = uint(max(centre, 0));
    Between between;
    between.first = quotient(beyond, 2u * to);
    between.last = centre > 0 ? min(between.first + 1u, from - 1u) : between.first;
    uint rest = beyond - between.first * 2u * to;
    between.lastWeight = between.last > between.first ? quotient(rest * kWholeWeight + to, 2u * to) : 0u;
    between.isNearLast = between.last > between.first && rest >= to ? 1u : 0u;
    return between;
}

/// Rows of the new picture that one workgroup makes where to >= from.
SHARED_CONSTANT uint kEnlargedRows = 8u;

/// Where to >= from: from new pixel i's centre to that of the old pixel in which it lies, in 1 / kPerPixel of an old
/// one.
SHARED_FUNCTION int nearestCentre(uint i, uint nearest, uint from, uint to) {
    int halfPixel = kPerPixel / 2;
    uint beyond = (2u * nearest + 1u) * to + to - (2u * i + 1u) * from; // in 1 / (2 to), and half a pixel more
    return int(quotient(beyond * uint(halfPixel) + to / 2u, to)) - halfPixel;
}

/// Colours of which kinds may be mixed: what was measured with what was filled in, and nothing else. pixel: r | g << 8
/// | b << 16 | class << 24, and perhaps the sample's place above.
SHARED_FUNCTION uint kindOf(uint pixel) {
    uint pixelClass = classOfPixel(pixel);
    return pixelClass == 2u ? 1u : pixelClass;
}

SHARED_END

#endif
