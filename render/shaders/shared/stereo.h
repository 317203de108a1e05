#ifndef RENDER_SHADERS_SHARED_STEREO_H
#define RENDER_SHADERS_SHARED_STEREO_H
// What the warp for two eyes is told about a tile: which draw of each eye's list it is.

#include "render/shaders/shared/language.h"

SHARED_BEGIN

/// Numbers in the lists of the left and of the right eye, or kNoDraw: then that eye does not draw the tile.
struct PairDraw {
    uint left;
    uint right;
    uint run;       ///< number of its run in its batch
    uint leftRows;  ///< that the left eye draws: all, until it has been looked at (occlusion.h)
    uint rightRows; ///< the right eye
};
SHARED_CONSTANT uint kNoDraw = 0xffffffffu;
SHARED_CONSTANT uint kLeft = 0u, kRight = 1u; ///< eyes

struct PairTestConstants {
    uint firstPair;
    uint count;
    int width; ///< of the eyes' images, pixels
    int height;
};

#ifdef __cplusplus
static_assert(sizeof(PairDraw) == 20);
#endif

SHARED_END

#endif
