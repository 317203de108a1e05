#include "scene/view.h"

#include "tests/scene/random_poses.h"

#include <cmath>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/vec4.hpp>
#include <gtest/gtest.h>

namespace scene {
namespace {

constexpr int kViewTrials = 2000;

/// A sample (x, y, disparity) of a source image.
struct Sample {
    double x, y, disparity;
};

/// Where the warp says that an eye sees it: u, v and disparity.
glm::dvec3 warped(const glm::dmat4& eyeImageFromSource, const Sample& sample) {
    const glm::dvec4 h = eyeImageFromSource * glm::dvec4(sample.x, sample.y, 1.0, sample.disparity);
    return {h.x / h.z, h.y / h.z, h.w / h.z};
}

/// Disparities of surfaces from 0.1 mm to 100 km, and infinity.
Sample drawSample(RandomPlaces& random, const Camera& camera, int trial) {
    const double logDepth = random.between(std::log(1e-4), std::log(1e5));
    return {random.between(0, camera.width), random.between(0, camera.height),
            trial % 8 == 0 ? 0.0 : std::exp(-logDepth)};
}

class ViewFrom : public testing::TestWithParam<glm::dvec3> {};

TEST_P(ViewFrom, TheReferencePositionIsTheIdentity) {
    RandomPlaces random(1);
    for (int trial = 0; trial < kViewTrials; ++trial) {
        const Camera camera = random.camera();
        const Pose worldFromSource = random.pose(10, GetParam());
        const Sample sample = drawSample(random, camera, trial);
        const glm::dvec3 seen =
            warped(eyeImageFromSourceImage({camera, worldFromSource}, camera, worldFromSource), sample);
        EXPECT_NEAR(seen.x, sample.x, 1e-9);
        EXPECT_NEAR(seen.y, sample.y, 1e-9);
        EXPECT_NEAR(seen.z, sample.disparity, 1e-9 * sample.disparity);
    }
}

// The truth subtracts the two positions first, which is exact for places within a factor of two of each
// other: nothing of the distance to the origin may then be left in the result.
TEST_P(ViewFrom, SamplesAreSeenWhereTheirPointsProject) {
    RandomPlaces random(2);
    int seenCount = 0;
    for (int trial = 0; trial < kViewTrials; ++trial) {
        const Camera source = random.camera();
        const View eye{random.camera(), random.pose(0.5, GetParam())};
        const Pose worldFromSource = random.pose(0.5, GetParam());
        const Sample sample{random.between(0, source.width), random.between(0, source.height), random.between(0.5, 20)};

        const glm::dvec3 pInSource = rayThrough(source, sample.x, sample.y) / sample.disparity;
        const glm::dvec3 eyeToPointInWorld =
            worldFromSource.rotation * pInSource + (worldFromSource.translation - eye.worldFromEye.translation);
        const glm::dvec3 pInEye = glm::transpose(eye.worldFromEye.rotation) * eyeToPointInWorld;
        if (pInEye.z < 1e-3) continue;
        ++seenCount;

        const glm::dvec2 truth = project(eye.camera, pInEye);
        const glm::dvec3 seen = warped(eyeImageFromSourceImage(eye, source, worldFromSource), sample);
        const double slant = 1 + glm::length(truth) / glm::length(glm::dvec2(eye.camera.width, eye.camera.height));
        EXPECT_LT(glm::length(glm::dvec2(seen) - truth), 1e-8 * slant / pInEye.z);
        EXPECT_NEAR(seen.z * pInEye.z, 1.0, 1e-11 / pInEye.z);
    }
    EXPECT_GT(seenCount, kViewTrials / 4);
}

// 0.1 mm from a surface, two nanometres of error are already 0.01 pixels.
TEST_P(ViewFrom, ATenthOfAMillimetreFromASurface) {
    RandomPlaces random(3);
    const Camera camera{1024, 1024, 700, 700, 512, 512};
    for (int trial = 0; trial < kViewTrials; ++trial) {
        const Pose worldFromSource = random.pose(10, GetParam());
        const Sample sample{random.between(0, 1024), random.between(0, 1024), 0.5};
        const glm::dvec3 pInSource = rayThrough(camera, sample.x, sample.y) / sample.disparity;
        // Beside the source and before the surface, looking as the source does.
        View eye{camera, worldFromSource};
        eye.worldFromEye.translation += worldFromSource.rotation * (pInSource - glm::dvec3(0, 0, 1e-4));

        const glm::dvec3 sourceInWorldFromEye = worldFromSource.translation - eye.worldFromEye.translation;
        const glm::dvec3 pInEye = pInSource + glm::transpose(worldFromSource.rotation) * sourceInWorldFromEye;
        const glm::dvec2 truth = project(camera, pInEye);
        const glm::dvec3 seen = warped(eyeImageFromSourceImage(eye, camera, worldFromSource), sample);
        EXPECT_LT(glm::length(glm::dvec2(seen) - truth), 1e-6);
    }
}

INSTANTIATE_TEST_SUITE_P(NearAndFar, ViewFrom, testing::Values(glm::dvec3(0.0), kFarFromOrigin),
                         [](const auto& which) { return which.index == 0 ? "Origin" : "TenThousandKilometres"; });

TEST(Eyes, StandAsFarApartAsTheyShouldAndLookInParallel) {
    RandomPlaces random(4);
    const Camera camera{640, 480, 500, 510, 320, 240};
    for (int trial = 0; trial < kViewTrials; ++trial) {
        const double apart = random.between(0, 0.1);
        const Pose worldFromHead = random.pose(10, trial % 2 == 0 ? glm::dvec3(0.0) : kFarFromOrigin);
        const auto [left, right] = eyesOf(camera, worldFromHead, apart);
        EXPECT_EQ(left.camera, camera);
        EXPECT_EQ(right.camera, camera);
        EXPECT_EQ(left.worldFromEye.rotation, worldFromHead.rotation);
        EXPECT_EQ(right.worldFromEye.rotation, worldFromHead.rotation);

        const double metres = trial % 2 == 0 ? 1e-14 : 1e-8;
        const glm::dvec3 rightInWorld = worldFromHead.rotation[0];
        const glm::dvec3 leftToRight = right.worldFromEye.translation - left.worldFromEye.translation;
        EXPECT_LT(glm::length(leftToRight - apart * rightInWorld), metres);
        const glm::dvec3 middle = left.worldFromEye.translation + 0.5 * leftToRight;
        EXPECT_LT(glm::length(middle - worldFromHead.translation), metres);
    }
}

} // namespace
} // namespace scene
