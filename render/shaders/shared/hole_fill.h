#ifndef RENDER_SHADERS_SHARED_HOLE_FILL_H
#define RENDER_SHADERS_SHARED_HOLE_FILL_H
// What stands in a pixel that no sample reached: of two opposite neighbours that belong to one surface, what lies
// between them. The mask is that of the hierarchical image-based objects (section 4.2, figure 5 and equation 5):
//
//     1 2 3     The pixel 0 is a hole if 1 = 8 or 2 = 7 or 3 = 6 or 4 = 5, where a = b says that both are there and
//     4 0 5     alike in colour and depth. That is radius 1.
//     6 7 8
//
// For wider gaps the same question is asked along eight axes, each followed both ways up to `radius` pixels until
// something is met:
//
//      near surface    gap    far surface         A gap beside a silhouette has ends of different depth: it hides what
//     ##############.........                     nobody saw, and stays a hole. Disparity is affine on a plane's
//                            ==============       picture, so that two ends lie on one surface if they are alike, or
//                                                 if each one's slope leads to the other.
//
// A hole at the picture's rim, one side of which is not known, shows what stands beside it (filledAtRim).
//
// A pixel reads its neighbours' keys and writes none, so that what is filled does not depend on any order, and what
// was filled fills nothing more.

#include "render/shaders/shared/language.h"
#include "render/shaders/shared/sample_place.h"
#include "render/shaders/shared/z_key.h"

SHARED_BEGIN

// The z-buffer is lent: GLSL's functions call keyAt, which the shader defines; those of C++ are given it. It answers
// (0, 0) outside the picture.
#ifdef __cplusplus
#define HOLE_FUNCTION                                                                                                  \
    template <class KeyAt>                                                                                             \
    inline
#define HOLE_KEYS const KeyAt &keyAt,
#define HOLE_LENT keyAt,
#else
uvec2 keyAt(ivec2 pixel);
#define HOLE_FUNCTION
#define HOLE_KEYS
#define HOLE_LENT
#endif

/// Knobs of the hole filler (std430).
struct HoleFill {
    int radius;         ///< pixels, up to kMostHoleRadius; 0: nothing is filled
    float sameSurface;  ///< relative difference in disparity up to which two ends are of one surface
    int sameColour;     ///< greatest difference of a channel, of 255, between two ends
    float pinholeDepth; ///< a pixel farther than its neighbours by this share of its disparity is a pinhole; 0: never
#ifdef __cplusplus
    friend bool operator==(const HoleFill&, const HoleFill&) = default;
#endif
};

struct ResolveConstants {
    int width; ///< pixels
    int height;
    HoleFill fill;
    PlaceSteps places; ///< of the samples in the z-buffer, where those are used or kept; else 0
};

#ifdef __cplusplus
static_assert(sizeof(HoleFill) == 16 && sizeof(ResolveConstants) == 32);
#endif

SHARED_CONSTANT int kHoleAxes = 8, kMaskAxes = 4;
SHARED_CONSTANT int kMostHoleRadius = 16; ///< pixels; words of 32 are looked at with those beside them alone

/// The first four are the mask's.
SHARED_FUNCTION ivec2 holeAxis(int axis) {
    int turn = axis & 3;
    ivec2 step = turn == 0 ? ivec2(1, 0) : turn == 1 ? ivec2(0, 1) : turn == 2 ? ivec2(1, 1) : ivec2(1, -1);
    if (axis < 4) return step;
    return turn == 0 ? ivec2(2, 1) : turn == 1 ? ivec2(1, 2) : turn == 2 ? ivec2(2, -1) : ivec2(1, -2);
}

SHARED_FUNCTION bool isHole(uvec2 key) {
    return (key.x & 3u) == kClassBackground;
}

/// What is met on the way out of a hole.
struct HoleEnd {
    int steps;       ///< along the axis; 0: nothing within reach
    float disparity; ///< 1/m
    float slope;     ///< of disparity, per step outwards
    bool hasSlope;
    uint colour;
};

SHARED_FUNCTION HoleEnd endAt(uvec2 key, int steps) {
    HoleEnd end;
    end.steps = isHole(key) ? 0 : steps;
    end.disparity = eyeDisparityOf(key);
    end.slope = 0.0f;
    end.hasSlope = false;
    end.colour = key.x >> 8;
    return end;
}

