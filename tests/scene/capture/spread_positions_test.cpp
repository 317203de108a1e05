#include "scene/capture/spread_positions.h"

#include "scene/capture/free_space.h"
#include "scene/errors.h"

#include "tests/scene/capture/known_polygons.h"
#include "tests/scene/scratch_folder.h"

#include <gtest/gtest.h>

namespace scene {
namespace {

/// A hall of 12 x 4 x 8 m with eight pillars, a table, and a bare closet behind a wall.
PolygonScene hall() {
    PolygonScene scene = sceneOf(boxMesh({-6, 0, -4}, {6, 4, 4}, true));
    for (int i = 0; i < 8; ++i) {
        const auto x = static_cast<float>(-4.5 + 3 * (i % 4)), z = i < 4 ? -2.5f : 2.5f;
        addMesh(scene, boxMesh({x - 0.3f, 0, z - 0.3f}, {x + 0.3f, 4, z + 0.3f}, false), glm::vec3(0.5f));
    }
    addMesh(scene, boxMesh({-0.5f, 0, -0.5f}, {0.5f, 0.8f, 0.5f}, false), glm::vec3(0.5f));
    addMesh(scene, boxMesh({6.2f, 0, -4}, {9, 4, 4}, true), glm::vec3(0.5f));
    return scene;
}

TEST(SpreadPositions, StandInTheHallAndApart) {
    const PolygonScene scene = hall();
    const PolygonTracer tracer(scene);
    const std::vector<glm::dvec3> positions = spreadPositions(tracer, 8);
    ASSERT_EQ(positions.size(), 8u);
    double nearest = 1e9;
    for (std::size_t i = 0; i < positions.size(); ++i) {
        const glm::dvec3& p = positions[i];
        EXPECT_NEAR(p.y, 1.6, 1e-6) << "over the floor, not over the table";
        EXPECT_LT(std::abs(p.x), 5.71) << "in the hall: the closet has nothing to show";
        EXPECT_LT(std::abs(p.z), 3.71);
        const Surroundings about = lookRound(tracer, p);
        EXPECT_FALSE(isInsideSolid(about));
        EXPECT_GE(about.nearestMetres, 0.3);
        for (std::size_t j = 0; j < i; ++j)
            nearest = std::min(nearest, glm::distance(p, positions[j]));
    }
    EXPECT_GT(nearest, 2.0) << "eight on 96 square metres have 3.5 m each way";
    EXPECT_EQ(spreadPositions(tracer, 8), positions);
    EXPECT_EQ(spreadPositions(tracer, 1).size(), 1u);
}

TEST(SpreadPositions, AHouseOfTwoFloorsGetsBoth) {
    PolygonScene scene = sceneOf(boxMesh({-4, 0, -4}, {4, 2.8f, 4}, true));
    addMesh(scene, boxMesh({-4, 3, -4}, {4, 5.8f, 4}, true), glm::vec3(0.5f));
    const PolygonTracer tracer(scene);
    int above = 0;
    for (const glm::dvec3& p : spreadPositions(tracer, 6))
        above += p.y > 3;
    EXPECT_GE(above, 2);
    EXPECT_LE(above, 4);
}

TEST(SpreadPositions, WhereThereIsNoRoomAFailureSaysSo) {
    const PolygonScene scene = sceneOf(boxMesh({-4, 0, -4}, {4, 3, 4}, true));
    const PolygonTracer tracer(scene);
    EXPECT_NE(failureOf<Failure>([&] { spreadPositions(tracer, 100000); }).find("has room for"), std::string::npos);
}

TEST(SpreadPositions, BareGroundIsStoodOnAndARoomTurnedInsideOutIsToldOf) {
    PolygonMesh ground;
    addRectangle(ground, {-5, 0, -5}, {0, 0, 10}, {10, 0, 0});
    const PolygonScene bare = sceneOf(std::move(ground));
    const std::vector<glm::dvec3> positions = spreadPositions(PolygonTracer(bare), 3);
    ASSERT_EQ(positions.size(), 3u);
    for (const glm::dvec3& p : positions)
        EXPECT_NEAR(p.y, 1.6, 1e-6);

    const PolygonScene turned = sceneOf(boxMesh({-4, 0, -4}, {4, 3, 4}, false));
    for (const int count : {1, 4})
        EXPECT_NE(failureOf<Failure>([&] { spreadPositions(PolygonTracer(turned), count); }).find("shows its back"),
                  std::string::npos);
    EXPECT_NE(failureOf<Failure>([&] { standingPlaces(PolygonTracer(turned)); }).find("shows its back"),
              std::string::npos);
}

} // namespace
} // namespace scene
