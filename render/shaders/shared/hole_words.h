#ifndef RENDER_SHADERS_SHARED_HOLE_WORDS_H
#define RENDER_SHADERS_SHARED_HOLE_WORDS_H
// Which holes the filler (shaders/shared/hole_fill.h) has anything to ask of: those that have something within reach on
// both sides of an axis. Found for 32 pixels at once, by a bit of each that says whether it holds anything, so that
// the inside of a large hole and the open sky cost next to nothing.

#include "render/shaders/shared/language.h"

SHARED_BEGIN

// Words are lent as keys are: GLSL's functions call heldAt, which the shader defines; those of C++ are given it.
// Bit i of the answer is 1 if the pixel (32 word + i, row) holds something; 0 outside the picture.
#ifdef __cplusplus
#define WORD_FUNCTION                                                                                                  \
    template <class HeldAt>                                                                                            \
    inline
#define WORD_LENDER const HeldAt &heldAt,
#define WORD_LENT heldAt,
#else
uint heldAt(int row, int word);
#define WORD_FUNCTION
#define WORD_LENDER
#define WORD_LENT
#endif

SHARED_CONSTANT int kHoleWordBits = 32;

SHARED_FUNCTION int holeWordsAcross(int width) {
    return (width + kHoleWordBits - 1) / kHoleWordBits;
}

/// Bits of those pixels of a word that are in a picture so wide.
SHARED_FUNCTION uint pixelsInWord(int width, int word) {
    int left = width - word * kHoleWordBits;
    return left >= kHoleWordBits ? ~0u : (1u << left) - 1u;
}

/// Bits of those pixels of a word that are at the rim of the picture.
SHARED_FUNCTION uint rimInWord(int width, int height, int row, int word) {
    if (row == 0 || row == height - 1) return pixelsInWord(width, word);
    int last = width - 1 - word * kHoleWordBits;
    uint right = last < kHoleWordBits ? 1u << last : 0u;
    return word == 0 ? right | 1u : right;
}

/// Holes in a picture, as indices into one buffer of uints: words as above, row by row; how many pixels of each row are
/// to be filled; their columns, as many for each row as it has pixels; and words of what may be seen through a crack.
SHARED_FUNCTION int holeCountAt(int width, int height, int row) {
    return holeWordsAcross(width) * height + row;
}
SHARED_FUNCTION int holeColumnsAt(int width, int height, int row) {
    return holeCountAt(width, height, height) + row * width;
}
SHARED_FUNCTION int pinholesAt(int width, int height, int row) {
    return holeColumnsAt(width, height, height) + row * holeWordsAcross(width);
}

/// A word with those beside it.
struct HeldPixels {
    uint left, here, right;
};

WORD_FUNCTION HeldPixels heldAround(WORD_LENDER int row, int word) {
    HeldPixels held;
    held.left = heldAt(row, word - 1);
    held.here = heldAt(row, word);
    held.right = heldAt(row, word + 1);
    return held;
}

/// Bit i: what stands `across` pixels to the right of pixel i; -31 to 31.
SHARED_FUNCTION uint heldBeside(HeldPixels held, int across) {
    if (across == 0) return held.here;
    int left = across & (kHoleWordBits - 1), right = -across & (kHoleWordBits - 1);
    return across > 0 ? (held.here >> left) | (held.right << right) : (held.here << right) | (held.left >> left);
}

/// Per pixel of a word and axis but the level one: whether anything is within reach on one side.
struct HoleEnds {
    uint upright, falling, rising, flatFalling, flatRising, steepFalling, steepRising;
};

SHARED_FUNCTION HoleEnds noEnds() {
    HoleEnds none;
    none.upright = none.falling = none.rising = 0u;
    none.flatFalling = none.flatRising = none.steepFalling = none.steepRising = 0u;
    return none;
}

/// Adds what the row `down` below shows (negative: above). The mask's axes reach as far as radius, those between them
/// half as many of their steps.
SHARED_FUNCTION HoleEnds withRow(HoleEnds ends, HeldPixels held, int down, int radius) {
    ends.upright |= held.here;
    ends.falling |= heldBeside(held, down);
    ends.rising |= heldBeside(held, -down);
    int steps = radius / 2;
    if (abs(down) <= steps) {
        ends.flatFalling |= heldBeside(held, 2 * down);
        ends.flatRising |= heldBeside(held, -2 * down);
    }
    if ((down & 1) == 0 && abs(down) <= 2 * steps) {
        ends.steepFalling |= heldBeside(held, down / 2);
        ends.steepRising |= heldBeside(held, -down / 2);
    }
    return ends;
}

/// Which of the pixels `asked` of a word have something within reach on both sides of one of the filler's axes.
/// radius: up to kMostHoleRadius.
WORD_FUNCTION uint withBothEnds(WORD_LENDER int row, int word, uint asked, int radius) {
    // As the end of a loop, not a branch: processors take several words at once, and only loops are left early.
    int reach = asked != 0u ? radius : 0;
    HoleEnds below = noEnds(), above = noEnds();
    uint left = 0u, right = 0u;
    HeldPixels level = heldAround(WORD_LENT row, word);
    for (int k = 1; k <= reach; ++k) {
        left |= heldBeside(level, -k);
        right |= heldBeside(level, k);
        below = withRow(below, heldAround(WORD_LENT row + k, word), k, radius);
        above = withRow(above, heldAround(WORD_LENT row - k, word), -k, radius);
    }
    return asked & ((left & right) | (below.upright & above.upright) | (below.falling & above.falling) |
                    (below.rising & above.rising) | (below.flatFalling & above.flatFalling) |
                    (below.flatRising & above.flatRising) | (below.steepFalling & above.steepFalling) |
                    (below.steepRising & above.steepRising));
}

SHARED_END

#endif
