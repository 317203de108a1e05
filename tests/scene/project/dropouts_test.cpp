#include "scene/project/dropouts.h"

#include "tests/scene/known_scenes.h"
#include "tests/scene/random_poses.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

namespace scene {
namespace {

/// Takes away all samples but a share, drawn at random.
void thinOut(DepthImage& image, double share, unsigned seed) {
    RandomPlaces random(seed);
    for (int y = 0; y < image.camera.height; ++y)
        for (int x = 0; x < image.camera.width; ++x)
            if (random.between(0, 1) > share) image.flags(x, y) = kNoSurface, image.disparity(x, y) = 0;
}

/// Whether three samples or more are within 3 pixels, and not on one side: no straight line parts the pixel from all of
/// them, since seen from it no two neighbours are more than half a turn apart.
bool isBetweenSamples(const DepthImage& image, int x, int y) {
    std::vector<double> angles;
    for (int v = std::max(y - 3, 0); v <= std::min(y + 3, image.camera.height - 1); ++v)
        for (int u = std::max(x - 3, 0); u <= std::min(x + 3, image.camera.width - 1); ++u)
            if ((image.flags(u, v) & kNoSurface) == 0) angles.push_back(std::atan2(v - y, u - x));
    if (angles.size() < 3) return false;
    std::sort(angles.begin(), angles.end());
    constexpr double kHalfTurn = std::numbers::pi;
    double widest = angles.front() + 2 * kHalfTurn - angles.back();
    for (std::size_t i = 1; i < angles.size(); ++i)
        widest = std::max(widest, angles[i] - angles[i - 1]);
    // Two on a line through the pixel are on no one side of it. The next wider angle between pixels is 3 degrees more.
    return widest < kHalfTurn + 0.01;
}

TEST(Dropouts, OfAPlaneAreRestored) {
    const Camera camera = smallCamera();
    const glm::dvec3 normal = glm::normalize(glm::dvec3(0.4, -0.3, 1));
    const auto truth = [&](double x, double y) { return planeDisparity(camera, normal, 2, x, y); };
    DepthImage image = imageOf(camera, {}, truth);
    thinOut(image, 0.34, 1);
    const DepthImage sparse = image;
    const std::int64_t filled = fillDropouts(image);
    // Of the two ends of what is filled about a pixel in a row or column, those at a sample. Beyond the image samples
    // may go on.
    const auto joinsAlong = [&](int x, int y, int dx, int dy) {
        int joins = 0, isAtRim = 0;
        for (const int side : {-1, 1}) {
            int i = x + side * dx, j = y + side * dy;
            const auto isInside = [&] { return i >= 0 && j >= 0 && i < camera.width && j < camera.height; };
            while (isInside() && image.flags(i, j) == kInterpolated)
                i += side * dx, j += side * dy;
            joins += isInside() && (sparse.flags(i, j) & kNoSurface) == 0;
            isAtRim += !isInside();
        }
        return isAtRim > 0 ? 2 * joins : joins;
    };
    std::int64_t found = 0;
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x) {
            if ((sparse.flags(x, y) & kNoSurface) == 0) {
                ASSERT_EQ(image.disparity(x, y), sparse.disparity(x, y))
                    << "a measured sample changed at " << x << ", " << y;
                ASSERT_EQ(image.flags(x, y), 0) << "at " << x << ", " << y;
            } else if (image.flags(x, y) == kInterpolated) {
                ++found;
                ASSERT_TRUE(isBetweenSamples(sparse, x, y)) << "extrapolated at " << x << ", " << y;
                ASSERT_GE(joinsAlong(x, y, 1, 0) + joinsAlong(x, y, 0, 1), 2) << "hangs at " << x << ", " << y;
                const double d = truth(x + 0.5, y + 0.5);
                ASSERT_NEAR(image.disparity(x, y), d, 3e-7 * d) << "at " << x << ", " << y;
            } else {
                ASSERT_TRUE(!isBetweenSamples(sparse, x, y) || joinsAlong(x, y, 1, 0) + joinsAlong(x, y, 0, 1) < 2)
                    << "nothing at " << x << ", " << y << ", where samples stand all round";
                ASSERT_EQ(image.flags(x, y), kNoSurface) << "at " << x << ", " << y;
                ASSERT_EQ(image.disparity(x, y), 0) << "at " << x << ", " << y;
            }
        }
    EXPECT_EQ(filled, found);
}

TEST(Dropouts, AreNotFilledAcrossSilhouettes) {
    const Camera camera = smallCamera();
    const auto isNear = [](double x, double y) { return std::hypot(x - 80, y - 60) < 30; };
    const auto truth = [&](double x, double y) { return isNear(x, y) ? 0.8 : 0.4; };
    DepthImage image = imageOf(camera, {}, truth);
    thinOut(image, 0.34, 2);
    fillDropouts(image);
    int wrongSide = 0;
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x) {
            if (image.flags(x, y) != kInterpolated) continue;
            const float d = image.disparity(x, y);
            ASSERT_TRUE(std::abs(d - 0.8f) < 1e-6f || std::abs(d - 0.4f) < 1e-6f)
                << d << " at " << x << ", " << y << " is between the surfaces";
            const double fromEdge = std::abs(std::hypot(x + 0.5 - 80, y + 0.5 - 60) - 30);
            if (fromEdge > 3) {
                ASSERT_NEAR(d, truth(x + 0.5, y + 0.5), 1e-6) << "at " << x << ", " << y;
            }
            wrongSide += std::abs(d - static_cast<float>(truth(x + 0.5, y + 0.5))) > 1e-6f;
        }
    EXPECT_LT(wrongSide, 60) << "the silhouette, 190 pixels long, has moved";
}

