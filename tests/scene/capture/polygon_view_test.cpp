#include "scene/capture/polygon_view.h"

#include "scene/srgb.h"
#include "tests/scene/capture/known_polygons.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace scene {
namespace {

Rgb8 shown(const CaptureLight& light, const PolygonTracer& tracer, const glm::vec3& linear) {
    return encoded(SurfaceLight(tracer, light).exposed(linear));
}

/// A room 4 m deep with a board 2 m before its far wall, each of one colour.
PolygonScene roomWithBoard(const glm::vec3& wall, const glm::vec3& board) {
    PolygonScene scene = sceneOf(boxMesh({-3, -2, -4}, {3, 2, 1}, true), wall);
    PolygonMesh mesh;
    addRectangle(mesh, {-0.73f, -0.61f, -2}, {1.3f, 0.1f, 0}, {-0.1f, 1.3f, 0});
    addMesh(scene, mesh, board);
    return scene;
}

TEST(PolygonView, DisparityIsThatOfTheWalls) {
    const PolygonScene scene = sceneOf(boxMesh({-3, -2, -4}, {3, 2, 1}, true));
    const PolygonTracer tracer(scene);
    const SurfaceLight light(tracer, evenLight());
    const View view = viewFrom({0.4, 0.3, 0.2}, {-0.5, -0.2, -2}, 97, 61);
    const DepthImage image = renderPolygons(tracer, light, view);
    const glm::dvec3 eye = view.worldFromEye.translation;
    for (int y = 0; y < 61; ++y)
        for (int x = 0; x < 97; ++x) {
            const glm::dvec3 ray = view.worldFromEye.rotation * rayThrough(view.camera, x + 0.5, y + 0.5);
            double z = INFINITY;
            for (int axis = 0; axis < 3; ++axis)
                z = std::min(z, ((ray[axis] > 0 ? glm::dvec3(3, 2, 1) : glm::dvec3(-3, -2, -4))[axis] - eye[axis]) /
                                    ray[axis]);
            ASSERT_NEAR(image.disparity(x, y) * z, 1.0, 1e-6) << x << " " << y;
            ASSERT_EQ(image.flags(x, y), 0);
        }
}

TEST(PolygonView, WhereNothingStandsThereIsSky) {
    PolygonMesh mesh;
    addRectangle(mesh, {-1, -1, -3}, {2, 0, 0}, {0, 1, 0});
    const PolygonScene scene = sceneOf(mesh);
    const PolygonTracer tracer(scene);
    const SurfaceLight light(tracer, {});
    const View view = viewFrom({0, 0, 0}, {0, 0, -1}, 40, 40);
    const DepthImage image = renderPolygons(tracer, light, view);
    EXPECT_EQ(image.flags(20, 5), kNoSurface);
    EXPECT_EQ(image.disparity(20, 5), 0.0f);
    EXPECT_EQ(image.colour(20, 5), encoded(light.exposed(light.skyTowards(view.worldFromEye.rotation *
                                                                          rayThrough(view.camera, 20.5, 5.5)))));
    EXPECT_EQ(image.flags(20, 25), 0);
    EXPECT_NEAR(image.disparity(20, 25), 1.0 / 3, 1e-6);
}

TEST(PolygonView, PicturesStandUprightAndAreNotMirrored) {
    PolygonMesh mesh;
    addRectangle(mesh, {-1, -1, -1}, {2, 0, 0}, {0, 2, 0});
    PolygonScene scene = sceneOf(mesh, glm::vec3(1));
    Image<Rgba8> picture(64, 64, {255, 255, 255, 255});
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 32; ++x)
            picture(x, y) = {255, 0, 0, 255}, picture(x + 32, y) = {0, 255, 0, 255},
                       picture(x, y + 32) = {0, 0, 255, 255};
    scene.textures.push_back({"quarters", picture});
    scene.materials[0].colourTexture = 0;
    const PolygonTracer tracer(scene);
    const SurfaceLight light(tracer, evenLight());
    const DepthImage image = renderPolygons(tracer, light, viewFrom({0, 0, 0}, {0, 0, -1}, 64, 64));
    EXPECT_EQ(image.colour(10, 10), shown(evenLight(), tracer, {1, 0, 0}));
    EXPECT_EQ(image.colour(50, 10), shown(evenLight(), tracer, {0, 1, 0}));
    EXPECT_EQ(image.colour(10, 50), shown(evenLight(), tracer, {0, 0, 1}));
    EXPECT_EQ(image.colour(50, 50), shown(evenLight(), tracer, {1, 1, 1}));
}

TEST(PolygonView, NoColourIsMixedOverASilhouette) {
    const glm::vec3 wall(0.9f, 0.1f, 0.1f), board(0.1f, 0.2f, 0.9f);
    const PolygonScene scene = roomWithBoard(wall, board);
    const PolygonTracer tracer(scene);
    const SurfaceLight light(tracer, evenLight());
    const DepthImage image = renderPolygons(tracer, light, viewFrom({0, 0, 0}, {0, 0, -1}, 96, 64));
    std::set<std::tuple<int, int, int>> colours;
    for (const Rgb8& c : image.colour.pixels())
        colours.insert({c.r, c.g, c.b});
    EXPECT_EQ(colours.size(), 2u);
    int onBoard = 0;
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 96; ++x) {
            const bool isBoard = image.disparity(x, y) > 0.4f;
            onBoard += isBoard;
            EXPECT_EQ(image.colour(x, y), shown(evenLight(), tracer, isBoard ? board : wall));
        }
    EXPECT_GT(onBoard, 100);
}

