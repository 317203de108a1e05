// What a pixel of the z-buffer counts as when hidden tiles are looked for, where gaps are closed; and what of a tile is
// left out.

#include "render/shaders/shared/occlusion.h"
#include "scene/tile.h"

#include <array>
#include <random>

#include <gtest/gtest.h>

namespace render {
namespace {

/// Three rows of three order disparities; the one in the middle is asked for.
glm::uint closed(const std::array<glm::uint, 9>& p) {
    return closedDisparity(p[4], {p[3], p[5]}, {p[1], p[7]}, {p[0], p[8]}, {p[2], p[6]});
}

constexpr glm::uint kNear = 900, kFar = 400;

TEST(Occluders, AGapWithinASurfaceCountsAsIt) {
    EXPECT_EQ(closed({kNear, kNear, kNear, kNear, 0, kNear, kNear, kNear, kNear}), kNear);
    EXPECT_EQ(closed({0, 0, 0, kNear, 0, kNear, 0, 0, 0}), kNear);
    EXPECT_EQ(closed({0, 0, kNear, 0, 0, 0, kNear, 0, 0}), kNear);
}

TEST(Occluders, AGapBesideASilhouetteCountsAsWhatIsBehind) {
    EXPECT_EQ(closed({kNear, 0, kFar, kNear, 0, kFar, kNear, 0, kFar}), kFar);
    EXPECT_EQ(closed({kNear, kNear, kNear, 0, 0, 0, kFar, kFar, kFar}), kFar);
    EXPECT_EQ(closed({kNear, kNear, 0, kNear, 0, kFar, 0, kFar, kFar}), kFar);
}

TEST(Occluders, NothingClosesWhatIsOpenToOneSide) {
    EXPECT_EQ(closed({kNear, kNear, kNear, 0, 0, 0, 0, 0, 0}), 0u);
    EXPECT_EQ(closed({0, 0, 0, 0, 0, 0, 0, 0, 0}), 0u);
}

TEST(Occluders, WhatIsSeenBesideASilhouetteIsNotTakenForIt) {
    EXPECT_EQ(closed({kNear, kFar, kFar, kNear, kFar, kFar, kNear, kFar, kFar}), kFar);
    EXPECT_EQ(closed({kFar, kFar, kFar, kFar, kNear, kFar, kFar, kFar, kFar}), kNear);
}

/// A tile of that many samples a side, each `step` pixels from the next, whose samples at the greatest disparity stand
/// `shift` pixels off; seen at disparities 0.5 to 1.
TileDraw tileDraw(int side, float step, vec2 first, vec2 shift, float slope) {
    constexpr float kSteps = static_cast<float>((1u << (32 - 2 * kRowPlaceBits)) - 1);
    TileDraw draw{};
    draw.base = {first.x, first.y, 1, 0.5f};
    draw.perX = {step, 0.1f * slope, 0.001f * slope, 0};
    draw.perY = {slope, step, -0.001f * slope, 0};
    draw.perQ = vec4(shift.x, shift.y, 0, 0.5f) / kSteps;
    draw.span = {0, 0, 0, packMark(0, 0, kRowPlaceBits, 2)};
    draw.source = {0, 0, static_cast<uint>(side + 1) << 8 | static_cast<uint>(side) << 20, 0};
    return draw;
}

constexpr Occluder kFull{400, 0, 0, 0};

TEST(Occluders, AFullBlockHidesWhatIsBehindAllOfIt) {
    const TileReach behind{{0, 0}, {7, 7}, uintBitsToFloat(399)}, within{{2, 1}, {5, 12}, uintBitsToFloat(400)};
    EXPECT_LT(withBlock(noOpening(), behind, {0, 0}, kFull).last.x, 0);
    const Opening upper = withBlock(noOpening(), within, {0, 0}, kFull);
    EXPECT_EQ(upper.first, ivec2(2, 1));
    EXPECT_EQ(upper.last, ivec2(5, 7));
    const Opening both = withBlock(upper, within, {0, 1}, kFull);
    EXPECT_EQ(both.first, ivec2(2, 1));
    EXPECT_EQ(both.last, ivec2(5, 12));
}

TEST(Occluders, WhatIsOpenIsSeenThroughWhereItIs) {
    // Of the block at (8, 16) the pixels (3, 2) and (6, 5) hold nothing.
    const Occluder block{400, 1u << (8 * 2 + 3), 1u << (8 * 1 + 6), 0};
    const auto opening = [&](ivec2 first, ivec2 last) {
        return withBlock(noOpening(), TileReach{first, last, uintBitsToFloat(300)}, {1, 2}, block);
    };
    EXPECT_EQ(opening({0, 0}, {40, 40}).first, ivec2(8 + 3, 16 + 2));
    EXPECT_EQ(opening({0, 0}, {40, 40}).last, ivec2(8 + 6, 16 + 5));
    EXPECT_EQ(opening({0, 19}, {40, 40}).first, ivec2(8 + 6, 16 + 5));
    EXPECT_EQ(opening({8, 16}, {8 + 5, 23}).last, ivec2(8 + 3, 16 + 2));
    EXPECT_LT(opening({8 + 4, 16}, {23, 20}).last.x, 0) << "touches neither";
    EXPECT_LT(opening({8, 20}, {13, 23}).last.x, 0) << "touches neither";
}

TEST(Occluders, EveryRowThatTouchesWhatIsOpenIsDrawn) {
    std::mt19937 random(5);
    const auto in = [&](float least, float most) { return std::uniform_real_distribution<float>(least, most)(random); };
    constexpr float kSteps = static_cast<float>((1u << (32 - 2 * kRowPlaceBits)) - 1);
    int rows = 0, all = 0;
    for (int trial = 0; trial < 400; ++trial) {
        const int side = 1 + trial % scene::kMaxTileSize;
        const TileDraw draw =
            tileDraw(side, in(0.3f, 3), {in(-50, 600), in(-50, 400)}, {in(-20, 20), in(-20, 20)}, in(-1, 1));
        const ivec2 first(static_cast<int>(in(0, 600)), static_cast<int>(in(0, 440)));
        const Opening opening{first, first + ivec2(trial % 9)};
        const uint drawn = rowsIn(opening, draw, false, true);
        for (int y = 0; y < side; ++y) {
            const bool isDrawn = y >= static_cast<int>(drawn & 0xffu) && y < static_cast<int>(drawn >> 8);
            ++all, rows += isDrawn ? 1 : 0;
            for (int x = 0; x < side && !isDrawn; ++x)
                for (const float q : {0.0f, kSteps}) {
                    const vec3 seen = project(warpPlace(draw, vec3(x, y, q)));
                    const vec2 corner(firstOfFootprint(seen.x, 2), firstOfFootprint(seen.y, 2));
                    EXPECT_FALSE(corner.x + 1 >= static_cast<float>(opening.first.x) &&
                                 corner.x <= static_cast<float>(opening.last.x) &&
                                 corner.y + 1 >= static_cast<float>(opening.first.y) &&
                                 corner.y <= static_cast<float>(opening.last.y))
                        << trial << ": " << x << ", " << y;
                }
        }
    }
    EXPECT_LT(rows, all / 5) << "and of the others few";
}

TEST(Occluders, WhatDoesNotComeRowByRowIsDrawnWhole) {
    TileDraw draw = tileDraw(32, 1, {0, 0}, {0, 0}, 0);
    EXPECT_NE(rowsIn({{10, 5}, {10, 5}}, draw, false, true), kAllRows);
    draw.span.w = packMark(0, kClassUnseen, kRowPlaceBits, 2);
    EXPECT_EQ(rowsIn({{10, 5}, {10, 5}}, draw, false, true), kAllRows);
    draw.span.w = packMark(0, 0, scene::kScrapPlaceBits, 2);
    EXPECT_EQ(rowsIn({{10, 5}, {10, 5}}, draw, false, true), kAllRows);
}

} // namespace
} // namespace render
