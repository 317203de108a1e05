#include "scene/capture/tracer.h"

#include "scene/errors.h"

#include "tests/scene/capture/known_polygons.h"
#include "tests/scene/scratch_folder.h"

#include <cmath>

#include <glm/ext/matrix_transform.hpp>
#include <gtest/gtest.h>

namespace scene {
namespace {

/// Distance to the side of a box that a ray from inside leaves it by.
double wayOut(const glm::dvec3& low, const glm::dvec3& high, const glm::dvec3& from, const glm::dvec3& direction) {
    double t = INFINITY;
    for (int axis = 0; axis < 3; ++axis)
        if (direction[axis] != 0)
            t = std::min(t, ((direction[axis] > 0 ? high : low)[axis] - from[axis]) / direction[axis]);
    return t;
}

/// Directions all round, none along an axis.
std::vector<glm::dvec3> directions() {
    std::vector<glm::dvec3> all;
    for (int i = 0; i < 500; ++i)
        all.emplace_back(std::sin(i * 1.7 + 0.3), std::cos(i * 2.9 + 0.1),
                         std::sin(i * 0.77 + 1.1) * std::cos(i * 0.31));
    return all;
}

TEST(Tracer, RaysEndWhereTheBoxDoes) {
    const glm::vec3 low(-3, 0, -4), high(5, 2.7f, 6);
    const PolygonScene scene = sceneOf(boxMesh(low, high, true));
    const PolygonTracer tracer(scene);
    const glm::dvec3 from(0.31, 1.6, -0.77);
    for (const glm::dvec3& direction : directions()) {
        const std::optional<PolygonHit> hit = tracer.cast(from, direction);
        ASSERT_TRUE(hit);
        const double truth = wayOut(glm::dvec3(low), glm::dvec3(high), from, direction);
        EXPECT_NEAR(hit->t, truth, 1e-12 * truth);
        EXPECT_FALSE(hit->isBack);
        EXPECT_FALSE(tracer.isBlocked(from, direction, truth * 0.9999));
        EXPECT_TRUE(tracer.isBlocked(from, direction, truth * 1.0001));
    }
}

TEST(Tracer, FarFromTheOriginNothingIsLostButWhatTheFilesFloatsLack) {
    // 2^20 m: whole sixteenths of a metre are exact in single precision there.
    const glm::vec3 far(1048576, 0, -1048576);
    PolygonScene scene = sceneOf(boxMesh(glm::vec3(-3, 0, -4), glm::vec3(5, 2.75f, 6), true));
    scene.instances[0].worldFromMesh = glm::translate(glm::dmat4(1.0), glm::dvec3(far));
    const PolygonTracer tracer(scene);
    const glm::dvec3 from = glm::dvec3(far) + glm::dvec3(0.3, 1.6, 0.2);
    for (const glm::dvec3& direction : directions()) {
        const std::optional<PolygonHit> hit = tracer.cast(from, direction);
        ASSERT_TRUE(hit);
        const double truth = wayOut({-3, 0, -4}, {5, 2.75, 6}, {0.3, 1.6, 0.2}, direction);
        EXPECT_NEAR(hit->t, truth, 1e-8 * truth);
    }
}

TEST(Tracer, AMeshThatStandsInManyPlacesIsHitAsIfItWereThereOften) {
    PolygonScene instanced = sceneOf(boxMesh(glm::vec3(-0.5f), glm::vec3(0.5f), false)), copied = instanced;
    instanced.instances.clear(), copied.instances.clear(), copied.meshes.clear();
    for (int i = 0; i < 5; ++i) {
        glm::dmat4 place = glm::translate(glm::dmat4(1.0), glm::dvec3(2 * i, 0.3 * i, -i));
        place = glm::rotate(place, 0.4 * i, glm::dvec3(0.3, 1, 0.2));
        if (i == 3) place = glm::scale(place, glm::dvec3(-1, 2, 0.5)); // mirrored and stretched
        instanced.instances.push_back({0, place});
        copied.instances.push_back({static_cast<std::uint32_t>(i), place});
        copied.meshes.push_back(instanced.meshes[0]);
    }
    const PolygonTracer one(instanced), other(copied);
    int hits = 0;
    for (const glm::dvec3& d : directions()) {
        const glm::dvec3 from(4.0, 9.0, 3.0), towards = glm::dvec3(4, 0.5, -2) + d * 4.0 - from;
        const std::optional<PolygonHit> a = one.cast(from, towards), b = other.cast(from, towards);
        ASSERT_EQ(a.has_value(), b.has_value());
        if (!a) continue;
        ++hits;
        EXPECT_EQ(a->instance, b->instance);
        EXPECT_NEAR(a->t, b->t, 1e-12);
        EXPECT_FALSE(a->isBack) << "a mirrored box is still seen from outside";
        EXPECT_FALSE(b->isBack);
    }
    EXPECT_GT(hits, 40);
}

/// A square of 1 m at z = 0 that faces +Z; its picture is opaque but for the lower left quarter.
PolygonScene squareWithHole() {
    PolygonMesh mesh;
    addRectangle(mesh, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    PolygonScene scene = sceneOf(mesh);
    Image<Rgba8> picture(16, 16, {200, 100, 50, 255});
    for (int y = 8; y < 16; ++y)
        for (int x = 0; x < 8; ++x)
            picture(x, y).a = 0;
    scene.textures.push_back({"mask", picture});
    scene.materials[0].alphaTexture = 0;
    return scene;
}

TEST(Tracer, LooksGoThroughWhatIsCutOut) {
    const PolygonScene scene = squareWithHole();
    const PolygonTracer tracer(scene);
    for (double y = 0.1; y < 1; y += 0.1)
        for (double x = 0.1; x < 1; x += 0.1) {
            if (std::abs(x - 0.5) < 0.05 || std::abs(y - 0.5) < 0.05) continue; // at the edge of the hole
            const bool isHole = x < 0.5 && y < 0.5;
            EXPECT_EQ(tracer.cast({x, y, 2}, {0, 0, -1}).has_value(), !isHole) << x << " " << y;
            EXPECT_EQ(tracer.isBlocked({x, y, -2}, {0, 0, 1}, 5), !isHole) << x << " " << y;
        }
}

TEST(Tracer, HolesGoAlongWithInstances) {
    PolygonScene scene = squareWithHole();
    scene.instances.push_back({0, glm::translate(glm::dmat4(1.0), glm::dvec3(10, 0, 0))});
    const PolygonTracer tracer(scene);
    EXPECT_FALSE(tracer.cast({10.25, 0.25, 2}, {0, 0, -1}));
    EXPECT_TRUE(tracer.cast({10.75, 0.25, 2}, {0, 0, -1}));
    EXPECT_TRUE(tracer.cast({0.25, 0.75, 2}, {0, 0, -1}));
}

TEST(Tracer, GlassIsNotThere) {
    PolygonScene scene = sceneOf(boxMesh(glm::vec3(-1), glm::vec3(1), true));
    PolygonMesh pane;
    addRectangle(pane, {-0.5, -0.5, 0.5}, {1, 0, 0}, {0, 1, 0});
    addMesh(scene, pane, glm::vec3(1));
    scene.materials[1].isGlass = true;
    const PolygonTracer tracer(scene);
    EXPECT_NEAR(tracer.cast({0, 0, 0}, {0.01, 0.02, 1})->t, 1.0, 1e-12);
    scene.materials[0].isGlass = true;
    EXPECT_NE(failureOf<Failure>([&] { const PolygonTracer nothing(scene); }).find("nothing but glass"),
              std::string::npos);
}

TEST(Tracer, WeightsBringBackTheCorners) {
    const TriangleInWorld triangle{{glm::dvec3(1, 2, 3), glm::dvec3(4, 2, 3.5), glm::dvec3(1.5, 6, 2)}, {}};
    const glm::dvec3 place = triangle.corners[0] * 0.2 + triangle.corners[1] * 0.5 + triangle.corners[2] * 0.3;
    EXPECT_LT(glm::distance(weightsAt(triangle, place), glm::dvec3(0.2, 0.5, 0.3)), 1e-12);
    const glm::dvec3 beyond = triangle.corners[0] * 1.5 - triangle.corners[1] * 0.5;
    EXPECT_LT(glm::distance(weightsAt(triangle, beyond), glm::dvec3(1.5, -0.5, 0)), 1e-12);
}

} // namespace
} // namespace scene
