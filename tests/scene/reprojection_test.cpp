#include "scene/reprojection.h"

#include "tests/scene/known_scenes.h"
#include "tests/scene/random_poses.h"

#include <cmath>
#include <limits>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

namespace scene {
namespace {

Sighting sightingIn(const DepthImage& target, const DepthImage& source, int x, int y) {
    return sightingOf(reprojectionInto(target, source), static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f,
                      source.disparity(x, y));
}

TEST(Reprojection, IsThatOfDoublePrecisionFarFromTheOrigin) {
    RandomPlaces random(1);
    for (int i = 0; i < 2000; ++i) {
        const Camera source = smallCamera(), target{320, 200, 150, 170, 155, 101};
        const Pose worldFromSource = random.pose(1, kFarFromOrigin), worldFromTarget = random.pose(1, kFarFromOrigin);
        const double x = random.between(0, 160), y = random.between(0, 120), d = random.between(0.1, 2);
        const glm::dvec3 pInTarget = inverse(worldFromTarget) * worldFromSource * (rayThrough(source, x, y) / d);
        const Sighting at = sightingOf(reprojectionInto(target, worldFromTarget, source, worldFromSource),
                                       static_cast<float>(x), static_cast<float>(y), static_cast<float>(d));
        ASSERT_EQ(at.w > 0, pInTarget.z > 0) << "case " << i;
        if (pInTarget.z < 0.3) continue;
        const glm::dvec2 uv = project(target, pInTarget);
        ASSERT_NEAR(at.u, uv.x, 1e-4 * (1 + std::abs(uv.x))) << "case " << i;
        ASSERT_NEAR(at.v, uv.y, 1e-4 * (1 + std::abs(uv.y))) << "case " << i;
        ASSERT_NEAR(at.disparity, 1 / pInTarget.z, 1e-5 / pInTarget.z) << "case " << i;
    }
}

TEST(Reprojection, BoundsHoldEverySightingOfABlock) {
    RandomPlaces random(5);
    int tight = 0, inside = 0;
    for (int i = 0; i < 3000; ++i) {
        const Camera source = smallCamera(), target{320, 200, 150, 170, 155, 101};
        const Pose worldFromSource = random.pose(1, kFarFromOrigin), worldFromTarget = random.pose(1, kFarFromOrigin);
        const Reprojection into = reprojectionInto(target, worldFromTarget, source, worldFromSource);
        const int x = static_cast<int>(random.between(0, 144)), y = static_cast<int>(random.between(0, 104));
        const PixelBox block{x, y, x + 16, y + 16};
        const float low = static_cast<float>(random.between(0.01, 2));
        const float high = low * static_cast<float>(random.between(1, i % 2 == 0 ? 1.1 : 30));
        const PixelBox bounds = boundsOfSightings(into, block, low, high, target);
        tight += bounds.isEmpty() || bounds.x1 - bounds.x0 < target.width / 2;
        for (int k = 0; k < 60; ++k) {
            const Sighting at = sightingOf(into, static_cast<float>(random.between(x, x + 16)),
                                           static_cast<float>(random.between(y, y + 16)),
                                           static_cast<float>(random.between(low, high)));
            if (!(at.w > 0 && at.u >= 0 && at.v >= 0 && at.u < 320 && at.v < 200)) continue;
            ++inside;
            const int u = static_cast<int>(at.u), v = static_cast<int>(at.v);
            ASSERT_TRUE(u >= bounds.x0 && u < bounds.x1 && v >= bounds.y0 && v < bounds.y1) << "case " << i;
        }
    }
    EXPECT_GT(inside, 10000);
    EXPECT_GT(tight, 2000) << "bounds that say nothing are of no use";
}

TEST(CompareWith, IsExactOnPlanes) {
    RandomPlaces random(2);
    int compared = 0;
    for (int i = 0; i < 20; ++i) {
        // A plane of the world, 3 m ahead and aslant, seen by two cameras.
        const glm::dvec3 normal = glm::normalize(glm::dvec3(random.between(-0.5, 0.5), random.between(-0.5, 0.5), 1));
        const auto seenFrom = [&](const Pose& pose) {
            const glm::dvec3 inCamera = glm::transpose(pose.rotation) * normal;
            const double offset = 3 * normal.z - glm::dot(normal, pose.translation);
            return imageOf(smallCamera(), pose,
                           [&](double x, double y) { return planeDisparity(smallCamera(), inCamera, offset, x, y); });
        };
        const Pose aside = poseFromQuaternion(random.point(0.3), random.between(-0.1, 0.1), random.between(-0.1, 0.1),
                                              random.between(-1, 1), 1);
        const DepthImage a = seenFrom({}), b = seenFrom(aside);
        for (int y = 0; y < a.camera.height; y += 3)
            for (int x = 0; x < a.camera.width; x += 3) {
                const Sighting at = sightingIn(b, a, x, y);
                if (!(at.w > 0 && at.u > 0.5f && at.v > 0.5f && at.u < 159.5f && at.v < 119.5f)) continue;
                const Comparison comparison = compareWith(b, at, {});
                ++compared;
                ASSERT_EQ(comparison.relation, Relation::agrees) << "case " << i << " at " << x << ", " << y;
                ASSERT_TRUE(comparison.isSmooth);
                ASSERT_NEAR(comparison.disparity, at.disparity, 2e-5f * at.disparity)
                    << "case " << i << " at " << x << ", " << y;
            }
    }
    EXPECT_GT(compared, 10000);
}

/// What compareWith says of the true samples of one image, counted against what castRay says of the same points.
TEST(CompareWith, TellsWhatIsSeenFromWhatIsHiddenInTheRoom) {
    const std::vector<DepthImage> images = imagesOfBareRoom(6);
    int agreed = 0, hidden = 0, odd = 0, all = 0;
    for (std::size_t a = 0; a < images.size(); ++a)
        for (const std::size_t b : {(a + 1) % 6, (a + 2) % 6, (a + 3) % 6}) {
            const DepthImage &source = images[a], &target = images[b];
            for (int y = 0; y < source.camera.height; y += 2)
                for (int x = 0; x < source.camera.width; x += 2) {
                    const Sighting at = sightingIn(target, source, x, y);
                    const Comparison comparison = compareWith(target, at, {});
                    const glm::dvec3 p =
                        pointInWorld(source, x + 0.5, y + 0.5, static_cast<double>(source.disparity(x, y)));
                    const bool isInside = at.w > 0 && at.u >= 0 && at.v >= 0 && at.u < 160 && at.v < 120;
                    // Whatever is there, nobody saw through a true surface, not even at silhouettes.
                    ASSERT_NE(comparison.relation, Relation::inFront)
                        << "image " << a << " in " << b << " at " << x << ", " << y;
                    if (!isInside) {
                        ASSERT_EQ(comparison.relation, Relation::outside)
                            << "image " << a << " in " << b << " at " << x << ", " << y;
                        continue;
                    }
                    const glm::dvec3 toPoint = p - target.worldFromCamera.translation;
                    const double seen =
                        castRay(bareRoom(), target.worldFromCamera.translation, toPoint)->distanceMetres /
                        glm::length(toPoint);
                    ++all;
                    if (!comparison.isSmooth) continue;
                    if (seen > 0.999) {
                        ++agreed;
                        odd += comparison.relation != Relation::agrees;
                    } else if (seen < 0.9) {
                        ++hidden;
                        odd += comparison.relation != Relation::behind;
                    }
                }
        }
    EXPECT_GT(agreed, all / 3);
    EXPECT_GT(hidden, all / 50);
    // What is left are smooth places of one surface beside the silhouette of another, within a pixel.
    EXPECT_LT(odd, all / 200) << odd << " of " << all;
}

TEST(CompareWith, FindsEmptySpaceOnlyWhereAllNineSamplesAreFarther) {
    // A step: 4 m to the left of column 80, 2 m from there on.
    const DepthImage target = imageOf(smallCamera(), {}, [](double x, double) { return x < 80 ? 0.25 : 0.5; });
    const auto relation = [&](float u, float disparity) {
        return compareWith(target, {u, 60.5f, disparity, 1}, {}).relation;
    };
    EXPECT_EQ(relation(40.2f, 0.25f), Relation::agrees);
    EXPECT_EQ(relation(40.2f, 0.2f), Relation::behind);
    EXPECT_EQ(relation(40.2f, 0.3f), Relation::inFront);
    EXPECT_EQ(relation(120.7f, 0.6f), Relation::inFront);
    for (float u = 77.5f; u < 83; u += 0.1f) {
        EXPECT_EQ(relation(u, 0.6f), Relation::inFront) << u << ": before both surfaces";
        EXPECT_EQ(relation(u, 0.2f), Relation::behind) << u << ": behind both surfaces";
        EXPECT_NE(relation(u, 0.5f), u >= 79 ? Relation::inFront : Relation::agrees)
            << u << ": a sample of the near edge, a pixel off";
    }
}

TEST(CompareWith, AllowsForDisplacementAlongASlope) {
    // Steep, but one surface: disparity grows by 3 % a pixel at column 80.
    const DepthImage target = imageOf(smallCamera(), {}, [](double x, double) { return 0.5 * (1 + 0.03 * (x - 80)); });
    const float truth = 0.5f * (1 + 0.03f * 4.7f);
    for (const float pixels : {-0.9f, 0.f, 0.9f})
        EXPECT_EQ(compareWith(target, {84.7f, 60.f, truth + pixels * 0.015f, 1}, {}).relation, Relation::agrees)
            << pixels << " pixels off";
    EXPECT_EQ(compareWith(target, {84.7f, 60.f, truth + 3 * 0.015f, 1}, {}).relation, Relation::inFront);
    EXPECT_NE(compareWith(target, {84.7f, 60.f, truth + 0.9f * 0.015f, 1}, {0.01f, 0.f}).relation, Relation::agrees)
        << "without allowance for displacement";
}

TEST(CompareWith, IsOutsideBesideTheImageBehindTheCameraAndWhereNothingIsKnown) {
    DepthImage target = imageOf(smallCamera(), {}, [](double, double) { return 0.5; });
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInfinity = std::numeric_limits<float>::infinity();
    const auto relation = [&](const Sighting& at) { return compareWith(target, at, {}).relation; };
    for (const Sighting& at : {Sighting{-0.01f, 50, 0.5f, 1},
                               {160, 50, 0.5f, 1},
                               {50, -0.01f, 0.5f, 1},
                               {50, 120, 0.5f, 1},
                               {50, 50, 0.5f, 0},
                               {50, 50, 0.5f, -1},
                               {kNan, 50, 0.5f, 1},
                               {50, kNan, 0.5f, 1},
                               {kInfinity, 50, 0.5f, 1},
                               {50, 50, 0.5f, kNan}})
        EXPECT_EQ(relation(at), Relation::outside) << at.u << ", " << at.v << ", w " << at.w;
    for (const Sighting& at : {Sighting{0, 0, 0.5f, 1}, {159.99f, 119.99f, 0.5f, 1}, {0.2f, 119.99f, 0.5f, 1e-9f}})
        EXPECT_EQ(relation(at), Relation::agrees) << at.u << ", " << at.v << ": the rim belongs to the image";
    for (const std::uint8_t flag : {kNoSurface, kFloating}) {
        target.flags(50, 50) = flag;
        target.disparity(50, 50) = kNan;
        EXPECT_EQ(relation({50.5f, 50.5f, 0.9f, 1}), Relation::outside) << "flag " << int{flag};
        EXPECT_EQ(relation({51.3f, 50.5f, 0.5f, 1}), Relation::agrees) << "its neighbour, flag " << int{flag};
    }
}

TEST(ColourAt, IsBilinear) {
    DepthImage target = imageOf({4, 3, 3, 3, 2, 1.5}, {}, [](double, double) { return 1.0; });
    for (int y = 0; y < 3; ++y)
        for (int x = 0; x < 4; ++x)
            target.colour(x, y) = {static_cast<std::uint8_t>(40 * x), static_cast<std::uint8_t>(60 * y), 7};
    EXPECT_EQ(colourAt(target, 1.5f, 1.5f), glm::vec3(40, 60, 7));
    EXPECT_NEAR(colourAt(target, 2.25f, 1.5f).x, 70, 1e-4);
    EXPECT_NEAR(colourAt(target, 2.25f, 0.75f).y, 15, 1e-4);
    EXPECT_EQ(colourAt(target, 0, 0), glm::vec3(0, 0, 7)) << "beyond the outermost centres the colour stays";
    EXPECT_EQ(colourAt(target, 3.99f, 2.99f), glm::vec3(120, 120, 7));
}

} // namespace
} // namespace scene
