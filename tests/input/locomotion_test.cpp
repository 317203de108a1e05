#include "input/locomotion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <glm/geometric.hpp>

namespace input {

namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kMillimetre = 1e-3, kHundredthOfADegree = 0.01 * kDegree;

scene::Pose poseAt(const glm::dvec3& place, double heading = 0, double tilt = 0) {
    const scene::Pose yaw = scene::poseFromQuaternion(place, 0, std::sin(heading / 2), 0, std::cos(heading / 2));
    return yaw * scene::poseFromQuaternion({0, 0, 0}, std::sin(tilt / 2), 0, 0, std::cos(tilt / 2));
}

Wants standing() {
    Wants wants;
    wants.seconds = 1.0 / 90;
    wants.trackingFromHead = poseAt({0.2, 1.6, 0.1}, 20 * kDegree, -10 * kDegree);
    return wants;
}

/// A floor at y = 0.5, seen from above, and a wall at z = -5, for rays from before them.
Surroundings room() {
    Surroundings surroundings;
    surroundings.hit = [](const glm::dvec3& from, const glm::dvec3& d) -> std::optional<Surface> {
        const double toFloor = d.y < 0 ? (0.5 - from.y) / d.y : std::numeric_limits<double>::infinity();
        const double toWall = d.z < 0 ? (-5 - from.z) / d.z : std::numeric_limits<double>::infinity();
        if (std::isinf(toFloor) && std::isinf(toWall)) return std::nullopt;
        if (toFloor < toWall) return Surface{from + toFloor * d, {0, 1, 0}};
        return Surface{from + toWall * d, {0, 0, 1}};
    };
    surroundings.captures = {poseAt({1, 1.2, 1}, 0.3, 0.2), poseAt({2, 1.3, 1}, -0.4), poseAt({3, 1.4, 1}, 2)};
    surroundings.homeFeet = {0.5, 0, 0.25};
    surroundings.homeHeading = 0.1;
    return surroundings;
}

glm::dvec3 headOf(const Locomotion& state, const Wants& wants) {
    return state.rig.toWalk(wants.trackingFromHead.translation);
}
double headingOf(const Locomotion& state, const Wants& wants) {
    return input::headingOf(state.rig.toWalk(wants.trackingFromHead).rotation);
}

TEST(Locomotion, WhoWantsNothingStaysWhereTheyAre) {
    Locomotion state;
    state.rig = {{1, 2, 3}, 0.7, 2};
    const Locomotion after = step(state, standing(), {}, room());
    EXPECT_EQ(after.rig.origin, state.rig.origin);
    EXPECT_EQ(after.rig.yaw, state.rig.yaw);
    EXPECT_EQ(after.rig.scale, state.rig.scale);
    EXPECT_EQ(after.vignette, 0);
}

TEST(Locomotion, TeleportPutsTheFeetOnTheSeenFloorAndKeepsTheHeading) {
    Locomotion state;
    state.rig = {{0, 0.5, 0}, 0.4, 1};
    Wants wants = standing();
    wants.hands[1].isTracked = wants.hands[1].teleports = true;
    wants.hands[1].trackingFromAim = poseAt({0.3, 1.2, 0}, 0, -30 * kDegree);
    const double heading = headingOf(state, wants);
    state = step(state, wants, {}, room());
    ASSERT_TRUE(state.target);
    EXPECT_TRUE(state.target->isAllowed);
    // The hand is 1.2 m over the floor and points 30 degrees down, 0.4 to the left.
    const glm::dvec3 from = Rig{{0, 0.5, 0}, 0.4, 1}.toWalk(glm::dvec3{0.3, 1.2, 0});
    const double run = 1.2 / std::tan(30 * kDegree);
    const glm::dvec3 expected{from.x - run * std::sin(0.4), 0.5, from.z - run * std::cos(0.4)};
    EXPECT_LT(glm::distance(state.target->to, expected), kMillimetre);

    wants.hands[1].teleports = false;
    state = step(state, wants, {}, room());
    EXPECT_FALSE(state.target);
    const glm::dvec3 head = headOf(state, wants);
    EXPECT_LT(glm::distance(head, expected + glm::dvec3(0, 1.6, 0)), kMillimetre);
    EXPECT_NEAR(headingOf(state, wants), heading, kHundredthOfADegree);
}

TEST(Locomotion, NobodyTeleportsOntoWallsIntoTheUnseenOrTooFar) {
    LocomotionSettings settings;
    const auto tryIt = [&](double tilt, double reach) {
        settings.reachMetres = reach;
        Locomotion state;
        state.rig.origin.y = 0.5;
        Wants wants = standing();
        wants.hands[0].isTracked = wants.hands[0].teleports = true;
        wants.hands[0].trackingFromAim = poseAt({0, 1.2, 0}, 0, tilt);
        state = step(state, wants, settings, room());
        EXPECT_TRUE(state.target && !state.target->isAllowed);
        const Rig before = state.rig;
        wants.hands[0].teleports = false;
        state = step(state, wants, settings, room());
        EXPECT_EQ(state.rig.origin, before.origin);
    };
    tryIt(-5 * kDegree, 20); // the wall
    tryIt(60 * kDegree, 20); // over the wall's foot only up: still the wall
    tryIt(-30 * kDegree, 2); // 2.4 m away
    Locomotion state;
    Wants wants = standing();
    wants.hands[0].isTracked = wants.hands[0].teleports = true;
    wants.hands[0].trackingFromAim = poseAt({0, 1.2, 0}, std::numbers::pi, 10 * kDegree);
    state = step(state, wants, settings, room());
    ASSERT_TRUE(state.target);
    EXPECT_FALSE(state.target->isAllowed) << "nothing was seen there";
}

TEST(Locomotion, AHandThatIsLostWhileAimingGoesNowhere) {
    Locomotion state;
    Wants wants = standing();
    wants.hands[0].isTracked = wants.hands[0].teleports = true;
    wants.hands[0].trackingFromAim = poseAt({0, 1.2, 0}, 0, -40 * kDegree);
    state = step(state, wants, {}, room());
    ASSERT_TRUE(state.target && state.target->isAllowed);
    wants.hands[0].isTracked = false;
    state = step(state, wants, {}, room());
    wants.hands[0].teleports = false;
    state = step(state, wants, {}, room());
    EXPECT_EQ(state.rig.origin, glm::dvec3(0));
}

TEST(Locomotion, TheStickSnapsOnceAndOnlyAgainAfterItWasLetGo) {
    for (const double degrees : {15.0, 30.0, 45.0}) {
        LocomotionSettings settings;
        settings.snapDegrees = degrees;
        Locomotion state;
        Wants wants = standing();
        const glm::dvec3 head = headOf(state, wants);
        const double before = headingOf(state, wants);
        for (const double stick : {0.2, 0.5, 0.8, 1.0, 0.9, 0.6, 0.75, 0.5})
            wants.turn = stick, state = step(state, wants, settings, room());
        EXPECT_NEAR(headingOf(state, wants), before - degrees * kDegree, kHundredthOfADegree) << "to the right, once";
        for (const double stick : {0.1, 0.8})
            wants.turn = stick, state = step(state, wants, settings, room());
        for (const double stick : {0.0, -0.9, -1.0, 0.0, -0.9})
            wants.turn = stick, state = step(state, wants, settings, room());
        EXPECT_NEAR(headingOf(state, wants), before, kHundredthOfADegree) << "two right, two left";
        EXPECT_LT(glm::distance(headOf(state, wants), head), kMillimetre) << "about the head";
        EXPECT_EQ(state.vignette, 0) << "a snap shows nothing that moves";
    }
}

TEST(Locomotion, SmoothTurnsTakeTheirTime) {
    LocomotionSettings settings;
    settings.snapDegrees = 0;
    settings.turnDegreesPerSecond = 60;
    Locomotion state;
    Wants wants = standing();
    wants.turn = -0.5;
    for (int i = 0; i < 90; ++i)
        state = step(state, wants, settings, room());
    EXPECT_NEAR(state.rig.yaw, 30 * kDegree, kHundredthOfADegree);
    EXPECT_GT(state.vignette, 0.99);
}

TEST(Locomotion, WalkingFollowsTheHeadingAndStaysLevel) {
    Locomotion state;
    Wants wants = standing();
    wants.move = {0, 1};
    for (int i = 0; i < 90; ++i)
        state = step(state, wants, {}, room());
    const glm::dvec3 expected{-1.4 * std::sin(20 * kDegree), 0, -1.4 * std::cos(20 * kDegree)};
    EXPECT_LT(glm::distance(state.rig.origin, expected), kMillimetre);
    EXPECT_GT(state.vignette, 0.9);
    wants.move = {0, 0};
    for (int i = 0; i < 180; ++i)
        state = step(state, wants, {}, room());
    EXPECT_EQ(state.vignette, 0);

    LocomotionSettings flying;
    flying.flies = true;
    wants.move = {0, 1};
    const double height = state.rig.origin.y;
    state = step(state, wants, flying, room());
    EXPECT_NEAR(state.rig.origin.y - height, -std::sin(10 * kDegree) * 1.4 / 90, 1e-6);
}

TEST(Locomotion, OneHandDragsTheWorldUnderIt) {
    Locomotion state;
    state.rig = {{5, 0, 5}, 1, 2};
    Wants wants = standing();
    wants.hands[0].isTracked = wants.hands[0].grabs = true;
    wants.hands[0].trackingFromGrip = poseAt({0.1, 1.1, -0.4});
    const glm::dvec3 held = state.rig.toWalk(glm::dvec3{0.1, 1.1, -0.4});
    state = step(state, wants, {}, room());
    wants.hands[0].trackingFromGrip = poseAt({-0.3, 1.4, -0.1}, 1, 1);
    state = step(state, wants, {}, room());
    EXPECT_LT(glm::distance(state.rig.toWalk(glm::dvec3{-0.3, 1.4, -0.1}), held), kMillimetre);
    EXPECT_EQ(state.rig.yaw, 1);
    EXPECT_EQ(state.rig.scale, 2);
}

TEST(Locomotion, TwoHandsTurnAndScaleTheWorldBetweenThem) {
    Locomotion state;
    state.rig = {{5, 0, 5}, 0.3, 1};
    Wants wants = standing();
    for (Hand& hand : wants.hands)
        hand.isTracked = hand.grabs = true;
    const glm::dvec3 left{-0.2, 1.2, -0.4}, right{0.2, 1.2, -0.4};
    wants.hands[0].trackingFromGrip = poseAt(left), wants.hands[1].trackingFromGrip = poseAt(right);
    const glm::dvec3 heldLeft = state.rig.toWalk(left), heldRight = state.rig.toWalk(right);
    state = step(state, wants, {}, room());
    // Twice as far apart, turned by 90 degrees to the left seen from above.
    const glm::dvec3 newLeft{0.1, 1.3, 0.1}, newRight{0.1, 1.3, -0.7};
    wants.hands[0].trackingFromGrip = poseAt(newLeft), wants.hands[1].trackingFromGrip = poseAt(newRight);
    state = step(state, wants, {}, room());
    EXPECT_LT(glm::distance(state.rig.toWalk(newLeft), heldLeft), kMillimetre);
    EXPECT_LT(glm::distance(state.rig.toWalk(newRight), heldRight), kMillimetre);
    EXPECT_NEAR(state.rig.scale, 0.5, 1e-9);
    EXPECT_NEAR(state.rig.yaw, 0.3 - 90 * kDegree, kHundredthOfADegree);
    // Letting one hand go moves nothing.
    const Rig before = state.rig;
    wants.hands[1].grabs = false;
    state = step(state, wants, {}, room());
    state = step(state, wants, {}, room());
    EXPECT_LT(glm::distance(state.rig.origin, before.origin), 1e-9);
    EXPECT_EQ(state.rig.scale, before.scale);
}

TEST(Locomotion, RecentreBringsTheHeadToTheRigsPlaceAndHeading) {
    Locomotion state;
    state.rig = {{3, 0.2, -4}, 0.9, 1};
    Wants wants = standing();
    const double height = headOf(state, wants).y;
    wants.recentre = true;
    state = step(state, wants, {}, room());
    EXPECT_LT(glm::distance(headOf(state, wants), glm::dvec3(3, height, -4)), kMillimetre);
    EXPECT_NEAR(headingOf(state, wants), 0.9, kHundredthOfADegree);
}

TEST(Locomotion, HomeIsWhereTheSceneBegins) {
    Locomotion state;
    state.rig = {{3, 9, -4}, 0.9, 7};
    Wants wants = standing();
    wants.home = true;
    state = step(state, wants, {}, room());
    EXPECT_LT(glm::distance(headOf(state, wants), glm::dvec3(0.5, 1.6, 0.25)), kMillimetre);
    EXPECT_NEAR(headingOf(state, wants), 0.1, kHundredthOfADegree);
    EXPECT_EQ(state.rig.scale, 1);
}

TEST(Locomotion, NextAndPreviousGoThroughTheScannersPlaces) {
    const Surroundings surroundings = room();
    Locomotion state;
    const auto go = [&](bool next) {
        Wants wants = standing();
        wants.next = next, wants.previous = !next;
        state = step(state, wants, {}, surroundings);
        const scene::Pose& place = surroundings.captures[*state.capture];
        EXPECT_LT(glm::distance(headOf(state, wants), place.translation), kMillimetre) << "the eyes stand there";
        EXPECT_NEAR(headingOf(state, wants), input::headingOf(place.rotation), kHundredthOfADegree);
        return *state.capture;
    };
    EXPECT_EQ(go(true), 0u);
    EXPECT_EQ(go(true), 1u);
    EXPECT_EQ(go(true), 2u);
    EXPECT_EQ(go(true), 0u);
    EXPECT_EQ(go(false), 2u);
    state = {};
    EXPECT_EQ(go(false), 2u) << "from the start back is the last";
}

TEST(Locomotion, ALargerWorldGrowsFromUnderTheFeetAndFeelsAsFast) {
    Locomotion state;
    Wants wants = standing();
    const glm::dvec3 feet = state.rig.toWalk(glm::dvec3{0.2, 0, 0.1});
    wants.scaleUp = 3;
    state = step(state, wants, {}, room());
    EXPECT_NEAR(state.rig.scale, std::pow(1.1, -3), 1e-12);
    EXPECT_LT(glm::distance(state.rig.toWalk(glm::dvec3{0.2, 0, 0.1}), feet), kMillimetre);
    EXPECT_NEAR(speedOf(state, {}) / state.rig.scale, 1.4, 1e-12);
    wants.scaleUp = 0, wants.riseBy = 0.1;
    const double eye = headOf(state, wants).y;
    state = step(state, wants, {}, room());
    EXPECT_NEAR(headOf(state, wants).y - eye, 0.1 * state.rig.scale, 1e-12);
}

TEST(Locomotion, BadNumbersAndLongPausesMoveNobodyFar) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    Locomotion state;
    Wants wants = standing();
    wants.move = {nan, nan}, wants.turn = nan, wants.climb = nan, wants.turnBy = nan, wants.scaleUp = nan;
    wants.riseBy = nan, wants.speedUp = nan;
    state = step(state, wants, {}, room());
    EXPECT_EQ(state.rig.origin, glm::dvec3(0));
    EXPECT_EQ(state.rig.yaw, 0);
    wants = standing();
    wants.trackingFromHead.translation.x = nan;
    wants.move = {0, 1};
    state = step(state, wants, {}, room());
    EXPECT_EQ(state.rig.origin, glm::dvec3(0));
    wants = standing();
    wants.move = {0, 1};
    for (const double seconds : {3600.0, -5.0, nan, std::numeric_limits<double>::infinity()}) {
        wants.seconds = seconds;
        const glm::dvec3 before = state.rig.origin;
        state = step(state, wants, {}, room());
        EXPECT_LE(glm::distance(state.rig.origin, before), 0.1 * 1.4 + 1e-9) << seconds;
    }
}