TEST(Dropouts, AreNotExtrapolated) {
    const Camera camera = smallCamera();
    DepthImage image = imageOf(camera, {}, [](double, double) { return 0.5; });
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x)
            if (x >= 80 || (x >= 30 && x < 37 && y >= 40 && y < 47))
                image.flags(x, y) = kNoSurface, image.disparity(x, y) = 0;
    fillDropouts(image, {3, 0.03f, 3});
    for (int y = 0; y < camera.height; ++y)
        for (int x = 80; x < camera.width; ++x)
            ASSERT_EQ(image.flags(x, y), kNoSurface) << "beyond the surface's end at " << x << ", " << y;
    EXPECT_EQ(image.flags(33, 43), kNoSurface) << "the middle of a hole wider than the support";
    EXPECT_EQ(image.flags(30, 40), kInterpolated) << "its corner";
}

/// Two walls, white before blue; a blot of each colour lost its range at their border.
TEST(Guesses, FollowTheColourToTheRightSurface) {
    const Camera camera = smallCamera();
    const auto near = [&](double x, double y) { return planeDisparity(camera, {0.3, 0.1, -1}, -1.0, x, y); };
    const auto far = [&](double x, double y) { return planeDisparity(camera, {-0.2, 0, -1}, -2.0, x, y); };
    DepthImage image = imageOf(camera, {}, [&](double x, double y) { return x < 80 ? near(x, y) : far(x, y); });
    for (int y = 0; y < 120; ++y)
        for (int x = 0; x < 160; ++x) {
            image.colour(x, y) = x < 80 ? Rgb8{240, 240, 240} : Rgb8{20, 30, 90};
            if (std::hypot(x - 80, y - 60) < 10) image.flags(x, y) = kNoSurface, image.disparity(x, y) = 0;
        }
    const DepthImage before = image;
    const std::int64_t guesses = guessRange(image);
    std::int64_t found = 0;
    for (int y = 0; y < 120; ++y)
        for (int x = 0; x < 160; ++x) {
            if (before.flags(x, y) == 0) {
                ASSERT_EQ(image.flags(x, y), 0);
                ASSERT_EQ(image.disparity(x, y), before.disparity(x, y)) << "measured, at " << x << ", " << y;
                continue;
            }
            ASSERT_TRUE(isGuess(image.flags(x, y))) << "at " << x << ", " << y;
            ++found;
            const double truth = x < 80 ? near(x + 0.5, y + 0.5) : far(x + 0.5, y + 0.5);
            ASSERT_NEAR(image.disparity(x, y), truth, 0.01 * truth) << "at " << x << ", " << y;
        }
    EXPECT_EQ(guesses, found);
    EXPECT_GT(found, 250);

    DepthImage empty = imageOf(camera, {}, near);
    for (auto& flags : empty.flags.pixels())
        flags = kNoSurface;
    EXPECT_EQ(guessRange(empty), 0);
    GuessOptions never;
    never.radius = 0;
    image = before;
    EXPECT_EQ(guessRange(image, never), 0);
}

// It may be a dark pole before a wall: a gap is filled whole or not at all.
TEST(Dropouts, OfAGapWiderThanTheSupportAreNotFilledInItsMiddle) {
    const Camera camera = smallCamera();
    for (const bool upright : {true, false})
        for (int wide = 1; wide <= 8; ++wide) {
            DepthImage image = imageOf(camera, {}, [](double, double) { return 0.5; });
            const auto isGap = [&](int x, int y) {
                return upright ? x >= 40 && x < 40 + wide : y >= 40 && y < 40 + wide;
            };
            for (int y = 0; y < camera.height; ++y)
                for (int x = 0; x < camera.width; ++x)
                    if (isGap(x, y)) image.flags(x, y) = kNoSurface, image.disparity(x, y) = 0;
            fillDropouts(image, {3, 0.03f, 3});
            for (int y = 0; y < camera.height; ++y)
                for (int x = 0; x < camera.width; ++x)
                    ASSERT_EQ(image.flags(x, y), !isGap(x, y) ? 0
                                                 : wide <= 3  ? kInterpolated
                                                              : kNoSurface)
                        << "at " << x << ", " << y << ", with a gap of " << wide;
        }
}

TEST(Dropouts, NeedEnoughSamplesAndSurvivesEmptyAndTinyImages) {
    DepthImage image = imageOf({20, 20, 20, 20, 10, 10}, {}, [](double, double) { return 0.5; });
    for (auto& flags : image.flags.pixels())
        flags = kNoSurface;
    EXPECT_EQ(fillDropouts(image), 0);
    for (const int x : {9, 11})
        image.flags(x, 10) = 0;
    EXPECT_EQ(fillDropouts(image, {3, 0.03f, 3}), 0) << "two samples are no surface";
    EXPECT_EQ(fillDropouts(image, {3, 0.03f, 2}), 1);
    EXPECT_EQ(image.flags(10, 10), kInterpolated);
    DepthImage one = imageOf({1, 1, 1, 1, 0.5, 0.5}, {}, [](double, double) { return 0.5; });
    one.flags(0, 0) = kNoSurface;
    EXPECT_EQ(fillDropouts(one), 0);
}

} // namespace
} // namespace scene
