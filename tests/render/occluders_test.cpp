// What a pixel of the z-buffer counts as when hidden tiles are looked for, where gaps are closed.

#include "render/shaders/shared/occlusion.h"

#include <array>

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

} // namespace
} // namespace render
