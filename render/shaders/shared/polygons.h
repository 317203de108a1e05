#ifndef RENDER_SHADERS_SHARED_POLYGONS_H
#define RENDER_SHADERS_SHARED_POLYGONS_H
// Ordinary polygons beside images: their light, and how they meet the z-buffer of the warps (Nyland et al. 1999,
// section 5: image-based and polygon rendering share a z-buffer).
//
// They are drawn by the device's own rasteriser into a picture of colours and of near / z, which is then merged with
// the keys of the warped samples. Merged, not drawn into them: the order of keys is pushed back for samples that were
// taken from afar (scene/preference.h), and a polygon must be compared with where they truly are.

#include "render/shaders/shared/srgb.h"
#include "render/shaders/shared/z_key.h"

SHARED_BEGIN

/// Nothing nearer to the eye is drawn, metres. Depth is kPolygonNear / z.
SHARED_CONSTANT float kPolygonNear = 0.01f;

struct PolygonConstants {
    mat4 clipFromMesh;
    vec4 upFromNormal; ///< its dot product with a vertex's normal says how much of it faces up, -1 to 1, times length
    vec4 colour;       ///< of the material, linear; and below which alpha there is no surface
};

struct PolygonMergeConstants {
    int width;   ///< pixels; a workgroup merges one row
    int samples; ///< of a pixel
};

#ifdef __cplusplus
static_assert(sizeof(PolygonConstants) == 96 && sizeof(PolygonMergeConstants) == 8);
#endif

/// Light of an even sky: the same from everywhere, and for both eyes. facingUp: -1 to 1.
SHARED_FUNCTION float skyLight(float facingUp) {
    return 0.725f + 0.275f * facingUp;
}

/// Whether a polygon stands before what stands in the pixel. depth: near / z, 0 where there is no polygon.
SHARED_FUNCTION bool isPolygonBefore(uvec2 key, float depth) {
    PRECISE float disparity = depth / kPolygonNear;
    return disparity > 0.0f && ((key.x & 3u) == kClassBackground || eyeDisparityOf(key) < disparity);
}

/// What a pixel of the z-buffer becomes where a polygon stands before it; else it stays. colour: r | g << 8 | b << 16.
/// What was not measured is of class filled.
SHARED_FUNCTION uvec2 mergedKey(uvec2 key, float depth, uint colour) {
    PRECISE float disparity = depth / kPolygonNear;
    return isPolygonBefore(key, depth) ? packKey(disparity, colour, kClassFilled) : key;
}

/// A pixel of several samples, of which `before` show polygons before what stands there, at depth by their mean.
/// Colours (r, g, b of 255) are mixed by how many, depth and class are of what most of them show. polygons: the sum of
/// their colours. With emptiness nothing can be mixed.
SHARED_FUNCTION uvec2 mergedEdge(uvec2 key, int samples, int before, float depth, vec3 polygons) {
    bool isEmpty = (key.x & 3u) == kClassBackground;
    bool isPolygon = 2 * before >= samples;
    if (before == 0 || (isEmpty && !isPolygon)) return key;
    vec3 behind = vec3(float((key.x >> 8) & 255u), float((key.x >> 16) & 255u), float(key.x >> 24));
    vec3 mean = isEmpty ? polygons / float(before) : (polygons + float(samples - before) * behind) / float(samples);
    uint colour = uint(mean.x + 0.5f) | (uint(mean.y + 0.5f) << 8) | (uint(mean.z + 0.5f) << 16);
    if (isPolygon) return packKey(depth / kPolygonNear, colour, kClassFilled);
    return uvec2((colour << 8) | (key.x & 255u), key.y & ~kPlaceMask); // no neighbour has a share of the mixture
}

SHARED_END

#endif