HOLE_FUNCTION HoleEnd findEnd(HOLE_KEYS ivec2 hole, ivec2 step, int reach) {
    uvec2 key = uvec2(0u, 0u);
    int k = 1;
    for (; k <= reach; ++k) {
        key = keyAt(hole + k * step);
        if (!isHole(key)) break;
    }
    HoleEnd end = endAt(key, k);
    uvec2 beyond = keyAt(hole + (k + 1) * step);
    end.hasSlope = !isHole(beyond);
    end.slope = eyeDisparityOf(beyond) - end.disparity;
    return end;
}

/// Greatest difference of a channel of two colours r | g << 8 | b << 16.
SHARED_FUNCTION int colourDistance(uint a, uint b) {
    int red = abs(int(a & 255u) - int(b & 255u));
    int green = abs(int((a >> 8) & 255u) - int((b >> 8) & 255u));
    int blue = abs(int((a >> 16) & 255u) - int((b >> 16) & 255u));
    return max(max(red, green), blue);
}

/// Two ends met in opposite directions.
SHARED_FUNCTION bool isOneSurface(HoleEnd a, HoleEnd b, HoleFill fill) {
    if (a.steps == 0 || b.steps == 0 || colourDistance(a.colour, b.colour) > fill.sameColour) return false;
    float tolerance = fill.sameSurface * max(a.disparity, b.disparity);
    if (abs(a.disparity - b.disparity) <= tolerance) return true;
    if (!a.hasSlope || !b.hasSlope) return false;
    float apart = float(a.steps + b.steps);
    PRECISE float atB = a.disparity - apart * a.slope;
    PRECISE float atA = b.disparity - apart * b.slope;
    return abs(atB - b.disparity) <= tolerance && abs(atA - a.disparity) <= tolerance;
}

/// A surface found across a hole: sums over the pairs of ends that agree on it.
struct HoleSurface {
    float weight;
    float disparity; ///< times weight
    vec3 colour;     ///< times weight, channels 0 to 255
    int pairs;
};

SHARED_FUNCTION HoleSurface noSurface() {
    HoleSurface none;
    none.weight = 0.0f;
    none.disparity = 0.0f;
    none.colour = vec3(0.0f, 0.0f, 0.0f);
    none.pairs = 0;
    return none;
}

SHARED_FUNCTION vec3 channelsOf(uint colour) {
    return vec3(float(int(colour & 255u)), float(int((colour >> 8) & 255u)), float(int((colour >> 16) & 255u)));
}

/// Adds a pair: what is affine between its ends, weighing less the farther they are apart. A surface behind the one
/// found so far takes its place, one before it is left out: what a gap shows is what lies farthest.
SHARED_FUNCTION HoleSurface withPair(HoleSurface surface, HoleEnd a, HoleEnd b, ivec2 step, HoleFill fill) {
    float apart = float(a.steps + b.steps);
    PRECISE float shareB = float(a.steps) / apart;
    PRECISE float disparity = a.disparity + shareB * (b.disparity - a.disparity);
    PRECISE float weight = 1.0f / (apart * apart * float(step.x * step.x + step.y * step.y));
    if (surface.pairs > 0) {
        PRECISE float soFar = surface.disparity / surface.weight;
        float tolerance = 2.0f * fill.sameSurface * max(soFar, disparity);
        if (disparity > soFar + tolerance) return surface;
        if (disparity < soFar - tolerance) surface = noSurface();
    }
    vec3 colourA = channelsOf(a.colour), colourB = channelsOf(b.colour);
    PRECISE vec3 colour = colourA + shareB * (colourB - colourA);
    PRECISE float disparitySum = surface.disparity + weight * disparity;
    PRECISE vec3 colourSum = surface.colour + weight * colour;
    surface.weight += weight;
    surface.disparity = disparitySum;
    surface.colour = colourSum;
    ++surface.pairs;
    return surface;
}

