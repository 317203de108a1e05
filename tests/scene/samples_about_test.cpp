// How exactly samples say where a place is: on planes of known noise, seen square and at a slant.

#include "scene/samples_about.h"

#include "scene/cube.h"
#include "scene/pick.h"

#include "tests/scene/known_scenes.h"
#include "tests/scene/tiled.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

namespace scene {
namespace {

constexpr double kPixels = 760; // a camera's focal length

/// A plane 2 m before a camera at the origin, turned about the y axis; its range scatters by so many metres.
Tiled slanted(double degrees, double scatterMetres, const Pose& worldFromCamera = {}) {
    const Camera camera{400, 300, kPixels, kPixels, 200, 150};
    const double angle = degrees / 57.29578;
    const glm::dvec3 normal(std::sin(angle), 0, std::cos(angle));
    std::mt19937 random(3);
    std::normal_distribution<double> noise(0, scatterMetres);
    return Tiled({imageOf(camera, worldFromCamera, [&](double x, double y) {
        const double d = glm::dot(normal, rayThrough(camera, x, y)) / (2 * normal.z);
        return 1 / (1 / d + noise(random));
    })});
}

TEST(SamplesAbout, TellSpacingAndScatter) {
    for (const double millimetres : {0.5, 3.0, 10.0}) {
        const Tiled wall = slanted(0, millimetres / 1000);
        double sum = 0;
        const int places = 40;
        for (int i = 0; i < places; ++i) {
            const auto about = samplesAbout(wall.blocks, {-0.3 + 0.015 * i, 0.1, 2});
            ASSERT_TRUE(about);
            EXPECT_EQ(about->image, 0u);
            EXPECT_NEAR(about->rangeMetres, glm::length(glm::dvec3(-0.3 + 0.015 * i, 0.1, 2)), 1e-6);
            EXPECT_NEAR(about->spacingMetres, 2 / kPixels, 0.3 * 2 / kPixels) << "noise slants the plane, too";
            ASSERT_TRUE(about->scatterMetres);
            sum += *about->scatterMetres;
        }
        EXPECT_NEAR(1000 * sum / places, millimetres, 0.1 * millimetres);
    }
}

TEST(SamplesAbout, PlacesThatAreHitAreAsExactAsTheySay) {
    for (const double millimetres : {1.0, 5.0}) {
        const Tiled wall = slanted(20, millimetres / 1000);
        const glm::dvec3 normal(std::sin(20 / 57.29578), 0, std::cos(20 / 57.29578));
        std::mt19937 random(5);
        std::uniform_real_distribution<double> unit(-1, 1);
        double squares = 0, said = 0;
        const int places = 200;
        for (int i = 0; i < places; ++i) {
            const glm::dvec3 from(unit(random), unit(random), 0.3 * unit(random));
            const glm::dvec3 at(0.3 * unit(random), 0.2 * unit(random), 2);
            const auto hit = pick(wall.blocks, {from, at - from});
            ASSERT_TRUE(hit);
            const auto about = samplesAbout(wall.blocks, hit->position);
            ASSERT_TRUE(about && about->scatterMetres);
            const double off = glm::dot(normal, hit->position) - 2 * normal.z;
            squares += off * off;
            said += *about->scatterMetres * *about->scatterMetres;
        }
        // A place lies between three samples, so that their noise is partly out of it.
        EXPECT_LT(std::sqrt(squares / said), 1.05) << millimetres;
        EXPECT_GT(std::sqrt(squares / said), 0.5) << millimetres;
    }
}

TEST(SamplesAbout, AtASlantSamplesStandFartherApartAndAPlaneScattersNoMore) {
    const Tiled wall = slanted(60, 0);
    const auto about = samplesAbout(wall.blocks, {0, 0, 2});
    ASSERT_TRUE(about);
    EXPECT_NEAR(about->spacingMetres, 2 * 2 / kPixels, 0.05 * 2 / kPixels);
    ASSERT_TRUE(about->scatterMetres);
    EXPECT_LT(*about->scatterMetres, 2e-5);
}

TEST(SamplesAbout, AreOfTheImageWhoseSamplesAreNearest) {
    Pose beside;
    beside.translation = {0, 0, 0.004}; // its wall stands 4 mm farther off
    Tiled two = slanted(0, 0);
    const Tiled other = slanted(0, 0, beside);
    two.blocks.push_back(other.blocks[0]);
    EXPECT_EQ(samplesAbout(two.blocks, {0.1, 0, 2.0005})->image, 0u);
    EXPECT_EQ(samplesAbout(two.blocks, {0.1, 0, 2.0035})->image, 1u);
}

TEST(SamplesAbout, WhereNoSurfaceIsNothingIsKnown) {
    const Tiled wall = slanted(0, 0);
    EXPECT_FALSE(samplesAbout(wall.blocks, {0, 0, 1}));
    EXPECT_FALSE(samplesAbout(wall.blocks, {0, 0, -2}));
    EXPECT_FALSE(samplesAbout(wall.blocks, {1, 0, 2})) << "beside the picture";
    EXPECT_FALSE(samplesAbout({}, {0, 0, 2}));
}

TEST(SamplesAbout, FacesAreOfTheirScan) {
    EXPECT_EQ(withoutFace("scan1-front"), "scan1");
    EXPECT_EQ(withoutFace("hall-2-front-2"), "hall-2");
    EXPECT_EQ(withoutFace("frame-000025.color"), "frame-000025.color");
    EXPECT_EQ(withoutFace("shop-front-back"), "shop-front");
    EXPECT_EQ(withoutFace("-up"), "-up");
    EXPECT_EQ(withoutFace("42"), "42");
    EXPECT_EQ(withoutFace(""), "");
}

} // namespace
} // namespace scene
