#include "scene/refine/open_space.h"

#include "scene/refine/rim.h"
#include "tests/scene/known_scenes.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

namespace scene {
namespace {

const Camera kSquare{48, 48, 24, 24, 24, 24}; // 90 degrees: a face of a cube

/// Each at its own disparity, and joined to none: its patch is as thick as nothing.
DepthImage scatteredSamples(const Camera& camera) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> disparity(0.1f, 2);
    DepthImage image = imageOf(camera, {}, [&](double, double) { return disparity(random); });
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x)
            image.flags(x, y) = kSkinUpper | kSkinLower;
    return image;
}

/// As holdsSample, of such samples, by looking at each.
bool holdsOneOf(const DepthImage& image, const BoxInCamera& box) {
    const double zNear = box.centre.z - box.half.z, zFar = box.centre.z + box.half.z;
    if (zNear <= 0) return false;
    const Camera& camera = image.camera;
    glm::dvec2 least(1e9), most(-1e9);
    for (const double z : {zNear, zFar})
        for (const double side : {-1.0, 1.0}) {
            const glm::dvec2 at =
                project(camera, {box.centre.x + side * box.half.x, box.centre.y + side * box.half.y, z});
            least = glm::min(least, at), most = glm::max(most, at);
        }
    const auto boxNear = static_cast<float>(1 / zNear), boxFar = static_cast<float>(1 / zFar);
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x) {
            const bool isSeenThrough = x + 1 > least.x && x <= most.x && y + 1 > least.y && y <= most.y;
            const float disparity = image.disparity(x, y);
            if (isSeenThrough && disparity >= boxFar && disparity <= boxNear) return true;
        }
    return false;
}

TEST(OpenSpace, HoldsASampleWhereOneIs) {
    const Camera camera{100, 60, 50, 40, 47, 33};
    const DepthImage image = scatteredSamples(camera);
    OpenSpace::Buffers buffers;
    const OpenSpace space(image, nullptr, 0, buffers);
    std::mt19937 random(1);
    const auto between = [&](double least, double most) {
        return std::uniform_real_distribution<double>(least, most)(random);
    };
    int holding = 0;
    constexpr int kBoxes = 3000;
    for (int i = 0; i < kBoxes; ++i) {
        const double z = between(0.3, 6), half = z * std::exp(between(-5, -1));
        const BoxInCamera box{{z * between(-1.2, 1.2), z * between(-1.2, 1.2), z},
                              {half * between(0.2, 1), half * between(0.2, 1), half * std::exp(between(-5, 0))}};
        ASSERT_EQ(space.holdsSample(box), holdsOneOf(image, box)) << i;
        holding += space.holdsSample(box);
    }
    EXPECT_GT(holding, kBoxes / 10);
    EXPECT_LT(holding, 9 * kBoxes / 10);
}

TEST(OpenSpace, InTheBuffersOfAnotherIsAsInItsOwn) {
    const DepthImage image = scatteredSamples({20, 30, 15, 15, 10, 15});
    OpenSpace::Buffers used, own;
    const OpenSpace larger(scatteredSamples(kSquare), nullptr, 0, used);
    const OpenSpace again(image, nullptr, 0, used), fresh(image, nullptr, 0, own);
    int parts = 0;
    for (double z = 0.4; z < 8; z *= 1.1)
        for (double x = -1; x < 1; x += 0.05) {
            const BoxInCamera box{{x * z, x * x * z, z}, glm::dvec3(0.05 * z)};
            ASSERT_EQ(again.look(box).sight, fresh.look(box).sight);
            ASSERT_EQ(again.look(box).hasEdge, fresh.look(box).hasEdge);
            ASSERT_EQ(again.holdsSample(box), fresh.holdsSample(box));
            parts += fresh.look(box).sight == Sight::part;
        }
    EXPECT_GT(parts, 0);
}

TEST(Rim, SeesHowFarTheRaysOfAnotherFaceWent) {
    const double half = std::sqrt(0.5);
    // A wall two metres to the right, seen by a face that looks that way.
    const Pose toTheRight = poseFromQuaternion({0, 0, 0}, 0, half, 0, half);
    ASSERT_NEAR((toTheRight.rotation * glm::dvec3(0, 0, 1)).x, 1, 1e-12);
    const DepthImage right = imageOf(kSquare, toTheRight, [](double, double) { return 0.5; });
    Rim rim(kSquare, glm::dmat3(1));
    rim.take(right);
    ASSERT_EQ(rim.margin(), 6);
    int taken = 0;
    for (int y = 0; y < rim.widened().height; ++y)
        for (int x = 0; x < rim.widened().width; ++x) {
            const bool isWithin = x >= 6 && y >= 6 && x < 54 && y < 54;
            if (isWithin) continue;
            const glm::dvec3 ray = rayThrough(rim.widened(), x + 0.5, y + 0.5);
            if (std::abs(std::abs(ray.y) - ray.x) < 1e-9) continue; // along an edge of the cube
            const RayEnd end = rim.at(x, y);
            ASSERT_EQ(end.provesSomething(), ray.x > 1 && std::abs(ray.y) < ray.x) << x << ", " << y;
            if (!end.provesSomething()) continue;
            ++taken;
            ASSERT_NEAR(end.disparity, ray.x / 2, 1e-6) << "it ends where x is 2 m";
        }
    EXPECT_GT(taken, 6 * 48);
}

TEST(Rim, TheFirstThatSawARaySaysHowFarItWent) {
    const double half = std::sqrt(0.5);
    const Pose toTheRight = poseFromQuaternion({0, 0, 0}, 0, half, 0, half);
    DepthImage nearby = imageOf(kSquare, toTheRight, [](double, double) { return 1.0; });
    nearby.flags(0, 24) = kNoSurface; // looks past the border of the face straight ahead
    const DepthImage far = imageOf(kSquare, toTheRight, [](double, double) { return 0.25; });
    Rim rim(kSquare, glm::dmat3(1));
    rim.take(nearby), rim.take(far);
    int fromNearby = 0, fromFar = 0;
    for (int y = 6; y < 54; ++y)
        for (int x = 54; x < 60; ++x) {
            const double metres = rayThrough(rim.widened(), x + 0.5, y + 0.5).x / double{rim.at(x, y).disparity};
            ++(std::abs(metres - 1) < 1e-6 ? fromNearby : fromFar);
            EXPECT_TRUE(std::abs(metres - 1) < 1e-6 || std::abs(metres - 4) < 1e-6) << metres;
        }
    EXPECT_GT(fromFar, 0);
    EXPECT_GT(fromNearby, 10 * fromFar);
}

} // namespace
} // namespace scene
