#include "render/shaders/shared/hole_words.h"

#include "render/shaders/shared/hole_fill.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace render {
namespace {

/// Pixels that hold something or nothing.
struct Field {
    int width, height;
    std::vector<bool> held;

    bool at(ivec2 p) const {
        return p.x >= 0 && p.y >= 0 && p.x < width && p.y < height && held[static_cast<std::size_t>(p.y * width + p.x)];
    }
    uint word(int row, int word) const {
        uint bits = 0;
        for (int i = 0; i < kHoleWordBits; ++i)
            bits |= at({word * kHoleWordBits + i, row}) ? 1u << i : 0u;
        return bits;
    }
    /// As the filler goes: something on both sides of an axis, pixel by pixel.
    bool hasBothEnds(ivec2 hole, int radius) const {
        for (int axis = 0; axis < kHoleAxes; ++axis) {
            const int reach = axis < kMaskAxes ? radius : radius / 2;
            const auto meets = [&](ivec2 step) {
                for (int k = 1; k <= reach; ++k)
                    if (at(hole + k * step)) return true;
                return false;
            };
            if (meets(holeAxis(axis)) && meets(-holeAxis(axis))) return true;
        }
        return false;
    }
};

TEST(HoleWords, FindWhatTheFillerHasAnythingToAskOf) {
    std::mt19937 random(11);
    int found = 0, asked = 0;
    for (const double share : {0.002, 0.02, 0.2, 0.9})
        for (const int radius : {1, 2, 3, 5, 8, 16})
            for (const int width : {1, 31, 32, 33, 97}) {
                std::bernoulli_distribution isHeld(share);
                Field field{width, 40, {}};
                for (int i = 0; i < field.width * field.height; ++i)
                    field.held.push_back(isHeld(random));
                const auto heldAt = [&](int row, int word) { return field.word(row, word); };
                for (int y = 0; y < field.height; ++y)
                    for (int word = 0; word < holeWordsAcross(width); ++word) {
                        const uint holes = ~field.word(y, word);
                        const uint bits = withBothEnds(heldAt, y, word, holes, radius);
                        for (int i = 0; i < kHoleWordBits && word * kHoleWordBits + i < width; ++i) {
                            const ivec2 pixel{word * kHoleWordBits + i, y};
                            const bool isFound = (bits >> i & 1u) != 0;
                            ASSERT_EQ(isFound, !field.at(pixel) && field.hasBothEnds(pixel, radius))
                                << pixel.x << ", " << y << " of " << width << ", radius " << radius;
                            found += isFound, ++asked;
                        }
                    }
            }
    EXPECT_GT(found, asked / 10);
    EXPECT_LT(found, asked / 2);
}

TEST(HoleWords, KnowTheRimOfThePicture) {
    for (const int width : {1, 2, 31, 32, 33, 64, 97})
        for (const int height : {1, 2, 5})
            for (int y = 0; y < height; ++y)
                for (int word = 0; word < holeWordsAcross(width); ++word)
                    for (int i = 0; i < kHoleWordBits; ++i) {
                        const int x = word * kHoleWordBits + i;
                        const bool isRim = x < width && (x == 0 || x == width - 1 || y == 0 || y == height - 1);
                        EXPECT_EQ((rimInWord(width, height, y, word) >> i & 1u) != 0, isRim) << x << ", " << y;
                    }
}

TEST(HoleWords, TheListsOfRowsDoNotOverlap) {
    for (const int width : {1, 32, 33, 640})
        for (const int height : {1, 7, 480}) {
            EXPECT_EQ(holeCountAt(width, height, 0), holeWordsAcross(width) * height);
            EXPECT_EQ(holeColumnsAt(width, height, 0), holeCountAt(width, height, height - 1) + 1);
            EXPECT_EQ(holeColumnsAt(width, height, 1) - holeColumnsAt(width, height, 0), width);
            EXPECT_EQ(pinholesAt(width, height, 0), holeColumnsAt(width, height, height - 1) + width);
            EXPECT_EQ(pinholesAt(width, height, 1) - pinholesAt(width, height, 0), holeWordsAcross(width));
        }
}

} // namespace
} // namespace render
