#include "scene/upright.h"

#include "scene/synthetic_random.h"
#include "tests/scene/known_scenes.h"

#include <cmath>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

namespace scene {
namespace {

constexpr double kDegreeOfUp = 0.017453292519943295;

double degreesBetweenUps(const glm::dvec3& a, const glm::dvec3& b) {
    return std::acos(std::min(1.0, glm::dot(a, b))) / kDegreeOfUp;
}

glm::dvec3 anyNormal(SeededSequence& random) {
    return glm::normalize(glm::dvec3(random.normal(), random.normal(), random.normal()));
}

/// Up, leaning to some side.
glm::dvec3 leaning(double degrees, double towards) {
    return {std::sin(degrees * kDegreeOfUp) * std::cos(towards), std::sin(degrees * kDegreeOfUp) * std::sin(towards),
            std::cos(degrees * kDegreeOfUp)};
}

/// Floor, ceiling and four walls that are turned by some angle, to a degree, and as much again of what stands anyhow.
std::vector<Facing> planeRoom(SeededSequence& random, double turn, int ofEach = 40) {
    std::vector<Facing> facings;
    const glm::dvec3 x(std::cos(turn), std::sin(turn), 0), y(-x.y, x.x, 0), z(0, 0, 1);
    for (const glm::dvec3& normal : {x, -x, y, -y, z, -z})
        for (int i = 0; i < ofEach; ++i)
            facings.push_back({glm::normalize(normal + kDegreeOfUp * anyNormal(random)), 1});
    for (int i = 0; i < 6 * ofEach; ++i)
        facings.push_back({anyNormal(random), 1});
    return facings;
}

TEST(Upright, FloorsAndWallsSayWhatCamerasDoNot) {
    for (int i = 0; i < 50; ++i) {
        SeededSequence random(static_cast<unsigned>(i) + 1);
        const double turn = 0.13 * i;
        const glm::dvec3 up = levelled(leaning(12, 0.7 * i), planeRoom(random, turn));
        EXPECT_LT(degreesBetweenUps(up, {0, 0, 1}), 0.4) << "room " << i;
        EXPECT_NEAR(glm::length(up), 1, 1e-12);
    }
}

TEST(Upright, WhereNothingIsPlaneTheGuessStays) {
    SeededSequence random(7);
    std::vector<Facing> leaves;
    for (int i = 0; i < 2000; ++i)
        leaves.push_back({anyNormal(random), 1});
    const glm::dvec3 guess = leaning(8, 1);
    EXPECT_LT(degreesBetweenUps(levelled(guess, leaves), guess), 3);
    EXPECT_EQ(levelled(guess, {}), guess);
}

TEST(Upright, OfWallsThatRunOneWayTheGuessDecidesWhatTheyLeaveOpen) {
    const std::vector<Facing> walls(100, Facing{{1, 0, 0}, 1});
    const glm::dvec3 up = levelled(leaning(8, 0.5), walls);
    EXPECT_NEAR(up.x, 0, 0.002) << "upright, to a tenth of a degree";
    EXPECT_NEAR(std::atan2(up.y, up.z), std::atan2(leaning(8, 0.5).y, leaning(8, 0.5).z), 0.002) << "no more than that";
}

TEST(Upright, FacingsOfAnImageAreThoseOfItsSurfaces) {
    // A floor 2 m below, and a wall, seen askew.
    const Camera camera = smallCamera();
    const View view = viewFrom({0, 0, 2}, {3, 0.5, 0.6});
    for (const glm::dvec4& plane : {glm::dvec4(0, 0, 1, 0), glm::dvec4(1, 0, 0, 6)}) {
        const glm::dvec3 normal(plane.x, plane.y, plane.z);
        const glm::dmat3 cameraFromWorld = glm::transpose(view.worldFromEye.rotation);
        const double offset = plane.w - glm::dot(normal, view.worldFromEye.translation);
        DepthImage image = imageOf(camera, view.worldFromEye, [&](double x, double y) {
            return std::max(planeDisparity(camera, cameraFromWorld * normal, offset, x, y), 0.0);
        });
        for (int y = 0; y < camera.height; ++y)
            for (int x = 0; x < camera.width; ++x)
                if (!(image.disparity(x, y) > 0)) image.flags(x, y) = kNoSurface;
        const TileSet tiles = cutIntoTiles(image);
        std::vector<Facing> facings;
        addFacings(lend(tiles, camera, view.worldFromEye), facings);
        ASSERT_GT(facings.size(), 4u);
        for (const Facing& facing : facings)
            EXPECT_GT(std::abs(glm::dot(facing.normal, normal)), std::cos(0.5 * kDegreeOfUp));
    }
}

} // namespace
} // namespace scene
