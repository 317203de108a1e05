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

/// One channel of a colour, sRGB to linear, 0 to 1: an image whose format is sRGB makes the same byte of it again.
SHARED_FUNCTION float decodedChannel(float encoded) {
    return encoded <= 0.04045f ? encoded / 12.92f : pow((encoded + 0.055f) / 1.055f, 2.4f);
}

SHARED_END

#endif
