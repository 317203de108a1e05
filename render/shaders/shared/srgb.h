#ifndef RENDER_SHADERS_SHARED_SRGB_H
#define RENDER_SHADERS_SHARED_SRGB_H
// One channel of a colour, 0 to 1: as pictures write it (sRGB, IEC 61966-2-1) and as light adds up.

#include "render/shaders/shared/language.h"

SHARED_BEGIN

SHARED_FUNCTION float encodedChannel(float linear) {
    float c = clamp(linear, 0.0f, 1.0f);
    return c <= 0.0031308f ? 12.92f * c : 1.055f * pow(c, 1.0f / 2.4f) - 0.055f;
}

/// Of a byte, over 255: an image whose format is sRGB makes the same byte of it again.
SHARED_FUNCTION float decodedChannel(float encoded) {
    return encoded <= 0.04045f ? encoded / 12.92f : pow((encoded + 0.055f) / 1.055f, 2.4f);
}

SHARED_END

#endif
