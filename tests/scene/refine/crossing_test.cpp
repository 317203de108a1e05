#include "scene/refine/crossing.h"

#include "tests/scene/known_scenes.h"

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <gtest/gtest.h>

namespace scene {
namespace {

/// The plane z = 0 of the world, from a place on either side: looking across it, turned about the upright.
DepthImage planeFrom(const glm::dvec3& place, double turnDegrees) {
    const double half = glm::radians(turnDegrees) / 2 + (place.z > 0 ? glm::radians(90.0) : 0);
    const Pose pose = poseFromQuaternion(place, 0, std::sin(half), 0, std::cos(half));
    const glm::dvec3 normal = glm::transpose(pose.rotation) * glm::dvec3(0, 0, 1);
    return imageOf(smallCamera(), pose,
                   [&](double x, double y) { return planeDisparity(smallCamera(), normal, -place.z, x, y); });
}

/// Of the sample in the middle of the image.
Crossing crossingInMiddle(const DepthImage& image, const DepthImage& partner) {
    const Reprojection into = reprojectionInto(partner, image);
    const Camera& c = image.camera;
    const auto x = static_cast<float>(c.cx), y = static_cast<float>(c.cy);
    const float disparity =
        static_cast<float>(planeDisparity(c, glm::transpose(image.worldFromCamera.rotation) * glm::dvec3(0, 0, 1),
                                          -image.worldFromCamera.translation.z, c.cx, c.cy));
    const Sighting at = sightingOf(into, x, y, disparity);
    EXPECT_TRUE(isSeenIn(partner.camera, at));
    return crossingOf(partner, into, x, y, disparity, at, 0.02f);
}

TEST(Crossing, OfAPlaneIsHowFarOneStandsBeforeItByHowFarTheOtherDoes) {
    const DepthImage squarely = planeFrom({0, 0, -6}, 0), slanted = planeFrom({-1, 0.2, -4}, 14);
    EXPECT_NEAR(crossingInMiddle(squarely, slanted).change, 6.0 / 4, 1e-3);
    EXPECT_NEAR(crossingInMiddle(slanted, squarely).change, 4.0 / 6, 1e-3);
    EXPECT_TRUE(crossingInMiddle(slanted, squarely).isFromFront());
    const DepthImage across = planeFrom({0.5, 0, 5}, -8);
    EXPECT_NEAR(crossingInMiddle(squarely, across).change, -6.0 / 5, 1e-3);
    EXPECT_NEAR(crossingInMiddle(across, slanted).change, -5.0 / 4, 1e-3);
    EXPECT_TRUE(crossingInMiddle(across, slanted).isFromBehind());
    // Right before the plane, by what the other stands from it.
    const DepthImage near = planeFrom({0, 0, 0.3}, 0);
    EXPECT_NEAR(crossingInMiddle(near, squarely).change, -0.05, 1e-3);
    EXPECT_FALSE(crossingInMiddle(near, squarely).isFromFront());
    EXPECT_FALSE(crossingInMiddle(near, squarely).isFromBehind());
    EXPECT_NEAR(crossingInMiddle(squarely, near).change, -20, 0.05);
}

} // namespace
} // namespace scene
