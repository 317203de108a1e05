#ifndef RENDER_SHADERS_SHARED_EYE_DEPTH_H
#define RENDER_SHADERS_SHARED_EYE_DEPTH_H
// Metres along z to reversed infinite depth.

#include "render/shaders/shared/language.h"

SHARED_BEGIN

struct EyeDepthConstants {
    uint width;
    float nearMetres;
};

/// In [0, 1]. Where there is nothing (z = 0) it is as far as can be.
SHARED_FUNCTION float nearOverDepth(float nearMetres, float zMetres) {
    return zMetres > 0.0f ? min(nearMetres / zMetres, 1.0f) : 0.0f;
}

SHARED_END

#endif
