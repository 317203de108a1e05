#ifndef RENDER_SHADERS_SHARED_MARK_H
#define RENDER_SHADERS_SHARED_MARK_H
// What was not measured, told by a tint: filled pixels are half orange, pixels where nothing was seen half violet.
// Whole numbers, so that every device gives the same bytes, and of the pixel alone, so that both eyes agree.

#include "render/shaders/shared/z_key.h"

SHARED_BEGIN

struct MarkConstants {
    uint width, height;
};

/// r | g << 8 | b << 16.
SHARED_CONSTANT uint kFilledTint = 0x30a0ffu, kNothingTint = 0xa02080u;

/// r | g << 8 | b << 16 | class << 24, before and after.
SHARED_FUNCTION uint marked(uint colourAndClass) {
    uint pixelClass = colourAndClass >> 24u;
    if (pixelClass == kClassSeen) return colourAndClass;
    uint tint = pixelClass == kClassFilled ? kFilledTint : kNothingTint;
    return ((colourAndClass >> 1u) & 0x7f7f7fu) + ((tint >> 1u) & 0x7f7f7fu) + (pixelClass << 24u);
}

SHARED_END

#endif