TEST(Locomotion, AMillionWishesTiltNothingAndStayFinite) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> any(-1, 1);
    const Surroundings surroundings = room();
    Locomotion state;
    for (int i = 0; i < 1000000; ++i) {
        Wants wants = standing();
        wants.trackingFromHead =
            poseAt({any(random), 1.6 + 0.3 * any(random), any(random)}, 3 * any(random), any(random));
        wants.move = {any(random), any(random)}, wants.turn = any(random), wants.turnBy = 0.1 * any(random);
        for (Hand& hand : wants.hands) {
            hand.isTracked = any(random) > -0.9;
            hand.grabs = any(random) > 0.5, hand.teleports = any(random) > 0.8;
            hand.trackingFromGrip = hand.trackingFromAim =
                poseAt({any(random), 1 + any(random), any(random)}, 3 * any(random), any(random));
        }
        wants.home = any(random) > 0.99, wants.recentre = any(random) > 0.99, wants.next = any(random) > 0.99;
        state = step(state, wants, {}, surroundings);
    }
    const glm::dmat3 r = state.rig.rotation();
    EXPECT_EQ(r[1], glm::dvec3(0, 1, 0)) << "the horizon";
    EXPECT_NEAR(glm::dot(r[0], r[2]), 0, 1e-15);
    EXPECT_NEAR(glm::length(r[0]), 1, 1e-12);
    EXPECT_TRUE(std::isfinite(state.rig.origin.x + state.rig.origin.y + state.rig.origin.z + state.rig.scale));
}

} // namespace

} // namespace input
