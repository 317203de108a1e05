#ifndef RENDER_SHADERS_SHARED_DETAIL_H
#define RENDER_SHADERS_SHARED_DETAIL_H
// Levels of detail that change without popping: where one level passes into the next, a hash of the coarser sample says
// which of its two levels is drawn. It depends on the sample alone, so that both eyes and all frames agree.
//
// Images come and go the same way (scene/plan/walk_cells.h): a hash of the sample says whether it belongs to the share
// of its image's samples that is drawn.
//
// A sample of level L is drawn if its own level is wanted there and the next coarser one is not. How much a level is
// wanted rises with w = (depth in the eye) / (depth in the source): samples are seen as wide as 2^L r / w pixels, r
// being the ratio of focal lengths.

#include "render/shaders/shared/tile_draw.h"

SHARED_BEGIN

/// A level begins where its samples are as wide as is asked for, and is whole where they are narrower by this share.
SHARED_CONSTANT float kDetailBand = 0.25f;

/// A sample and the coarser one above it differ a little in w: each level reaches so much, as a share, into the other,
/// so that no hole can open between them.
SHARED_CONSTANT float kDetailOverlap = 0.02f;

/// In [0, 1).
SHARED_FUNCTION float hashOfSample(uint x, uint y, uint level, uint image) {
    uint h = (x * 0x8da6b343u) ^ (y * 0xd8163841u) ^ (level * 0xcb1ab31fu) ^ (image * 0x165667b1u);
    h = h ^ (h >> 15);
    h = h * 0x2c1b3c6du;
    h = h ^ (h >> 12);
    h = h * 0x297a2d39u;
    h = h ^ (h >> 15);
    return float(int(h >> 8)) / 16777216.0f;
}

/// How much a level is wanted whose samples are as wide as is asked for at measure 1, and half as wide at 2.
SHARED_FUNCTION float shareOfLevel(float measure) {
    PRECISE float share = (measure - 1.0f) * (1.0f / kDetailBand);
    return clamp(share, 0.0f, 1.0f);
}

/// Whether isOfDetail says yes to some of a draw's samples only.
SHARED_FUNCTION bool isByDetail(TileDraw draw) {
    return draw.detail.x != 0.0f || draw.source.w >= kMostImages;
}

/// So that what an image's share and its levels leave out are not the same samples.
SHARED_CONSTANT uint kShareSalt = 128u;

/// What decides by chance: by the share of the image; by the sample's own level; by the next coarser one. Alike for
/// both eyes.
SHARED_FUNCTION vec3 chancesOf(TileDraw draw, uint x, uint y) {
    uint imageX = draw.source.x + x, imageY = draw.source.y + y, level = draw.source.z & 255u, image = imageOf(draw);
    return vec3(hashOfSample(imageX, imageY, level + kShareSalt, image), hashOfSample(imageX, imageY, level, image),
                hashOfSample(imageX >> 1, imageY >> 1, level + 1u, image));
}

/// Whether the sample (x, y), counted from its tile's first, is drawn at this w. draw.detail: measure of its own level
/// over w; 1 if there is a finer level; 1 if there is a coarser one.
SHARED_FUNCTION bool isOfDetail(TileDraw draw, vec3 chances, float w) {
    bool isShown = chances.x < shareOf(draw);
    if (draw.detail.x == 0.0f) return isShown;
    PRECISE float measure = draw.detail.x * w;
    PRECISE float own = measure * (1.0f + kDetailOverlap);
    PRECISE float coarser = measure * (0.5f - 0.5f * kDetailOverlap);
    bool isWanted = draw.detail.y == 0.0f || chances.y < shareOfLevel(own);
    bool isReplaced = draw.detail.z != 0.0f && chances.z < shareOfLevel(coarser);
    return isShown && isWanted && !isReplaced;
}
SHARED_FUNCTION bool isOfDetail(TileDraw draw, uint x, uint y, float w) {
    return isOfDetail(draw, chancesOf(draw, x, y), w);
}

SHARED_END

#endif
