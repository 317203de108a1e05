#ifndef RENDER_SHADERS_SHARED_BETWEEN_SAMPLES_H
#define RENDER_SHADERS_SHARED_BETWEEN_SAMPLES_H
// The colour of a pixel of four samples that it lies between, by where they stand (sample_place.h): linear along two
// rows of them and from row to row. That is offset reconstruction (Popescu, Eyles, Lastra, Steinhurst, England, Nyland:
// "The WarpEngine: An Architecture for the Post-Polygonal Age", SIGGRAPH 2000): points and splats of one colour are
// seen where they stand, and not up to half a pixel beside it. Resolve makes a picture's own pixels so, and who
// enlarges a picture the new ones (rescale.h), whose centres lie elsewhere among the old ones.
//
// Shares are whole numbers, so that every device gives the same bytes. Class and depth are those of the nearest pixel.

#include "render/shaders/shared/language.h"
#include "render/shaders/shared/sample_place.h"
#include "render/shaders/shared/z_key.h"

SHARED_BEGIN

/// n / d, exactly, for quotients below 2^20: devices without whole-number division in their vectors (processors) take
/// a reciprocal, which is off by less than one, and put it right.
SHARED_FUNCTION uint quotient(uint n, uint d) {
    uint q = uint(float(n) / float(d));
    int rest = int(n - q * d);
    return rest < 0 ? q - 1u : (rest >= int(d) ? q + 1u : q);
}

/// Weighted colours.
struct ColourSum {
    uint r, g, b, weight;
};
SHARED_FUNCTION ColourSum addColour(ColourSum sum, uint pixel, uint weight) {
    sum.r += (pixel & 0xffu) * weight;
    sum.g += ((pixel >> 8) & 0xffu) * weight;
    sum.b += ((pixel >> 16) & 0xffu) * weight;
    sum.weight += weight;
    return sum;
}

/// The mean, rounded, with the class of the nearest pixel.
SHARED_FUNCTION uint meanColour(ColourSum sum, uint nearest) {
    uint rounding = sum.weight / 2u;
    return quotient(sum.r + rounding, sum.weight) | (quotient(sum.g + rounding, sum.weight) << 8) |
           (quotient(sum.b + rounding, sum.weight) << 16) | (classOfPixel(nearest) << 24);
}

/// How far samples are from the place whose colour is wanted is counted in 1 / kPerPixel of a pixel.
SHARED_CONSTANT int kPerPixel = 32;

/// To the sample of a pixel whose centre is so far away. place: placeOf.
SHARED_FUNCTION ivec2 sampleFrom(ivec2 centre, ivec2 place) {
    return centre + (kPerPixel / kEighths) * place;
}

/// The nearest pixel's neighbours whose samples are on the other side of the wanted place than its own.
SHARED_FUNCTION ivec2 wayAcross(ivec2 own) {
    return ivec2(own.x > 0 ? -1 : 1, own.y > 0 ? -1 : 1);
}

/// From the wanted place to four samples: of the nearest pixel, of that beside it, of that above or below it, and of
/// the one across.
struct FourSamples {
    ivec2 own, beside, over, across;
    bool takesBeside, takesOver, takesAcross; ///< whether they may be mixed with own
};
struct FourShares {
    uint own, beside, over, across;
};

/// Linear along the row of own and beside, along that of over and across, and between the two places that the rows
/// make: near what a plane through them would say, where rows lie level and have a sample on each side exactly that.
/// The sum of the shares is below 2^22, that of own above 0; where own is in the wanted place it has all of them.
SHARED_FUNCTION FourShares sharesOf(FourSamples at) {
    // Each sample counts by how far the other one is, the farther along either axis; by a step more, lest both be here.
    int besideFar = max(abs(at.beside.x), abs(at.beside.y - at.own.y)) + 1;
    int overFar = max(abs(at.over.x), abs(at.over.y - at.across.y));
    int acrossFar = max(abs(at.across.x), abs(at.across.y - at.over.y)) + 1;
    int own = at.takesBeside ? besideFar : 1, beside = at.takesBeside ? abs(at.own.x) : 0;
    int over = !at.takesOver ? 0 : (at.takesAcross ? acrossFar : 1);
    int across = !at.takesAcross ? 0 : (at.takesOver ? overFar : 1);
    // Of the two places that the rows make, too, each counts by how far above or below the other one is; as these are
    // means by a row's shares, so are they times their sum.
    int otherRow = over + across;
    int ownHigh = abs(own * at.own.y + beside * at.beside.y), otherHigh = abs(over * at.over.y + across * at.across.y);
    int ofOwnRow = otherRow == 0 ? 1 : otherHigh + otherRow, ofOtherRow = ownHigh;
    FourShares shares;
    shares.own = uint(own * ofOwnRow);
    shares.beside = uint(beside * ofOwnRow);
    shares.over = uint(over * ofOtherRow);
    shares.across = uint(across * ofOtherRow);
    return shares;
}

/// Pixels r | g << 8 | b << 16 | class << 24, and whatever stands above.
SHARED_FUNCTION uint mixed(FourSamples at, uint own, uint beside, uint over, uint across) {
    FourShares shares = sharesOf(at);
    ColourSum sum;
    sum.r = sum.g = sum.b = sum.weight = 0u;
    sum = addColour(sum, own, shares.own);
    sum = addColour(sum, beside, shares.beside);
    sum = addColour(sum, over, shares.over);
    return meanColour(addColour(sum, across, shares.across), own);
}

/// What has less than this share of a pixel's disparity may be seen through a crack beside it (HoleFill::pinholeDepth):
/// it is not mixed with what stands before it. Rims are, with what stands behind them, as in a photograph.
SHARED_CONSTANT float kLeastMixed = 0.95f;

/// 63 times the eye's disparity, 1/m.
SHARED_FUNCTION float nearnessOf(uvec2 key) {
    PRECISE float ofLevel = uintBitsToFloat(key.y & ~kNotDisparity) * float(63 + int((key.x >> 2) & 63u));
    PRECISE float ofRim = ofLevel * kPerRimShare;
    return (key.y & 1u) != 0u ? ofRim : ofLevel;
}

/// Whether a neighbour's sample may be mixed with a pixel's own: what was measured with nothing else.
SHARED_FUNCTION bool isMixedWith(uvec2 key, uvec2 own) {
    PRECISE float farthest = nearnessOf(own) * kLeastMixed;
    return ((key.x ^ own.x) & 3u) == 0u && nearnessOf(key) >= farthest;
}

/// What the samples about a pixel's centre make of it: of the one it shows and of its neighbours' that way (wayAcross).
/// r | g << 8 | b << 16 | class << 24.
SHARED_FUNCTION uint interpolatedColour(uvec2 own, uvec2 beside, uvec2 over, uvec2 across, ivec2 way,
                                        PlaceSteps steps) {
    ivec2 step = kPerPixel * way;
    FourSamples at;
    at.own = sampleFrom(ivec2(0, 0), placeOf(own, steps));
    at.beside = sampleFrom(ivec2(step.x, 0), placeOf(beside, steps));
    at.over = sampleFrom(ivec2(0, step.y), placeOf(over, steps));
    at.across = sampleFrom(step, placeOf(across, steps));
    at.takesBeside = isMixedWith(beside, own);
    at.takesOver = isMixedWith(over, own);
    at.takesAcross = isMixedWith(across, own);
    return mixed(at, colourAndClassOf(own), colourAndClassOf(beside), colourAndClassOf(over), colourAndClassOf(across));
}

SHARED_END

#endif
