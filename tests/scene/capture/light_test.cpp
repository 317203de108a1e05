#include "scene/capture/light.h"

#include "tests/scene/capture/known_polygons.h"

#include <gtest/gtest.h>

namespace scene {
namespace {

glm::vec3 lightWhere(const SurfaceLight& light, const PolygonTracer& tracer, const glm::dvec3& from,
                     const glm::dvec3& at) {
    const std::optional<PolygonHit> hit = tracer.cast(from, at - from);
    EXPECT_TRUE(hit);
    return hit ? light.at(*hit, light.pointAt(from, at - from, *hit)) : glm::vec3(0);
}

/// A floor of 20 x 20 m with a roof of 4 x 4 m, 3 m above its middle.
PolygonScene floorWithRoof() {
    PolygonMesh mesh;
    addRectangle(mesh, {-10, 0, -10}, {0, 0, 20}, {20, 0, 0});
    addRectangle(mesh, {-2, 3, -2}, {4, 0, 0}, {0, 0, 4});
    return sceneOf(mesh);
}

TEST(Light, TheSunCastsSharpShadows) {
    const PolygonScene scene = floorWithRoof();
    const PolygonTracer tracer(scene);
    CaptureLight options = evenLight();
    options.sun = glm::vec3(2);
    options.towardsSun = {1, 1, 0}; // the roof's shadow lies 3 m further along -X: from -5 to -1
    const SurfaceLight light(tracer, options);
    const auto at = [&](double x) { return lightWhere(light, tracer, {x, 1, 0.1}, {x, 0, 0.1}).x; };
    const auto inSun = static_cast<float>(2 * std::sqrt(0.5));
    EXPECT_NEAR(at(-5.01) - at(-4.99), inSun, 0.02);
    EXPECT_NEAR(at(-0.99) - at(-1.01), inSun, 0.02);
    EXPECT_NEAR(at(6), 1 + inSun, 1e-5);
}

TEST(Light, ClosedAndEvenlyFilledARoomIsEvenlyLit) {
    const PolygonScene scene = sceneOf(boxMesh({-3, 0, -4}, {3, 3, 4}, true));
    const PolygonTracer tracer(scene);
    CaptureLight options = evenLight();
    options.fill = glm::vec3(0.7f);
    options.zenith = options.horizon = options.ground = glm::vec3(100); // would show wherever a ray leaks out
    options.rays = 64;
    const SurfaceLight light(tracer, options);
    for (const glm::dvec3& at : {glm::dvec3(2.9999, 0, 3.9999), glm::dvec3(0, 0, 0), glm::dvec3(-3, 1e-4, 0.2),
                                 glm::dvec3(-2.9999, 2.9999, -4), glm::dvec3(1, 3, 3.99)})
        EXPECT_NEAR(lightWhere(light, tracer, {0.1, 1.5, 0.2}, at).x, 0.7f, 1e-4) << at.x << " " << at.y << " " << at.z;
}

TEST(Light, CornersGetLessOfTheFill) {
    const PolygonScene scene = sceneOf(boxMesh({-3, 0, -4}, {3, 3, 4}, true));
    const PolygonTracer tracer(scene);
    CaptureLight options = evenLight();
    options.fillReachMetres = 0.8;
    options.rays = 128;
    const SurfaceLight light(tracer, options);
    const float middle = lightWhere(light, tracer, {0, 1.5, 0}, {0.1, 0, 0.1}).x;
    const float edge = lightWhere(light, tracer, {0, 1.5, 0}, {2.98, 0, 0.1}).x;
    const float corner = lightWhere(light, tracer, {0, 1.5, 0}, {2.98, 0, 3.98}).x;
    EXPECT_GT(middle, 1.2f * edge);
    EXPECT_GT(edge, 1.2f * corner);
    EXPECT_GT(corner, 0.1f);
}

TEST(Light, WhatTheSunFallsOnLightsWhatItDoesNot) {
    // A ceiling above a floor in the sun: all that it gets comes from there.
    const PolygonScene scene = floorWithRoof();
    const PolygonTracer tracer(scene);
    CaptureLight options = evenLight();
    options.zenith = options.horizon = options.ground = options.fill = glm::vec3(0);
    options.sun = glm::vec3(1);
    options.towardsSun = {1, 1, 0};
    options.rays = 2048;
    const SurfaceLight light(tracer, options);
    const float below = lightWhere(light, tracer, {0, 1, 0}, {0, 3, 0}).x;
    // Floor: 0.5 of sqrt(1/2); from the ceiling's middle a floor of 20 x 20 m fills 0.92 of the cosine-weighted half
    // space, less the shadow from x = -5 to -1.
    const auto quarter = [](double a, double b) { // of a rectangle a x b, 3 m below one of its corners
        const double x = a / 3, y = b / 3;
        return (x / std::sqrt(1 + x * x) * std::atan(y / std::sqrt(1 + x * x)) +
                y / std::sqrt(1 + y * y) * std::atan(x / std::sqrt(1 + y * y))) /
               (2 * 3.14159265358979);
    };
    const double whole = 4 * quarter(10, 10), shadow = 2 * (quarter(5, 2) - quarter(1, 2));
    EXPECT_NEAR(below, 0.5 * std::sqrt(0.5) * (whole - shadow), 0.01);
}

TEST(Light, WhatStandsOnAFloorDoesNotDarkenItBesides) {
    // The floor's triangles run on below a slab as thin as a carpet, where no light is.
    PolygonScene scene = floorWithRoof();
    addMesh(scene, boxMesh({4.03f, 0, 4.03f}, {9.07f, 0.01f, 9.07f}, false), glm::vec3(0.5f));
    const PolygonTracer tracer(scene);
    CaptureLight options = evenLight();
    options.fill = glm::vec3(0);
    options.rays = 64;
    const SurfaceLight light(tracer, options);
    for (double z = 5; z < 7; z += 0.0917)
        EXPECT_GT(lightWhere(light, tracer, {3.99, 1, z}, {3.99, 0, z}).x, 0.75f) << z;
}

TEST(Light, BrightnessIsBentAndWhiteIsWhite) {
    const PolygonScene scene = floorWithRoof();
    const PolygonTracer tracer(scene);
    const SurfaceLight light(tracer, {});
    EXPECT_NEAR(light.exposed(glm::vec3(light.options().white)).x, 1.0f, 1e-5);
    EXPECT_LT(light.exposed(glm::vec3(1)).x, 1.0f);
    EXPECT_EQ(light.exposed(glm::vec3(0)).x, 0.0f);
}

} // namespace
} // namespace scene