/// A key of class filled; order level 0.
SHARED_FUNCTION uvec2 keyOf(HoleSurface surface) {
    PRECISE vec3 mean = surface.colour / surface.weight + vec3(0.5f, 0.5f, 0.5f);
    vec3 channels = clamp(mean, vec3(0.0f, 0.0f, 0.0f), vec3(255.0f, 255.0f, 255.0f));
    uint colour = uint(int(channels.x)) | (uint(int(channels.y)) << 8) | (uint(int(channels.z)) << 16);
    PRECISE float disparity = surface.disparity / surface.weight;
    return packKey(disparity, colour, kClassFilled);
}

/// Of the mask's four pairs, how many must stand before a pixel that is no hole. A crack runs along one of them, and
/// where it goes on beside itself along two.
SHARED_CONSTANT int kPairsAcrossCrack = 2;

/// The mask; only ends nearer than `nearer` count.
HOLE_FUNCTION HoleSurface surfaceByMask(HOLE_KEYS ivec2 pixel, float nearer, HoleFill fill) {
    HoleSurface surface = noSurface();
    for (int axis = 0; axis < kMaskAxes; ++axis) {
        ivec2 step = holeAxis(axis);
        HoleEnd a = endAt(keyAt(pixel + step), 1), b = endAt(keyAt(pixel - step), 1);
        if (min(a.disparity, b.disparity) > nearer && isOneSurface(a, b, fill))
            surface = withPair(surface, a, b, step, fill);
    }
    return surface;
}

/// Farther than the mask, along all axes.
HOLE_FUNCTION HoleSurface surfaceAround(HOLE_KEYS ivec2 hole, bool asks, HoleFill fill) {
    HoleSurface surface = noSurface();
    // As the end of a loop, not a branch: processors draw several pixels at once, and only loops are left early.
    int axes = asks ? kHoleAxes : 0;
    for (int axis = 0; axis < axes; ++axis) {
        ivec2 step = holeAxis(axis);
        int reach = axis < kMaskAxes ? fill.radius : fill.radius / 2;
        HoleEnd a = findEnd(HOLE_LENT hole, step, reach);
        if (a.steps == 0) continue;
        HoleEnd b = findEnd(HOLE_LENT hole, -step, reach);
        if (isOneSurface(a, b, fill)) surface = withPair(surface, a, b, step, fill);
    }
    return surface;
}

/// Only what is nearer than this may fill a pixel: of a hole, anything.
SHARED_FUNCTION float nearerThan(uvec2 own, HoleFill fill) {
    PRECISE float pushed = eyeDisparityOf(own) * (1.0f + fill.pinholeDepth);
    return isHole(own) ? -1.0f : pushed;
}

/// Whether a pixel that is no hole may be seen through a crack. What a crack shows is farther than what stands on both
/// sides of it; along whichever axis it runs, the pixel to the left or the one above is no part of it.
SHARED_FUNCTION bool isPinhole(uvec2 own, uvec2 left, uvec2 above, HoleFill fill) {
    float nearest = max(eyeDisparityOf(left), eyeDisparityOf(above));
    return !isHole(own) && fill.pinholeDepth > 0.0f && nearest > nearerThan(own, fill);
}

/// What a hole or pinhole shows whose key is `own`: what it is filled with, if anything, else itself.
HOLE_FUNCTION uvec2 filled(HOLE_KEYS ivec2 pixel, uvec2 own, HoleFill fill) {
    bool hole = isHole(own);
    HoleSurface surface = surfaceByMask(HOLE_LENT pixel, nearerThan(own, fill), fill);
    if (surface.pairs >= (hole ? 1 : kPairsAcrossCrack)) return keyOf(surface);
    surface = surfaceAround(HOLE_LENT pixel, hole && fill.radius > 1, fill);
    if (surface.pairs > 0) return keyOf(surface);
    return own;
}

/// A hole at the picture's rim has no neighbours on one side: without this every crack that the rim cuts would be left
/// open there. It shows what stands right beside it, inwards.
HOLE_FUNCTION uvec2 filledAtRim(HOLE_KEYS ivec2 pixel, ivec2 size, uvec2 own) {
    ivec2 inwards = ivec2(max(min(pixel.x, size.x - 2), 1), max(min(pixel.y, size.y - 2), 1));
    uvec2 key = keyAt(inwards);
    if (!isHole(own) || inwards == pixel || isHole(key)) return own;
    return packKey(eyeDisparityOf(key), key.x >> 8, kClassFilled);
}

SHARED_END

#endif
