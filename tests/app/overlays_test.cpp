// The shapes over the scene: where their lines stand.

#include "app/overlays.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include <array>
#include <cmath>

namespace app {
namespace {

/// The capture's up is +Z and its origin far away.
scene::Pose worldFromWalk() {
    return {glm::dmat3(1, 0, 0, 0, 0, 1, 0, -1, 0), glm::dvec3(4e5, 5e6, 300)};
}

TEST(Overlays, TheFloorGridLiesOnWholeMetresOfWalkSpaceAndFades) {
    render::Overlay overlay;
    const glm::dvec3 around(10.3, 1.7, -4.6);
    addFloorGrid(overlay, worldFromWalk(), around, 0.2, 3);
    ASSERT_GT(overlay.segments.size(), 40u);
    const scene::Pose walkFromWorld = inverse(worldFromWalk());
    float nearest = 0, farthest = 1;
    for (const render::Segment& segment : overlay.segments) {
        const glm::dvec3 a = walkFromWorld * segment.a, b = walkFromWorld * segment.b;
        EXPECT_NEAR(a.y, 0.2, 1e-6);
        EXPECT_NEAR(b.y, 0.2, 1e-6);
        const bool isAlongX = std::abs(a.z - b.z) < 1e-6;
        const double line = isAlongX ? a.z : a.x;
        EXPECT_NEAR(line, std::round(line), 1e-6);
        EXPECT_LE(glm::distance(a, b), 1 + 1e-6);
        for (const glm::dvec3& p : {a, b})
            EXPECT_LE(std::hypot(p.x - around.x, p.z - around.z), 3 + 1e-6);
        const glm::dvec3 middle = (a + b) / 2.0;
        const double away = std::hypot(middle.x - around.x, middle.z - around.z);
        if (away < 1) nearest = std::max(nearest, segment.opacity);
        if (away > 2.5) farthest = std::min(farthest, segment.opacity);
    }
    EXPECT_GT(nearest, 0.5f);
    EXPECT_LT(farthest, 0.2f);
}

TEST(Overlays, AGridAroundNowhereIsEmpty) {
    render::Overlay overlay;
    addFloorGrid(overlay, {}, glm::dvec3(std::nan("")), 0, 3);
    addFloorGrid(overlay, {}, glm::dvec3(0), 0, 1e9);
    EXPECT_TRUE(overlay.empty());
}

TEST(Overlays, TheTeleportEndsInARingWhoseColourSaysWhetherItIsAllowed) {
    const std::array<glm::dvec3, 3> beam{{{0, 1.5, 0}, {0, 1.6, -1}, {0, 0, -2}}};
    for (const bool isAllowed : {true, false}) {
        render::Overlay overlay;
        addTeleport(overlay, beam, {0, 1, 0}, isAllowed);
        ASSERT_GT(overlay.segments.size(), 30u);
        for (const render::Segment& segment : overlay.segments)
            EXPECT_EQ(segment.colour, isAllowed ? kAllowedColour : kRefusedColour);
        // After the beam's two lines comes the ring.
        for (std::size_t i = 2; i < 34; ++i) {
            const glm::dvec3 fromMiddle = overlay.segments[i].a - glm::dvec3(0, 0.005, -2);
            EXPECT_NEAR(glm::length(fromMiddle), 0.25, 1e-9);
            EXPECT_NEAR(fromMiddle.y, 0, 1e-9);
        }
    }
    render::Overlay none;
    addTeleport(none, {}, {0, 1, 0}, true);
    EXPECT_TRUE(none.empty());
}

TEST(Overlays, ADistanceHasItsBarsAtRightAngles) {
    const auto barsOf = [](const glm::dvec3& from, const glm::dvec3& to) {
        render::Overlay overlay;
        addDistance(overlay, {}, from, to);
        for (std::size_t i = 1; i < overlay.segments.size(); ++i)
            EXPECT_NEAR(glm::dot(overlay.segments[i].b - overlay.segments[i].a, to - from), 0, 1e-9);
        return overlay.segments.size() - 1;
    };
    EXPECT_EQ(barsOf({0, 0, 0}, {0.55, 0, 0}), 2u + 5);
    EXPECT_EQ(barsOf({1, 0, 0}, {1, 4.5, 0}), 2u + 4) << "upright: another direction has to do";
    EXPECT_EQ(barsOf({0, 0, 0}, {3, 3, 3}), 2u + 5);
    EXPECT_EQ(barsOf({0, 0, 0}, {0, 0, 0}), 0u);
}

TEST(Overlays, OfManyCamerasTheNearestAreShown) {
    std::vector<scene::SceneImage> images;
    for (int i = 0; i < 20; ++i)
        images.push_back({std::to_string(i), {100, 80, 50, 50, 50, 40}, {glm::dmat3(1.0), glm::dvec3(i, 0, 0)}});
    render::Overlay overlay;
    addCameras(overlay, images, {12.2, 0, 0}, 0.1, 3);
    ASSERT_EQ(overlay.segments.size(), 3u * 10);
    EXPECT_EQ(overlay.segments[0].a.x, 12);
    for (const render::Segment& segment : overlay.segments)
        EXPECT_NEAR(segment.a.x, 12, 1.11);
    // A corner is a tenth of a metre along the camera's depth.
    EXPECT_NEAR(overlay.segments[0].b.z, 0.1, 1e-12);
    EXPECT_NEAR(overlay.segments[0].b.x, 12 - 0.1, 1e-12);
}

} // namespace
} // namespace app
