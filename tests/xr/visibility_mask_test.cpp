// How much of a picture a mask hides.

#include "xr/visibility_mask.h"

#include <gtest/gtest.h>

#include <cmath>

namespace xr {

namespace {

TEST(VisibilityMask, HidesWhatItsTrianglesCoverWithinThePicture) {
    const double side = std::atan(1.0); // the picture reaches from -1 to 1 on the plane
    const FieldOfView field{-side, side, side, -side};
    EXPECT_EQ(hiddenShare({}, field), 0);
    EXPECT_NEAR(hiddenShare({{{-1, -1}, {1, -1}, {-1, 1}}, {0, 1, 2}}, field), 0.5, 1e-12);
    EXPECT_NEAR(hiddenShare({{{-1, 1}, {1, -1}, {-1, -1}}, {0, 1, 2}}, field), 0.5, 1e-12) << "the other way round";
    EXPECT_NEAR(hiddenShare({{{-9, -9}, {9, -9}, {-9, 9}}, {0, 1, 2}}, field), 0.5, 1e-12) << "what is outside";
    EXPECT_NEAR(hiddenShare({{{-9, -9}, {90, -9}, {-9, 90}}, {0, 1, 2}}, field), 1, 1e-12);
    EXPECT_EQ(hiddenShare({{{2, 2}, {3, 2}, {2, 3}}, {0, 1, 2}}, field), 0);
    EXPECT_NEAR(hiddenShare({{{-1, -1}, {0, -1}, {-1, 0}, {1, 1}, {0, 1}, {1, 0}}, {0, 1, 2, 3, 4, 5}}, field), 0.25,
                1e-12);
}

TEST(VisibilityMask, OfARuntimeThatMiscountsIsSurvived) {
    const double side = std::atan(1.0);
    EXPECT_EQ(hiddenShare({{{0, 0}}, {0, 7, 8, 9}}, {-side, side, side, -side}), 0);
}

} // namespace

} // namespace xr
