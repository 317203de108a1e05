#include "scene/capture/free_space.h"

#include "scene/errors.h"

#include "scene/directions.h"
#include "tests/scene/capture/known_polygons.h"
#include "tests/scene/scratch_folder.h"

#include <gtest/gtest.h>

namespace scene {
namespace {

/// A room with a solid pillar about (0, 1.5, 0).
PolygonScene roomWithPillar() {
    PolygonScene scene = sceneOf(boxMesh({-5, 0, -5}, {5, 3, 5}, true));
    addMesh(scene, boxMesh({-0.4f, 0, -0.4f}, {0.4f, 3, 0.4f}, false), glm::vec3(0.5f));
    return scene;
}

TEST(FreeSpace, APillarIsSolidAndTheRoomIsNot) {
    const PolygonScene scene = roomWithPillar();
    const PolygonTracer tracer(scene);
    const Surroundings inside = lookRound(tracer, {0.1, 1.5, 0.05}), beside = lookRound(tracer, {0.5, 1.5, 0});
    EXPECT_TRUE(isInsideSolid(inside));
    EXPECT_GT(inside.backShare, 0.95) << "all but its foot and head, which lie in the floor and the ceiling";
    EXPECT_NEAR(inside.nearestMetres, 0.3, 0.01);
    EXPECT_FALSE(isInsideSolid(beside));
    EXPECT_EQ(beside.backShare, 0.0);
    EXPECT_EQ(beside.hitShare, 1.0);
    EXPECT_NEAR(beside.nearestMetres, 0.1, 0.01);
}

TEST(FreeSpace, APillarThatLacksAnEndIsSolidToo) {
    PolygonMesh pillar = boxMesh({-0.4f, 0, -0.4f}, {0.4f, 3, 0.4f}, false);
    pillar.triangles.resize(pillar.triangles.size() - 2); // its top
    const PolygonScene scene = sceneOf(pillar);
    const PolygonTracer tracer(scene);
    EXPECT_TRUE(isInsideSolid(lookRound(tracer, {0, 1, 0})));
}

TEST(FreeSpace, BehindASingleSidedCurtainOneMayStand) {
    PolygonMesh curtain;
    addRectangle(curtain, {-50, -50, 0}, {100, 0, 0}, {0, 100, 0}); // faces +Z
    const PolygonScene scene = sceneOf(curtain);
    const PolygonTracer tracer(scene);
    const Surroundings behind = lookRound(tracer, {0, 0, -0.01});
    EXPECT_GT(behind.backShare, 0.45);
    EXPECT_FALSE(isInsideSolid(behind));
}

TEST(FreeSpace, PositionsAreRefusedByName) {
    const PolygonScene scene = roomWithPillar();
    const PolygonTracer tracer(scene);
    const std::filesystem::path file = "places.json";
    const std::vector<glm::dvec3> good{{2, 1.6, 2}, {-3, 1, 1}}, solid{{2, 1.6, 2}, {0.1, 1.5, 0}},
        lost{{2, 1.6, 2}, {-3, 1, 1}, {4000, 1.6, 0}};
    EXPECT_EQ(failureOf<Failure>([&] { checkPositions(tracer, good, file); }), "");
    EXPECT_EQ(failureOf<Failure>([&] { checkPositions(tracer, solid, file); }),
              "places.json: position 1 (0.1 1.5 0) is inside a solid: 98 % of the looks round end at the back of a "
              "surface, the nearest 0.302 m away; move it into free space, or remove it");
    EXPECT_EQ(failureOf<Failure>([&] { checkPositions(tracer, lost, file); }),
              "places.json: position 2 (4000 1.6 0) sees nothing: it is outside of everything; move it into the scene, "
              "or remove it");
}

TEST(FreeSpace, LooksAreSpreadEvenly) {
    glm::dvec3 sum(0);
    int upper = 0;
    for (const glm::dvec3& d : spreadDirections(256)) {
        EXPECT_NEAR(glm::length(d), 1.0, 1e-12);
        sum += d;
        upper += d.y > 0.5; // a quarter of the sphere
    }
    EXPECT_LT(glm::length(sum), 2.0);
    EXPECT_NEAR(upper, 64, 1);
}

} // namespace
} // namespace scene
