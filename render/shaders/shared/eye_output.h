#ifndef RENDER_SHADERS_SHARED_EYE_OUTPUT_H
#define RENDER_SHADERS_SHARED_EYE_OUTPUT_H
// A finished eye as displays' runtimes take it: colours as they are, metres along z as reversed infinite depth.

#include "render/shaders/shared/language.h"

SHARED_BEGIN

struct EyeOutputConstants {
    int width, height; ///< of the picture, pixels
    float nearMetres;
};

#ifdef __cplusplus
static_assert(sizeof(EyeOutputConstants) == 12);
#endif

/// In [0, 1]. Where there is nothing (z = 0) it is as far as can be.
SHARED_FUNCTION float nearOverDepth(float nearMetres, float zMetres) {
    return zMetres > 0.0f ? min(nearMetres / zMetres, 1.0f) : 0.0f;
}

SHARED_END

#endif
