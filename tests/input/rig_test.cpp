#include "input/rig.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

namespace input {

namespace {

constexpr double kPi = std::numbers::pi;

scene::Pose headAt(const glm::dvec3& place, double heading, double tilt) {
    const scene::Pose yaw = scene::poseFromQuaternion(place, 0, std::sin(heading / 2), 0, std::cos(heading / 2));
    return yaw * scene::poseFromQuaternion({0, 0, 0}, std::sin(tilt / 2), 0, 0, std::cos(tilt / 2));
}

TEST(Rig, HeadingIsToTheLeft) {
    EXPECT_NEAR(headingOf(headAt({0, 0, 0}, 0, 0).rotation), 0, 1e-12);
    const scene::Pose left = headAt({0, 0, 0}, kPi / 2, 0.3);
    EXPECT_NEAR(headingOf(left.rotation), kPi / 2, 1e-12);
    EXPECT_LT((left.rotation * glm::dvec3(0, 0, -1)).x, -0.9) << "to the left is -x for who looks along -z";
}

TEST(Rig, AHeadThatLooksStraightUpOrDownHasAHeadingStill) {
    for (const double tilt : {kPi / 2, -kPi / 2, kPi / 2 - 1e-9, -kPi / 2 + 1e-9})
        EXPECT_NEAR(headingOf(headAt({0, 0, 0}, 0.7, tilt).rotation), 0.7, 1e-6) << tilt;
}

TEST(Rig, AHeadIsBroughtToItsPlaceAndHeadingAtAnyScale) {
    for (const double scale : {0.01, 1.0, 50.0}) {
        const scene::Pose head = headAt({0.4, 1.7, -0.2}, 2.5, -0.4);
        const Rig rig = rigWithHeadAt(head, {10, 20, 30}, -1.1, scale);
        const scene::Pose walkFromHead = rig.toWalk(head);
        EXPECT_LT(glm::distance(walkFromHead.translation, glm::dvec3(10, 20, 30)), 1e-12);
        EXPECT_NEAR(headingOf(walkFromHead.rotation), -1.1, 1e-12);
        EXPECT_EQ(rig.scale, scale);
        const Rig standing = rigWithFeetAt(head, {10, 20, 30}, -1.1, scale);
        EXPECT_NEAR(standing.toWalk(head.translation).y, 20 + 1.7 * scale, 1e-12);
    }
}

TEST(Rig, TurningKeepsThePointItTurnsAbout) {
    Rig rig{{1, 2, 3}, 0.5, 3};
    const glm::dvec3 head{0.3, 1.6, -0.7}, before = rig.toWalk(head);
    rig = turned(rig, 1.25, head);
    EXPECT_LT(glm::distance(rig.toWalk(head), before), 1e-12);
    EXPECT_NEAR(rig.yaw, 1.75, 1e-12);
}

} // namespace

} // namespace input
