#ifndef RENDER_SHADERS_SHARED_OCCLUSION_H
#define RENDER_SHADERS_SHARED_OCCLUSION_H
// Which tiles cannot change the picture any more: those that lie, with all their samples, behind what stands at every
// pixel they may touch. Exact, so that a picture is the same to the byte with and without it.
//
// The z-buffer is divided into blocks, each with the least order disparity of its pixels (z_key.h): nothing whose
// order disparity is below that is seen there.

#include "render/shaders/shared/tile_draw.h"

SHARED_BEGIN

SHARED_CONSTANT int kOccluderSide = 8; ///< pixels

/// Blocks looked at for one tile at most: what covers more of the picture is near, and drawn.
SHARED_CONSTANT int kMostOccluders = 256;

struct OccluderConstants {
    int width; ///< of the eye's image, pixels
    int height;
};

struct OcclusionConstants {
    uint firstDraw;
    uint count;
    int width;
    int height;
};

/// How many draws of a run have passed, as an indirect dispatch wants it, and where they go.
struct PassedRun {
    uint x;
    uint y;
    uint z;
    uint firstAndKind; ///< first draw | kSplatRun
};
SHARED_CONSTANT uint kSplatRun = 0x80000000u; ///< span.x of its draws is a radius

SHARED_FUNCTION int occludersAlong(int pixels) {
    return (pixels + kOccluderSide - 1) / kOccluderSide;
}

/// What a tile may touch: blocks from first to last, none if last is before first; and the greatest order disparity of
/// its samples. Negative if that cannot be told, since the tile reaches behind the eye.
struct TileReach {
    ivec2 first;
    ivec2 last;
    float nearest;
};

SHARED_FUNCTION TileReach reachOf(TileDraw draw, bool isSplats, int width, int height) {
    TileReach reach;
    reach.first = ivec2(0);
    reach.last = ivec2(-1);
    reach.nearest = -1.0f;
    uint bits = placeBitsOf(draw);
    float right = float(int((draw.source.z >> 8) & 0xfffu) - 1), below = float(int(draw.source.z >> 20));
    float deep = float(int((1u << (32u - 2u * bits)) - 1u));
    vec2 least = vec2(3.0e38f), most = vec2(-3.0e38f);
    float nearest = 0.0f;
    for (int corner = 0; corner < 8; ++corner) {
        float x = (corner & 1) != 0 ? right : 0.0f, y = (corner & 2) != 0 ? below : 0.0f,
              q = (corner & 4) != 0 ? deep : 0.0f;
        vec4 h = draw.base + x * draw.perX + y * draw.perY + q * draw.perQ;
        if (!(h.z > 1e-6f)) return reach;
        vec2 seen = vec2(h.x / h.z, h.y / h.z);
        least = min(least, seen);
        most = max(most, seen);
        nearest = max(nearest, h.w / h.z);
    }
    // What is drawn of a sample reaches beyond its place; and a pixel more for what rounding may do.
    float beyond = (isSplats ? uintBitsToFloat(draw.span.x) : 0.5f * float(footprintOf(draw))) + 1.5f;
    float side = float(kOccluderSide);
    least = clamp((least - beyond) / side, vec2(0.0f), vec2(float(width), float(height)) / side);
    most = clamp((most + beyond) / side, vec2(-1.0f), vec2(float(width - 1), float(height - 1)) / side);
    reach.first = ivec2(int(floor(least.x)), int(floor(least.y)));
    reach.last = ivec2(int(floor(most.x)), int(floor(most.y)));
    reach.nearest = nearest * 1.0001f;
    return reach;
}

SHARED_END

#endif
