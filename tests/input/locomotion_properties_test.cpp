// What holds of locomotion whatever the walker wants: seeded wishes by the thousand, and numbers that are none.

#include "tests/input/walker.h"

#include "scene/synthetic_random.h"
#include "tests/repetitions.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

namespace input {

namespace {

TEST(Locomotion, NoNumberThrowsTheWalkerOutOfTheWorld) {
    constexpr double kInf = std::numeric_limits<double>::infinity();
    const double bad[] = {std::numeric_limits<double>::quiet_NaN(), kInf, -kInf, 1e308, -1e308, 1e30, 1e-320, -0.0};
    scene::SeededSequence random(11);
    const auto any = [&] { return random.between(-1, 1); };
    const auto spoil = [&](double& value) {
        if (any() > 0.8) value = bad[random.bits() % std::size(bad)];
    };
    const auto spoilPose = [&](scene::Pose& pose) {
        for (int i = 0; i < 3; ++i)
            if (any() > 0.9) spoil(pose.translation[i]), spoil(pose.rotation[i][static_cast<int>(random.bits() % 3)]);
        if (any() > 0.98) pose.rotation = glm::dmat3(0);
    };
    Surroundings surroundings = room();
    surroundings.hit = [hit = surroundings.hit, &spoil](const glm::dvec3& from, const glm::dvec3& d) {
        EXPECT_NEAR(glm::length(d), 1, 1e-9);
        EXPECT_TRUE(std::isfinite(from.x + from.y + from.z));
        std::optional<Surface> surface = hit(from, d);
        if (surface) spoil(surface->position.x), spoil(surface->normal.y);
        return surface;
    };
    surroundings.captures.push_back(poseAt({kInf, 0, 0}));
    Locomotion state;
    for (int i = 0; i < 200000; ++i) {
        Wants wants = standing();
        spoil(wants.seconds), spoil(wants.move.x), spoil(wants.move.y), spoil(wants.climb), spoil(wants.turn);
        spoil(wants.turnBy), spoil(wants.speedUp), spoil(wants.scaleUp), spoil(wants.riseBy);
        spoilPose(wants.trackingFromHead);
        for (Hand& hand : wants.hands) {
            hand.isTracked = any() > -0.9, hand.grabs = any() > 0.5, hand.teleports = any() > 0.5;
            hand.trackingFromGrip = hand.trackingFromAim = poseAt({any(), 1, any()}, 3 * any(), -1);
            spoilPose(hand.trackingFromGrip), spoilPose(hand.trackingFromAim);
        }
        wants.next = any() > 0.9, wants.recentre = any() > 0.9;
        state = step(state, wants, {}, surroundings);
        ASSERT_LT(glm::length(state.rig.origin), 1e9) << i;
        ASSERT_LE(std::abs(state.rig.yaw), std::numbers::pi) << i;
        ASSERT_GT(state.rig.scale, 0) << i;
        ASSERT_LT(speedOf(state, {}), 1e7) << i;
        ASSERT_TRUE(state.vignette >= 0 && state.vignette <= 1) << i;
        // It is drawn, also where it is refused.
        if (state.target) {
            ASSERT_LT(glm::length(state.target->to), 2e9) << i;
        }
    }
}

TEST(Locomotion, ATurnBackUndoesATurn) {
    scene::SeededSequence random(5);
    const auto any = [&] { return random.between(-1, 1); };
    for (int i = 0; i < 1000; ++i) {
        Locomotion state;
        state.rig = {{100 * any(), any(), 100 * any()}, 3 * any(), std::exp(3 * any())};
        const Rig before = state.rig;
        Wants wants = standing();
        wants.trackingFromHead = poseAt({any(), 1.6, any()}, 3 * any(), any());
        const double by = 10 * any();
        const glm::dvec3 head = headOf(state, wants);
        for (const double radians : {by, -by}) {
            wants.turnBy = radians, state = step(state, wants, {}, room());
            EXPECT_LT(glm::distance(headOf(state, wants), head), 1e-9) << "about the head";
        }
        wants.turnBy = 0;
        for (const double stick : {1.0, 0.0, -1.0, 0.0})
            wants.turn = stick, state = step(state, wants, {}, room());
        EXPECT_LT(glm::distance(state.rig.origin, before.origin), 1e-9);
        EXPECT_NEAR(std::remainder(state.rig.yaw - before.yaw, 2 * std::numbers::pi), 0, 1e-9);
    }
}

/// Everything of walk space s times as large.
Surroundings enlarged(Surroundings surroundings, double s) {
    surroundings.hit = [hit = surroundings.hit, s](const glm::dvec3& from, const glm::dvec3& d) {
        std::optional<Surface> surface = hit(from / s, d);
        if (surface) surface->position *= s;
        return surface;
    };
    return surroundings;
}

TEST(Locomotion, InAWorldOfAnotherSizeEverythingFeelsTheSame) {
    for (const double s : {0.01, 30.0}) {
        scene::SeededSequence random(9);
        const auto any = [&] { return random.between(-1, 1); };
        const Surroundings plain = room(), large = enlarged(plain, s);
        Locomotion a, b;
        int teleports = 0;
        Wants wants = standing();
        for (int i = 0; i < 3000; ++i) {
            if (i % 100 == 0) {
                // Before chance has brought either to the limits of size, which are the same for both.
                a.rig = {{0.5, 0.5, -1}, 0.3, 1};
                b.rig = {s * a.rig.origin, 0.3, s};
                a.held = b.held = {};
            }
            wants.trackingFromHead.translation = {0.3 * any(), 1.6, 0.3 * any()};
            wants.move = {any(), any()}, wants.climb = 0.1 * any(), wants.turn = any();
            wants.riseBy = 0.01 * any(), wants.hurries = any() > 0;
            wants.recentre = any() > 0.95;
            for (Hand& hand : wants.hands) {
                hand.isTracked = true;
                if (any() > 0.8) hand.grabs = !hand.grabs;
                if (any() > 0.8) hand.teleports = !hand.teleports;
                hand.trackingFromAim = poseAt({0, 1.2, 0}, 3 * any(), -0.8 + 0.5 * any());
            }
            // About the same distance apart, so that two hands turn and move the world and change its size little.
            wants.hands[0].trackingFromGrip = poseAt({-0.3, 1.2, 0.3 * any()});
            wants.hands[1].trackingFromGrip = poseAt({0.3, 1.2, 0.3 * any()});
            const bool wasAllowed = a.target && a.target->isAllowed();
            a = step(a, wants, {}, plain), b = step(b, wants, {}, large);
            teleports += wasAllowed && !a.target ? 1 : 0;
            ASSERT_NEAR(b.rig.scale / s, a.rig.scale, 1e-6 * a.rig.scale) << i;
            ASSERT_LT(glm::distance(b.rig.origin / s, a.rig.origin), 1e-6 * (1 + glm::length(a.rig.origin))) << i;
            ASSERT_NEAR(std::remainder(b.rig.yaw - a.rig.yaw, 2 * std::numbers::pi), 0, 1e-6) << i;
            ASSERT_EQ(a.target.has_value() && a.target->isAllowed(), b.target.has_value() && b.target->isAllowed());
        }
        EXPECT_GT(teleports, 20) << "or nothing was compared";
    }
}

TEST(Locomotion, AMillionStepsDoNotDrift) {
    Locomotion state;
    state.rig = {{120, 3, -45}, 0.4, 1.5};
    Wants wants = standing();
    const glm::dvec3 head = headOf(state, wants);
    const double heading = headingOf(state, wants);
    const auto stepOn = [&] { state = step(state, wants, {}, {}); };
    wants.hands[0].isTracked = true;
    for (int round = 0; round < 36000; ++round) {
        for (int snap = 0; snap < 12; ++snap)
            for (const double stick : {1.0, 0.0})
                wants.turn = stick, stepOn();
        // The world pulled near, pushed back, and let go.
        wants.hands[0].grabs = true;
        for (const double z : {0.0, 0.3, 0.0})
            wants.hands[0].trackingFromGrip.translation = {0, 1, z}, stepOn();
        wants.hands[0].grabs = false, stepOn();
    }
    EXPECT_NEAR(std::remainder(headingOf(state, wants) - heading, 2 * std::numbers::pi), 0, kHundredthOfADegree);
    EXPECT_LT(glm::distance(headOf(state, wants), head), kMillimetre);
}

TEST(Locomotion, AMillionWishesTiltNothingAndStayFinite) {
    scene::SeededSequence random(7);
    const auto any = [&] { return random.between(-1, 1); };
    const Surroundings surroundings = room();
    Locomotion state;
    for (int i = 0; i < tests::repetitions(1000000); ++i) {
        Wants wants = standing();
        wants.trackingFromHead = poseAt({any(), 1.6 + 0.3 * any(), any()}, 3 * any(), any());
        wants.move = {any(), any()}, wants.turn = any(), wants.turnBy = 0.1 * any();
        for (Hand& hand : wants.hands) {
            hand.isTracked = any() > -0.9;
            hand.grabs = any() > 0.5, hand.teleports = any() > 0.8;
            hand.trackingFromGrip = hand.trackingFromAim = poseAt({any(), 1 + any(), any()}, 3 * any(), any());
        }
        wants.home = any() > 0.99, wants.recentre = any() > 0.99, wants.next = any() > 0.99;
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
