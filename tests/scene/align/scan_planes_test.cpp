// Panoramas and the planes in them, against places whose walls are known.

#include "scene/align/panorama_places.h"
#include "scene/align/plane_candidates.h"
#include "scene/align/scan_planes.h"

#include "tests/scene/align/scanned_places.h"

#include <algorithm>

#include <glm/gtc/quaternion.hpp>
#include <gtest/gtest.h>

namespace scene {
namespace {

TEST(Panorama, EveryDirectionHasItsCell) {
    Panorama panorama;
    panorama.cells = Image<PanoramaCell>(2 * kCoarseRows, kCoarseRows);
    SeededSequence chance(1);
    for (int i = 0; i < 1000; ++i) {
        const glm::dvec3 d = glm::normalize(glm::dvec3(chance.normal(), chance.normal(), chance.normal()));
        const auto place = panorama.placeOf(d);
        ASSERT_TRUE(place.has_value());
        const double azimuth = ((*place)[0] + 0.5) * panorama.stepRadians() - 3.141592653589793,
                     elevation = ((*place)[1] + 0.5) * panorama.stepRadians() - 1.5707963267948966;
        const glm::dvec3 middle(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                                std::sin(elevation));
        EXPECT_GT(glm::dot(d, middle), std::cos(0.75 * panorama.stepRadians()));
    }
    EXPECT_FALSE(panorama.placeOf({0, 0, 0}).has_value());
    EXPECT_FALSE(panorama.placeOf({std::numeric_limits<double>::infinity(), 0, 1}).has_value());
    for (const double z : {-2.0, 2.0})
        EXPECT_EQ((*panorama.placeOf({0, 0, z}))[1], z < 0 ? 0 : panorama.height() - 1);
    // The same cells as by the library's own functions, but for directions right between two.
    for (int i = 0; i < 200'000; ++i) {
        const double azimuth = -3.141592653589793 + 6.283185307179586 * std::fmod(i * 0.6180339887498949, 1.0),
                     elevation = -1.5707963267948966 + 3.141592653589793 * std::fmod(i * 0.7548776662466927, 1.0);
        const glm::dvec3 d(std::cos(azimuth) * std::cos(elevation), std::sin(azimuth) * std::cos(elevation),
                           std::sin(elevation));
        const auto place = panorama.placeOf(3.0 * d);
        const double x = (azimuth + 3.141592653589793) / panorama.stepRadians(),
                     y = (elevation + 1.5707963267948966) / panorama.stepRadians();
        ASSERT_TRUE(place.has_value());
        ASSERT_LE(std::abs(x - ((*place)[0] + 0.5)), 0.50001) << azimuth << " " << elevation;
        ASSERT_LE(std::abs(y - ((*place)[1] + 0.5)), 0.50001) << azimuth << " " << elevation;
    }
}

TEST(Panorama, PlacesOfManyPointsAreThoseOfEach) {
    const std::vector<glm::vec3> special{{0, 0, 0},
                                         {0, 0, 1},
                                         {0, 0, -1},
                                         {1, 0, 0},
                                         {-1, 0, 0},
                                         {-1, -0.f, 0},
                                         {0, 1, 0},
                                         {0, -1, 0},
                                         {1e-30f, 0, 1e9f},
                                         {1e30f, 0, 0},
                                         {-2, 2, 0},
                                         {3, 3, 3},
                                         {std::numeric_limits<float>::quiet_NaN(), 0, 1},
                                         {0, std::numeric_limits<float>::infinity(), 1}};
    SeededSequence chance(2);
    PanoramaPlaces places;
    int differentCells = 0;
    for (const int rows : {1, kCoarseRows, kFineRows}) {
        Panorama panorama;
        panorama.cells = Image<PanoramaCell>(2 * rows, rows);
        for (int round = 0; round < 100; ++round) {
            Pose pose; // of the first round none
            if (round > 0)
                pose = {glm::dmat3(glm::angleAxis(
                            3 * chance.normal(),
                            glm::normalize(glm::dvec3(chance.normal(), chance.normal(), chance.normal())))),
                        {chance.normal(), chance.normal(), chance.normal()}};
            std::vector<glm::vec3> points = special;
            for (int i = 0; i < 37 * round; ++i)
                points.emplace_back(5 * chance.normal(), 5 * chance.normal(), 5 * chance.normal());
            places.clear();
            for (const glm::vec3& point : points)
                places.add(point);
            places.find(pose, rows);
            ASSERT_EQ(places.count(), static_cast<int>(points.size()));
            for (int i = 0; i < places.count(); ++i) {
                const glm::dvec3 p = pose * glm::dvec3(points[static_cast<std::size_t>(i)]);
                const auto place = panorama.placeOf(p);
                ASSERT_EQ(places.cell(i), place ? (*place)[1] * 2 * rows + (*place)[0] : -1)
                    << "point " << i << " of round " << round << ", " << rows << " rows";
                if (!std::isfinite(p.x + p.y + p.z)) continue;
                ASSERT_EQ(places.point(i), p) << "point " << i;
                differentCells += i > 0 && places.cell(i) != places.cell(i - 1);
            }
        }
    }
    EXPECT_GT(differentCells, 100'000);
}

TEST(ScanPlanes, WallsOfARoomAreFoundWhereTheyAre) {
    const SyntheticScene place = office();
    const Pose worldFromScanner = setUpAt({2.6, 2.4, 1.5}, 7);
    Panorama panorama;
    const Scan scan = scanFrom(place, worldFromScanner, 1);
    panorama = panoramaOf(scan);
    const std::vector<ScanPlane> planes = planesOf(scan, panorama);
    struct Wall {
        glm::dvec3 normal;
        double offset;
    };
    for (const Wall& wall : {Wall{{0, 0, 1}, 0}, Wall{{0, 0, -1}, -2.7}, Wall{{1, 0, 0}, 0}, Wall{{-1, 0, 0}, -6},
                             Wall{{0, 1, 0}, 0}, Wall{{0, -1, 0}, -5}, Wall{{0, 0, 1}, 0.75}}) {
        // The largest one that lies there, in the world.
        const auto found = std::find_if(planes.begin(), planes.end(), [&](const ScanPlane& plane) {
            return glm::dot(worldFromScanner.rotation * plane.normal, wall.normal) > 0.99 &&
                   std::abs(glm::dot(wall.normal, worldFromScanner * plane.middle) - wall.offset) < 0.05;
        });
        ASSERT_NE(found, planes.end()) << "no plane at " << wall.offset;
        EXPECT_LT(std::acos(std::min(glm::dot(worldFromScanner.rotation * found->normal, wall.normal), 1.0)), 0.0015);
        EXPECT_NEAR(glm::dot(wall.normal, worldFromScanner * found->middle), wall.offset, 0.002);
        EXPECT_LT(found->noiseMetres, 0.009);
        EXPECT_LT(found->offset, 0) << "it is seen from where its normal points";
    }
    EXPECT_GT(planes[0].areaSquareMetres, 8) << "the largest first";
    EXPECT_LT(planes[0].areaSquareMetres, 32);
    for (const PanoramaCell& cell : panorama.cells.pixels())
        ASSERT_LT(cell.plane, static_cast<int>(planes.size()));
}

TEST(ScanPlanes, AStepOfFiveCentimetresIsTwoPlanes) {
    BoxPlace place;
    place.addHall({0, 0, 0}, {5, 4, 2.6}).add({3, 0, 0}, {5, 4, 0.05});
    const SyntheticScene scene = place.build();
    const Scan scan = scanFrom(scene, {glm::dmat3(1), {2.5, 2, 1.5}}, 1);
    Panorama panorama = panoramaOf(scan);
    std::vector<double> floors;
    for (const ScanPlane& plane : planesOf(scan, panorama))
        if (plane.normal.z > 0.99 && plane.areaSquareMetres > 1) floors.push_back(1.5 + plane.offset);
    std::sort(floors.begin(), floors.end());
    ASSERT_EQ(floors.size(), 2u);
    EXPECT_NEAR(floors[0], 0, 0.003);
    EXPECT_NEAR(floors[1], 0.05, 0.003);
}

/// Planes of an instrument without faults.
ScanPlane planeAt(const glm::dvec3& normal, const glm::dvec3& through, double area, const Pose& scannerFromWorld) {
    ScanPlane plane;
    plane.normal = scannerFromWorld.rotation * normal;
    plane.middle = scannerFromWorld * through;
    plane.offset = glm::dot(plane.normal, plane.middle);
    plane.areaSquareMetres = area;
    plane.samples = 10'000;
    plane.noiseMetres = 0.005;
    return plane;
}

std::vector<ScanPlane> knownPlanes(const Pose& scannerFromWorld) {
    return {planeAt({1, 0, 0}, {-2, 0.3, 1}, 9, scannerFromWorld),
            planeAt({0, 1, 0}, {0.2, -3, 1}, 8, scannerFromWorld),
            planeAt({0, 0, 1}, {0, 0, -1.5}, 20, scannerFromWorld),
            planeAt({-0.6, 0.8, 0}, {2, -1, 1}, 5, scannerFromWorld)};
}

TEST(PlaneCandidates, MatchedPlanesGiveThePoseInClosedForm) {
    for (std::uint64_t seed = 1; seed <= 50; ++seed) {
        const Pose worldFromB = setUpAt({0.3, -0.7, 0.2}, seed);
        const std::vector<ScanPlane> a = knownPlanes({}), b = knownPlanes(inverse(worldFromB));
        Pose found;
        ASSERT_TRUE(poseFromMatches(a, b, {{0, 0}, {1, 1}, {2, 2}}, found));
        EXPECT_LT(degreesBetween(found, worldFromB), 1e-6);
        EXPECT_LT(metresBetween(found, worldFromB), 1e-9);
        const std::vector<PoseCandidate> candidates = findCandidates(a, b);
        ASSERT_FALSE(candidates.empty());
        EXPECT_LT(degreesBetween(candidates[0].aFromB, worldFromB), 1e-6) << "without being told which is which";
        EXPECT_LT(metresBetween(candidates[0].aFromB, worldFromB), 1e-9);
    }
}

TEST(PlaneCandidates, PlanesThatLeaveAPoseOpenGiveNone) {
    std::vector<ScanPlane> a = knownPlanes({});
    Pose pose;
    EXPECT_FALSE(poseFromMatches(a, a, {{0, 0}}, pose));
    EXPECT_FALSE(poseFromMatches(a, a, {{0, 0}, {1, 1}}, pose)) << "free to slide along both";
    EXPECT_FALSE(poseFromMatches(a, a, {{0, 0}, {1, 1}, {3, 3}}, pose)) << "all three upright";
    a.resize(1);
    EXPECT_TRUE(findCandidates(a, a).empty());
    EXPECT_TRUE(findCandidates({}, a).empty());
}

} // namespace
} // namespace scene
