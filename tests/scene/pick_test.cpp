// Rays into scenes of known truth.

#include "scene/pick.h"

#include "scene/refine/skins.h"
#include "tests/repetitions.h"
#include "tests/scene/known_scenes.h"
#include "tests/scene/tiled.h"

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace scene {
namespace {

/// The bare room from eight places, skins cut; samples 6 mm apart at a metre.
const Tiled& tiledRoom() {
    static const Tiled tiled = [] {
        std::vector<DepthImage> images = imagesOfBareRoom(8);
        SkinFigures figures;
        for (DepthImage& image : images)
            image.flags = markPlanarSkins(image, 0.03f, figures);
        return Tiled(std::move(images));
    }();
    return tiled;
}

/// A wall 2 m before a camera at the origin, samples 2.6 mm apart, moved by offset.
Tiled wall(const glm::dvec3& normal, const glm::dvec3& offset = glm::dvec3(0)) {
    const Camera camera{400, 300, 760, 760, 200, 150};
    return Tiled({imageOf(camera, {glm::dmat3(1.0), offset},
                          [&](double x, double y) { return planeDisparity(camera, normal, 2 * normal.z, x, y); })});
}

double degreesBetween(const glm::dvec3& a, const glm::dvec3& b) {
    return std::acos(std::min(glm::dot(a, b), 1.0)) * 57.29578;
}

TEST(Pick, HitsWhereTheSurfaceIs) {
    const Tiled& room = tiledRoom();
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(-1, 1);
    int rays = 0, near = 0, right = 0, flat = 0;
    double worst = 0;
    for (int i = 0; i < tests::repetitions(400); ++i) {
        const glm::dvec3 from(3 + 2 * unit(random), 2.5 + 1.5 * unit(random), 1.2 + 0.6 * unit(random));
        const glm::dvec3 direction(unit(random), unit(random), 0.4 * unit(random));
        const auto truth = castRay(bareRoom(), from, direction);
        ASSERT_TRUE(truth);
        if (truth->distanceMetres < 0.3) continue; // from within the block, or at a wall
        const auto hit = pick(room.blocks, {from, direction});
        if (!hit) continue; // eight images do not see all of it
        ++rays;
        EXPECT_TRUE(hit->isSeen);
        EXPECT_NEAR(hit->distanceMetres, glm::distance(hit->position, from), 1e-9);
        const double off = glm::distance(hit->position, truth->position);
        // Where none of the images saw the first surface, a ray goes on to the next one; it never ends too early.
        EXPECT_GT(hit->distanceMetres, truth->distanceMetres - 0.05);
        if (off > 0.05) continue;
        ++near;
        worst = std::max(worst, off);
        right += off < 0.002;
        if (!hit->normal) continue;
        EXPECT_NEAR(glm::length(*hit->normal), 1, 1e-9);
        EXPECT_LT(glm::dot(*hit->normal, direction), 0) << "towards the ray's origin";
        flat += degreesBetween(*hit->normal, truth->normal) < 3;
    }
    EXPECT_GT(rays, tests::repetitions(250));
    EXPECT_GE(near, 0.95 * rays);
    EXPECT_GE(right, 0.97 * near) << "worst " << worst;
    EXPECT_GE(flat, 0.97 * near);
}

TEST(Pick, APlaneIsHitExactlyFromAnywhereAndAnyDirection) {
    const glm::dvec3 normal = glm::normalize(glm::dvec3(0.2, -0.1, 1));
    const Tiled plane = wall(normal);
    std::mt19937 random(4);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int i = 0; i < 100; ++i) {
        const glm::dvec3 at0(0.4 * unit(random), 0.3 * unit(random), 0);
        const glm::dvec3 at(at0.x, at0.y, (2 * normal.z - glm::dot(normal, at0)) / normal.z);
        const glm::dvec3 from(1.5 * unit(random), unit(random), unit(random));
        const auto hit = pick(plane.blocks, {from, 3.7 * (at - from)});
        ASSERT_TRUE(hit) << i;
        EXPECT_LT(glm::distance(hit->position, at), 1e-4) << i;
        ASSERT_TRUE(hit->normal) << i;
        EXPECT_LT(degreesBetween(*hit->normal, -normal), 0.2) << i;
    }
}

TEST(Pick, AGrazingRayHitsTheSurfaceItReaches) {
    const Tiled plane = wall({0, 0, 1});
    for (const double degrees : {80.0, 85.0, 88.0}) {
        // Along +x, down onto the wall at (0.1, 0, 2).
        const double angle = degrees / 57.29578;
        const glm::dvec3 direction(std::sin(angle), 0, std::cos(angle)), at(0.1, 0, 2);
        const auto hit = pick(plane.blocks, {at - 0.4 * direction, direction});
        ASSERT_TRUE(hit) << degrees;
        EXPECT_LT(glm::distance(hit->position, at), 0.002) << degrees;
        if (degrees > 87) continue; // from pixel to pixel depth now changes as at a silhouette
        ASSERT_TRUE(hit->normal) << degrees;
        EXPECT_LT(degreesBetween(*hit->normal, {0, 0, -1}), 2) << degrees;
    }
}

TEST(Pick, ARayThatStartsBehindASurfaceHitsTheNextOne) {
    const Camera camera{200, 150, 380, 380, 100, 75};
    const auto flat = [&](double depth) { return imageOf(camera, {}, [depth](double, double) { return 1 / depth; }); };
    const Tiled two({flat(1), flat(3)});
    const auto distance = [&](double from) { return pick(two.blocks, {{0, 0, from}, {0, 0, 1}})->distanceMetres; };
    EXPECT_NEAR(distance(0), 1, 1e-5);
    EXPECT_NEAR(distance(1.001), 1.999, 1e-5);
    EXPECT_FALSE(pick(two.blocks, {{0, 0, 3.5}, {0, 0, 1}}));
    // From behind, the way back.
    const auto back = pick(two.blocks, {{0, 0, 3.5}, {0, 0, -1}});
    ASSERT_TRUE(back);
    EXPECT_NEAR(back->distanceMetres, 0.5, 1e-5);
    EXPECT_LT(degreesBetween(back->normal.value(), {0, 0, 1}), 0.1) << "towards the ray's origin";
}

TEST(Pick, NothingIsHitInTheSkyOrWhereNothingWasScanned) {
    Tiled plane = wall({0, 0, 1});
    EXPECT_FALSE(pick(plane.blocks, {{0, 0, 0}, {1, 0, 0.5}})) << "beside the image";
    EXPECT_FALSE(pick(plane.blocks, {{0, 0, 0}, {0, 0, -1}})) << "behind the camera";
    EXPECT_FALSE(pick({}, {{0, 0, 0}, {0, 0, 1}})) << "an empty scene";

    DepthImage holed = plane.images[0];
    for (int y = 100; y < 200; ++y)
        for (int x = 150; x < 250; ++x)
            holed.flags(x, y) = kNoSurface;
    const Tiled open({holed});
    EXPECT_FALSE(pick(open.blocks, {{0, 0, 0}, {0, 0, 1}})) << "through the gap";
    EXPECT_TRUE(pick(open.blocks, {{0, 0, 0}, {0.1, 0, 1}})) << "beside it";

    DepthImage sky = plane.images[0];
    for (float& disparity : sky.disparity.pixels())
        disparity = 0;
    const Tiled open2({sky});
    EXPECT_FALSE(pick(open2.blocks, {{0, 0, 0}, {0, 0, 1}})) << "the sky was seen, but is no place";
}

TEST(Pick, OfNarrowGapsTheNearestSampleIsTakenAndOfWideOnesNone) {
    DepthImage slit = wall({0, 0, 1}).images[0];
    for (int y = 0; y < 300; ++y)
        slit.flags(200, y) = kNoSurface; // a gap of two samples' distance: 5 mm at 2 m
    const Tiled narrow({slit});
    const auto hit = pick(narrow.blocks, {{0, 0, 0}, {0.5 / 760, 0, 1}});
    ASSERT_TRUE(hit);
    EXPECT_NEAR(hit->position.z, 2, 1e-4);
    EXPECT_LT(glm::distance(hit->position, {0.5 / 380, 0, 2}), 0.008);
    for (int y = 0; y < 300; ++y)
        for (int x = 190; x < 210; ++x)
            slit.flags(x, y) = kNoSurface;
    const Tiled wide({slit});
    EXPECT_FALSE(pick(wide.blocks, {{0, 0, 0}, {0, 0, 1}}));
}

/// A wire's only sample, 1 m before the wall, in no square.
Tiled wireBeforeWall(std::uint8_t flags) {
    DepthImage image = wall({0, 0, 1}).images[0];
    image.disparity(200, 150) = 1, image.flags(200, 150) = flags;
    for (int y = 149; y <= 150; ++y)
        for (int x = 199; x <= 200; ++x)
            image.flags(x, y) |= kSkinUpper | kSkinLower;
    return Tiled({image});
}

TEST(Pick, ALoneSampleIsHitThoughNoTriangleHoldsIt) {
    const Tiled wire = wireBeforeWall(0);
    const auto hit = pick(wire.blocks, {{0, 0, 0}, {0.5 / 760, 0.5 / 760, 1}});
    ASSERT_TRUE(hit);
    EXPECT_NEAR(hit->distanceMetres, 1, 1e-4);
    EXPECT_FALSE(hit->normal) << "one sample has none";
    EXPECT_NEAR(pick(wire.blocks, {{0, 0, 0}, {0.02, 0, 1}})->position.z, 2, 1e-4) << "beside it: the wall";
}

TEST(Pick, AGuessIsNoSeenSampleAndHidesNothingNearer) {
    DepthImage image = wall({0, 0, 1}).images[0];
    for (int y = 100; y < 200; ++y)
        for (int x = 150; x < 250; ++x)
            image.flags(x, y) = kNoSurface | kInterpolated;
    const DepthImage guessed = image;
    const Tiled alone({guessed});
    const auto guess = pick(alone.blocks, {{0, 0, 0}, {0, 0, 1}});
    ASSERT_TRUE(guess);
    EXPECT_FALSE(guess->isSeen);
    EXPECT_NEAR(guess->position.z, 2, 1e-4);
    EXPECT_TRUE(pick(alone.blocks, {{0, 0, 0}, {0.15, 0, 1}})->isSeen) << "beside the guess";

    const Camera camera = image.camera;
    const auto flat = [&](double depth) { return imageOf(camera, {}, [depth](double, double) { return 1 / depth; }); };
    const Tiled nearer({guessed, flat(1.5)}), same({guessed, flat(2.01)}), farther({guessed, flat(3)});
    EXPECT_TRUE(pick(nearer.blocks, {{0, 0, 0}, {0, 0, 1}})->isSeen);
    EXPECT_TRUE(pick(same.blocks, {{0, 0, 0}, {0, 0, 1}})->isSeen) << "another image measured it there";
    EXPECT_FALSE(pick(farther.blocks, {{0, 0, 0}, {0, 0, 1}})->isSeen) << "what is shown is the guess";
}

TEST(Pick, WhatIsClosedIsShownToAllEyesAndNotMeasuredWith) {
    DepthImage image = wall({0, 0, 1}).images[0];
    for (int y = 100; y < 200; ++y)
        for (int x = 150; x < 250; ++x)
            image.flags(x, y) = kInterpolated;
    const Tiled closed({image});
    for (const glm::dvec3& eye : {glm::dvec3(0), glm::dvec3(1.5, 0.2, 0.3)}) { // a guess is not shown to the latter
        const auto hit = pick(closed.blocks, {eye, glm::dvec3(0, 0, 2) - eye});
        ASSERT_TRUE(hit);
        EXPECT_FALSE(hit->isSeen);
        EXPECT_NEAR(hit->position.z, 2, 1e-4);
    }
    EXPECT_TRUE(pick(closed.blocks, {{0, 0, 0}, {0.15, 0, 1}})->isSeen) << "beside it";
    EXPECT_TRUE(pick(closed.blocks, {{0, 0, 0}, {0.063, 0, 1}})->isSeen) << "its rim, where samples are in reach";
}

TEST(Pick, ALoneSampleThatIsClosedIsHitAndNotMeasuredWith) {
    const Tiled wire = wireBeforeWall(kInterpolated);
    const auto hit = pick(wire.blocks, {{0, 0, 0}, {0.5 / 760, 0.5 / 760, 1}});
    ASSERT_TRUE(hit);
    EXPECT_FALSE(hit->isSeen);
    EXPECT_NEAR(hit->distanceMetres, 1, 1e-4);
}

TEST(Pick, FarFromTheOriginItIsAsExact) {
    const glm::dvec3 offset(1e7, -1e7, 1e7), normal = glm::normalize(glm::dvec3(0.1, 0.2, 1));
    const Tiled here = wall(normal), there = wall(normal, offset);
    for (const double x : {-0.2, 0.0, 0.13}) {
        const auto a = pick(here.blocks, {{0.3, 0, 0.5}, {x, 0.05, 1}});
        const auto b = pick(there.blocks, {offset + glm::dvec3(0.3, 0, 0.5), {x, 0.05, 1}});
        ASSERT_TRUE(a && b);
        EXPECT_LT(glm::distance(a->position, b->position - offset), 1e-5);
        EXPECT_LT(degreesBetween(*a->normal, *b->normal), 0.05);
    }
}

TEST(Pick, ATenthOfAMillimetreBeforeAWallAndAHundredKilometresBeforeOne) {
    const glm::dvec3 normal = glm::normalize(glm::dvec3(0.1, 0.2, 1));
    const Tiled near = wall(normal);
    const Camera camera{400, 300, 760, 760, 200, 150};
    const Tiled far({imageOf(
        camera, {}, [&](double x, double y) { return planeDisparity(camera, normal, 1e5 * normal.z, x, y); })});
    for (const double aside : {0.0, 0.03, 0.2, -0.11})
        for (const glm::dvec3& direction : {glm::dvec3(0, 0, 1), glm::dvec3(1, 0.3, 0.9), glm::dvec3(-0.2, 1, 0.4)}) {
            const glm::dvec3 onNear(aside, 0.1, 2 - (normal.x * aside + normal.y * 0.1) / normal.z);
            const double metres = 1e-4 / glm::dot(normal, direction);
            const auto hit = pick(near.blocks, {onNear - metres * direction, direction});
            ASSERT_TRUE(hit) << aside;
            EXPECT_LT(glm::distance(hit->position, onNear), 5e-6) << aside;

            const glm::dvec3 ray = rayThrough(camera, 200 + 500 * aside, 150);
            const glm::dvec3 onFar = ray * (1e5 * normal.z / glm::dot(normal, ray));
            const auto farHit = pick(far.blocks, {glm::dvec3(3, -2, 1), onFar - glm::dvec3(3, -2, 1)});
            ASSERT_TRUE(farHit) << aside;
            EXPECT_LT(glm::distance(farHit->position, onFar), 5) << aside;
        }
}

TEST(Pick, ARayThatIsNoneHitsNothing) {
    const Tiled plane = wall({0, 0, 1});
    const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
    EXPECT_FALSE(pick(plane.blocks, {{0, 0, 0}, {0, 0, 0}}));
    EXPECT_FALSE(pick(plane.blocks, {{0, 0, nan}, {0, 0, 1}}));
    EXPECT_FALSE(pick(plane.blocks, {{0, infinity, 0}, {0, 0, 1}}));
    EXPECT_FALSE(pick(plane.blocks, {{0, 0, 0}, {0, nan, 1}}));
}

TEST(Pick, TheSameOnAnyNumberOfThreads) {
    const Tiled& room = tiledRoom();
    std::vector<glm::dvec3> positions;
    for (const std::size_t threads : {1u, 2u, 2u}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        positions.push_back(pick(room.blocks, {{3.2, 2.9, 1.4}, {1, 0.3, -0.1}}).value().position);
    }
    EXPECT_EQ(positions[0], positions[1]);
    EXPECT_EQ(positions[0], positions[2]);
}

} // namespace
} // namespace scene