TEST(PolygonView, AColourEdgeOnOneSurfaceIsAntialiased) {
    // The board lies in the wall: colours differ, depth does not.
    PolygonScene scene = sceneOf(boxMesh({-3, -2, -4}, {3, 2, 1}, true), glm::vec3(0.9f));
    PolygonMesh mesh;
    addRectangle(mesh, {-0.73f, -0.61f, -3.999f}, {1.3f, 0.4f, 0}, {-0.4f, 1.3f, 0});
    addMesh(scene, mesh, glm::vec3(0.05f));
    const PolygonTracer tracer(scene);
    const SurfaceLight light(tracer, evenLight());
    const View view = viewFrom({0, 0, 0}, {0, 0, -1}, 96, 64);
    const DepthImage image = renderPolygons(tracer, light, view), raw = renderPolygons(tracer, light, view, {1});
    const int bright = shown(evenLight(), tracer, glm::vec3(0.9f)).r,
              dark = shown(evenLight(), tracer, glm::vec3(0.05f)).r;
    int between = 0, changedInside = 0;
    for (int y = 1; y < 63; ++y)
        for (int x = 1; x < 95; ++x) {
            const int c = image.colour(x, y).r;
            EXPECT_TRUE(raw.colour(x, y).r == bright || raw.colour(x, y).r == dark);
            between += c > dark + 20 && c < bright - 20;
            const bool isFlat = raw.colour(x - 1, y) == raw.colour(x, y) && raw.colour(x + 1, y) == raw.colour(x, y) &&
                                raw.colour(x, y - 1) == raw.colour(x, y) && raw.colour(x, y + 1) == raw.colour(x, y);
            changedInside += isFlat && !(image.colour(x, y) == raw.colour(x, y));
        }
    EXPECT_GT(between, 20);
    EXPECT_EQ(changedInside, 0) << "rays were spent where no neighbour differs";
    EXPECT_EQ(image.disparity, raw.disparity) << "depth belongs to the pixel's centre";
}

TEST(PolygonView, APointHasOneColourFromEverywhere) {
    const PolygonScene scene = roomWithBoard(glm::vec3(0.6f, 0.5f, 0.4f), glm::vec3(0.3f, 0.5f, 0.6f));
    const PolygonTracer tracer(scene);
    CaptureLight options;
    options.rays = 32;
    const SurfaceLight light(tracer, options);
    const View a = viewFrom({0.5, 0.2, 0.3}, {0, 0, -3}, 64, 48),
               b = viewFrom({-1.9, -0.7, -0.4}, {0.3, 0.2, -3}, 64, 48);
    const DepthImage image = renderPolygons(tracer, light, a, {1});
    int seen = 0;
    for (int y = 0; y < 48; ++y)
        for (int x = 0; x < 64; ++x) {
            const glm::dvec3 p =
                a.worldFromEye * (rayThrough(a.camera, x + 0.5, y + 0.5) / static_cast<double>(image.disparity(x, y)));
            const glm::dvec3 from = b.worldFromEye.translation, direction = p - from;
            const std::optional<PolygonHit> hit = tracer.cast(from, direction);
            ASSERT_TRUE(hit);
            if (std::abs(hit->t - 1) > 1e-5) continue; // hidden from there
            const PolygonPoint point = light.pointAt(from, direction, *hit);
            const Rgb8 there = encoded(light.exposed(light.colourAt(*hit, point, {}) * light.at(*hit, point)));
            const Rgb8 here = image.colour(x, y);
            ASSERT_LE(std::abs(here.r - there.r) + std::abs(here.g - there.g) + std::abs(here.b - there.b), 3);
            ++seen;
        }
    EXPECT_GT(seen, 1000);
}

TEST(PolygonView, TheBytesDoNotDependOnThreadsOrOnWhatWasLookedAtBefore) {
    const PolygonScene scene = roomWithBoard(glm::vec3(0.6f), glm::vec3(0.3f, 0.5f, 0.6f));
    const View view = viewFrom({0.5, 0.2, 0.3}, {0, 0, -3}, 80, 64),
               before = viewFrom({-2, 0.5, 0}, {0, 0, -3}, 80, 64);
    CaptureLight options;
    options.rays = 32;
    const auto draw = [&](std::size_t threads, bool looksElsewhereFirst) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        const PolygonTracer tracer(scene);
        const SurfaceLight light(tracer, options);
        if (looksElsewhereFirst) renderPolygons(tracer, light, before);
        return renderPolygons(tracer, light, view);
    };
    const DepthImage one = draw(1, false), two = draw(2, false), later = draw(2, true);
    EXPECT_EQ(one.colour, two.colour);
    EXPECT_EQ(one.disparity, two.disparity);
    EXPECT_EQ(one.colour, later.colour);
}

} // namespace
} // namespace scene
