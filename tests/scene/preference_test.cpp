#include "scene/preference.h"

#include "scene/warp.h"
#include "tests/scene/known_scenes.h"
#include "tests/scene/random_poses.h"

#include <gtest/gtest.h>

namespace scene {
namespace {

/// A tile in the middle of a camera's image, of one disparity.
Tile tileOf(const Camera& camera, float disparity, Tier tier) {
    Tile tile;
    tile.x0 = camera.width / 2 - 8, tile.y0 = camera.height / 2 - 8, tile.width = tile.height = 16;
    tile.minDisparity = tile.maxDisparity = disparity;
    tile.tier = tier;
    return tile;
}

TEST(Preference, BaseTilesAreAlwaysDrawnAndDirectionalOnesOnlyFromNear) {
    RandomPlaces random(1);
    const Camera camera = smallCamera();
    int near = 0, away = 0;
    for (int i = 0; i < 2000; ++i) {
        const PreferenceOptions options{static_cast<float>(random.between(0.02, 1.0)),
                                        random.integerBetween(0, kMaxOrderLevel - 1)};
        const float disparity = i % 10 == 0 ? 0.f : static_cast<float>(random.between(0.05, 2.0));
        const Pose worldFromCamera = random.pose(0, kFarFromOrigin);
        View eye{camera, random.pose(1.0, kFarFromOrigin)};
        const auto base = orderLevelOf(tileOf(camera, disparity, Tier::base), camera, worldFromCamera, eye, options);
        const auto directional =
            orderLevelOf(tileOf(camera, disparity, Tier::directional), camera, worldFromCamera, eye, options);
        const auto guess = orderLevelOf(tileOf(camera, disparity, Tier::guess), camera, worldFromCamera, eye, options);
        ASSERT_EQ(guess.has_value(), directional.has_value()) << "case " << i;
        EXPECT_EQ(orderLevelOf(tileOf(camera, disparity, Tier::closed), camera, worldFromCamera, eye, options), base);
        ASSERT_TRUE(base.has_value()) << "case " << i;
        ASSERT_TRUE(*base >= 0 && *base <= kMaxOrderLevel) << "case " << i;

        const glm::dvec3 offset = eye.worldFromEye.translation - worldFromCamera.translation;
        const double distance =
            disparity > 0
                ? glm::length(worldFromCamera.rotation * glm::dvec3(0, 0, 1) / static_cast<double>(disparity) - offset)
                : 1e300;
        const double share = glm::length(offset) / distance / static_cast<double>(options.nearBaseline);
        if (std::abs(share - 1) < 1e-6) continue;
        ASSERT_EQ(directional.has_value(), share < 1) << "case " << i << ", share " << share;
        if (share < 1) {
            ++near;
            EXPECT_EQ(*base, *directional) << "near tiles of both tiers are equals";
            EXPECT_EQ(*guess, std::min(*base + options.guessLevels, kMaxOrderLevel)) << "what was measured comes first";
            EXPECT_NEAR(*base, share * options.nearLevels, 0.5 + 1e-6) << "case " << i;
        } else {
            ++away;
            EXPECT_EQ(*base, kMaxOrderLevel);
        }
    }
    EXPECT_GT(near, 300);
    EXPECT_GT(away, 300);
}

TEST(Preference, OfNoBaselineIsPlainZOrderOfTheBase) {
    RandomPlaces random(2);
    const Camera camera = smallCamera();
    for (int i = 0; i < 100; ++i) {
        const View eye{camera, random.pose(i == 0 ? 0 : 5)};
        EXPECT_EQ(orderLevelOf(tileOf(camera, 0.5f, Tier::base), camera, {}, eye, {0.f, 6}), 0);
        EXPECT_EQ(orderLevelOf(tileOf(camera, 0.5f, Tier::directional), camera, {}, eye, {0.f, 6}), std::nullopt);
    }
}

TEST(Preference, OfTheCameraThatStandsWhereTheEyeStandsIsTheStrongest) {
    const Camera camera = smallCamera();
    const Pose pose{glm::dmat3(1.0), kFarFromOrigin};
    EXPECT_EQ(orderLevelOf(tileOf(camera, 0.5f, Tier::directional), camera, pose, {camera, pose}, {}), 0);
    EXPECT_EQ(orderScale(0), 1.f);
    EXPECT_EQ(orderScale(kMaxOrderLevel), 2.f);
}

// Level and class share the key's lowest byte, colour the three above it: none may spill into another.
TEST(Preference, LevelComesOutOfTheKeyAsItWentIn) {
    for (int level = 0; level <= kMaxOrderLevel; ++level) {
        ZBuffer zBuffer(1, 1,
                        std::uint64_t{0x3f800000} << 32 | 0x030201u << 8 | static_cast<unsigned>(level) << 2 | 2u);
        const EyeImage eye = resolve(zBuffer);
        EXPECT_FLOAT_EQ(eye.depthMetres(0, 0), 1 / orderScale(level));
        EXPECT_EQ(eye.pixelClass(0, 0), static_cast<int>(PixelClass::filled));
        EXPECT_TRUE((eye.colour(0, 0) == Rgb8{1, 2, 3})) << "level " << level;
    }
}

} // namespace
} // namespace scene
