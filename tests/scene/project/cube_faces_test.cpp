// Scans of rooms whose every distance is known, projected and compared with the truth.

#include "scene/project/cube_faces.h"
#include "scene/project/cube_layout.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace scene {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
using RangeAlong = std::function<double(const glm::dvec3&)>; ///< unit direction -> range; 0: no return

// The room about the scanner: walls at x = -3 and 4, y = -2 and 5, floor at z = -1.5, ceiling at z = 2.
const glm::dvec3 kLow(-3, -2, -1.5), kHigh(4, 5, 2);

double rangeToRoom(const glm::dvec3& ray) {
    double range = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis)
        if (ray[axis] != 0) range = std::min(range, (ray[axis] > 0 ? kHigh : kLow)[axis] / ray[axis]);
    return range;
}

// The same room with a ball in it.
double rangeToRoomWithBall(const glm::dvec3& ray) {
    const glm::dvec3 centre(2, 0.5, 0.1);
    const double along = glm::dot(ray, centre), off2 = glm::dot(centre, centre) - along * along, radius2 = 0.36;
    return along > 0 && off2 < radius2 ? along - std::sqrt(radius2 - off2) : rangeToRoom(ray);
}

struct Sweep {
    double stepDegrees = 1.0, azimuthFrom = 0.37, azimuthTo = 360.0, elevationFrom = -60.2, elevationTo = 90.0;
};

Scan sweep(const RangeAlong& rangeAlong, const Sweep& s = {}) {
    Scan scan;
    scan.name = "room";
    scan.hasColour = true;
    scan.columns = static_cast<int>((s.azimuthTo - s.azimuthFrom) / s.stepDegrees) + 1;
    scan.rows = static_cast<int>((s.elevationTo - s.elevationFrom) / s.stepDegrees) + 1;
    for (int column = 0; column < scan.columns; ++column)
        for (int row = 0; row < scan.rows; ++row) {
            const double azimuth = (s.azimuthFrom + column * s.stepDegrees) * kDegree;
            const double elevation = (s.elevationFrom + row * s.stepDegrees) * kDegree;
            const glm::dvec3 ray(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                                 std::sin(elevation));
            const double range = rangeAlong(ray);
            if (range <= 0) continue;
            scan.pointsInScanner.emplace_back(glm::vec3(range * ray));
            scan.colours.push_back({static_cast<std::uint8_t>(128 + 100 * ray.x),
                                    static_cast<std::uint8_t>(128 + 100 * ray.y),
                                    static_cast<std::uint8_t>(128 + 100 * ray.z)});
            scan.row.push_back(row);
            scan.column.push_back(column);
        }
    return scan;
}

Scan loose(const std::vector<glm::vec3>& points) {
    Scan scan;
    scan.name = "loose";
    scan.hasColour = true;
    scan.pointsInScanner = points;
    for (std::size_t i = 0; i < points.size(); ++i)
        scan.colours.push_back({static_cast<std::uint8_t>(i * 10), 0, 0});
    return scan;
}

const DepthImage* faceNamed(const CubeFaces& faces, const std::string& name) {
    for (const DepthImage& face : faces.faces)
        if (face.name == name) return &face;
    return nullptr;
}

void forEachSample(const CubeFaces& faces, const std::function<void(const DepthImage&, int, int)>& visit) {
    for (const DepthImage& face : faces.faces)
        for (int y = 0; y < face.camera.height; ++y)
            for (int x = 0; x < face.camera.width; ++x)
                if (isSurface(face.flags(x, y))) visit(face, x, y);
}

glm::dvec3 directionAt(const DepthImage& face, double x, double y) {
    return glm::normalize(face.worldFromCamera.rotation * rayThrough(face.camera, x, y));
}

glm::dvec3 pointAt(const DepthImage& face, int x, int y) {
    return face.worldFromCamera * (rayThrough(face.camera, x + 0.5, y + 0.5) / double{face.disparity(x, y)});
}

bool isInterior(const DepthImage& face, int x, int y) {
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
            const int u = x + dx, v = y + dy;
            if (u < 0 || v < 0 || u >= face.camera.width || v >= face.camera.height) return false;
            if (!isSurface(face.flags(u, v))) return false;
        }
    return true;
}

// The wall a direction meets: axis and side.
int wallAlong(const glm::dvec3& ray) {
    const glm::dvec3 p = ray * rangeToRoom(ray);
    for (int axis = 0; axis < 3; ++axis)
        if (std::abs(p[axis] - (ray[axis] > 0 ? kHigh : kLow)[axis]) < 1e-9) return 2 * axis + (ray[axis] > 0);
    return -1;
}

// True if the directions within two pixels all meet one wall, so that no triangle there bridges a corner of
// the room.
bool isWithinOneWall(const DepthImage& face, int x, int y) {
    const int wall = wallAlong(directionAt(face, x + 0.5, y + 0.5));
    for (int dy = -3; dy <= 3; dy += 3)
        for (int dx = -3; dx <= 3; dx += 3)
            if (wallAlong(directionAt(face, x + 0.5 + dx, y + 0.5 + dy)) != wall) return false;
    return true;
}

TEST(CubeFaces, PlanesStayPlanesToRounding) {
    const CubeFaces faces = projectToCubeFaces(sweep(rangeToRoom));
    std::int64_t checked = 0;
    double worst = 0;
    forEachSample(faces, [&](const DepthImage& face, int x, int y) {
        if (!isInterior(face, x, y) || !isWithinOneWall(face, x, y)) return;
        const double range = glm::length(pointAt(face, x, y));
        worst = std::max(worst, std::abs(range / rangeToRoom(directionAt(face, x + 0.5, y + 0.5)) - 1));
        ++checked;
    });
    EXPECT_GT(checked, 50000);
    EXPECT_LT(worst, 1e-6)
        << "relative; single precision has 6e-8, at a grazing angle of 10 degrees some ten times that";
}

TEST(CubeFaces, EveryPointOfAWholeSweepIsHeld) {
    const Scan scan = sweep(rangeToRoom);
    const CubeFaces faces = projectToCubeFaces(scan);
    EXPECT_EQ(faces.report.points, static_cast<std::int64_t>(scan.pointsInScanner.size()));
    EXPECT_EQ(faces.report.held, faces.report.points);
    EXPECT_EQ(faces.report.dropped, 0);
    EXPECT_NEAR(faces.report.columnStepRadians, kDegree, 1e-6);
    EXPECT_NEAR(faces.report.rowStepRadians, kDegree, 1e-6);
    EXPECT_FALSE(faces.report.coarserThanScan);
    for (const char* name : {"room-front", "room-left", "room-back", "room-right", "room-up", "room-down"})
        EXPECT_NE(faceNamed(faces, name), nullptr) << name;
}

TEST(CubeFaces, EveryPointIsFoundWhereItStands) {
    const Scan scan = sweep(rangeToRoomWithBall);
    const CubeFaceOptions options;
    const CubeFaces faces = projectToCubeFaces(scan, options);
    for (std::size_t i = 0; i < scan.pointsInScanner.size(); ++i) {
        const glm::dvec3 p(scan.pointsInScanner[i]);
        double nearest = 1e9;
        for (const DepthImage& face : faces.faces) {
            const glm::dvec3 inCamera = inverse(face.worldFromCamera) * p;
            if (inCamera.z <= 0) continue;
            const glm::dvec2 place = project(face.camera, inCamera);
            const int x = static_cast<int>(std::floor(place.x)), y = static_cast<int>(std::floor(place.y));
            if (x < 0 || y < 0 || x >= face.camera.width || y >= face.camera.height) continue;
            if (!isSurface(face.flags(x, y))) continue;
            nearest = std::min(nearest, std::abs(inCamera.z * face.disparity(x, y) - 1));
        }
        ASSERT_LT(nearest, 3 * options.sameSurface) << "point " << i;
    }
}

TEST(CubeFaces, CellsOfSideFacesNeverShareAPixel) {
    Sweep side;
    side.elevationFrom = -33.3, side.elevationTo = 33;
    const Scan scan = sweep(rangeToRoom, side);
    const CubeFaces faces = projectToCubeFaces(scan);
    EXPECT_EQ(faces.report.pixels, std::ssize(scan.pointsInScanner));
    EXPECT_EQ(faces.faces.size(), 4u) << "no layers, no up, no down";
}

TEST(CubeFaces, NoSampleHangsBetweenFrontAndBack) {
    Sweep fine;
    fine.stepDegrees = 0.5;
    const CubeFaces faces = projectToCubeFaces(sweep(rangeToRoomWithBall, fine));
    EXPECT_EQ(faces.report.dropped, 0);
    int onBall = 0;
    forEachSample(faces, [&](const DepthImage& face, int x, int y) {
        const double range = glm::length(pointAt(face, x, y));
        double nearest = 1e9;
        for (double dy = -1; dy <= 2 && nearest >= 0.02; dy += 0.25)
            for (double dx = -1; dx <= 2 && nearest >= 0.02; dx += 0.25) {
                const double truth = rangeToRoomWithBall(directionAt(face, x + dx, y + dy));
                nearest = std::min(nearest, std::abs(range / truth - 1));
            }
        ASSERT_LT(nearest, 0.02) << face.name << " " << x << " " << y << " at " << range << " m";
        onBall += range < 2.0 && std::abs(pointAt(face, x, y).z - 0.1) < 0.5;
    });
    EXPECT_GT(onBall, 500);
}

TEST(CubeFaces, TheFacesCloseAroundTheScanner) {
    const CubeFaces faces = projectToCubeFaces(sweep(rangeToRoom));
    // Any direction the scanner saw lies on a sample of some face, across the seams of the cube and of the
    // sweep alike.
    std::mt19937 random(4);
    std::uniform_real_distribution<double> azimuth(-180, 180), elevation(-59, 88.5);
    for (int i = 0; i < 20000; ++i) {
        const double a = azimuth(random) * kDegree, e = elevation(random) * kDegree;
        const glm::dvec3 ray(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e));
        bool seen = false;
        for (const DepthImage& face : faces.faces) {
            const glm::dvec3 inCamera = glm::transpose(face.worldFromCamera.rotation) * ray;
            if (inCamera.z <= 0.5) continue;
            const glm::dvec2 place = project(face.camera, inCamera);
            const int x = static_cast<int>(std::floor(place.x)), y = static_cast<int>(std::floor(place.y));
            seen |= x >= 0 && y >= 0 && x < face.camera.width && y < face.camera.height && isSurface(face.flags(x, y));
        }
        ASSERT_TRUE(seen) << "azimuth " << a / kDegree << ", elevation " << e / kDegree;
    }
}

TEST(CubeFaces, FacesLookAsTheirNamesSay) {
    Scan scan = sweep(rangeToRoom);
    scan.worldFromScanner = {glm::dmat3(0, 1, 0, -1, 0, 0, 0, 0, 1), glm::dvec3(10, 20, 30)}; // a quarter turn
    const CubeFaces faces = projectToCubeFaces(scan);
    const auto forward = [&](const char* name) { return faceNamed(faces, name)->worldFromCamera.rotation[2]; };
    EXPECT_LT(glm::distance(forward("room-front"), glm::dvec3(0, 1, 0)), 1e-12);
    EXPECT_LT(glm::distance(forward("room-left"), glm::dvec3(-1, 0, 0)), 1e-12);
    EXPECT_LT(glm::distance(forward("room-up"), glm::dvec3(0, 0, 1)), 1e-12);
    EXPECT_LT(glm::distance(faceNamed(faces, "room-front")->worldFromCamera.rotation[1], glm::dvec3(0, 0, -1)), 1e-12);
    EXPECT_LT(glm::distance(faceNamed(faces, "room-up")->worldFromCamera.translation, glm::dvec3(10, 20, 30)), 1e-12);
    for (const DepthImage& face : faces.faces)
        EXPECT_NEAR(glm::determinant(face.worldFromCamera.rotation), 1.0, 1e-12) << face.name;
}

TEST(CubeFaces, WhatWasSeenStandsInFrontAndTheRestIsCutAway) {
    Sweep narrow;
    narrow.azimuthFrom = 100.2, narrow.azimuthTo = 140, narrow.elevationFrom = -10.2, narrow.elevationTo = 10;
    const CubeFaces faces = projectToCubeFaces(sweep(rangeToRoom, narrow));
    ASSERT_EQ(faces.faces.size(), 1u);
    EXPECT_EQ(faces.faces[0].name, "room-front");
    const Camera& camera = faces.faces[0].camera;
    EXPECT_LT(camera.width, 50);
    EXPECT_LT(camera.height, 30);
    EXPECT_LT(glm::distance(faces.faces[0].worldFromCamera.rotation[2],
                            glm::dvec3(std::cos(120 * kDegree), std::sin(120 * kDegree), 0)),
              0.02);
}

TEST(CubeFaces, RowsAndColumnsMayBeSwapped) {
    Scan scan = sweep(rangeToRoom);
    const CubeFaces usual = projectToCubeFaces(scan);
    std::swap(scan.rows, scan.columns);
    std::swap(scan.row, scan.column);
    const CubeFaces swapped = projectToCubeFaces(scan);
    EXPECT_EQ(swapped.report.dropped, 0);
    EXPECT_NEAR(swapped.report.columnStepRadians, usual.report.columnStepRadians, 1e-9);
    EXPECT_EQ(swapped.faces.size(), usual.faces.size());
}

TEST(CubeFaces, PointsInOnePixelAreClustered) {
    // Pixels of about 0.1 rad, and three points straight ahead: two at 1 m, one at 3 m.
    std::vector<glm::vec3> points;
    for (int i = -3; i <= 3; ++i)
        if (i != 0) points.emplace_back(2.0f, 0.2f * static_cast<float>(i), 0.01f);
    points.insert(points.end(),
                  {glm::vec3(3, 0.003f, 0.003f), glm::vec3(1, 0.001f, 0.001f), glm::vec3(1.01f, 0.002f, 0.002f)});
    const CubeFaces faces = projectToCubeFaces(loose(points));
    EXPECT_EQ(faces.report.held, 9);
    const DepthImage *first = faceNamed(faces, "loose-front"), *second = faceNamed(faces, "loose-front-2");
    ASSERT_NE(first, nullptr);
    ASSERT_NE(second, nullptr);
    EXPECT_EQ(first->camera, second->camera);
    std::vector<float> depths, further;
    forEachSample(faces, [&](const DepthImage& face, int x, int y) {
        (&face == first ? depths : further).push_back(1 / face.disparity(x, y));
    });
    EXPECT_EQ(std::count_if(depths.begin(), depths.end(), [](float z) { return z > 1 && z < 1.01; }), 1)
        << "the mean of the heavier cluster wins";
    ASSERT_EQ(further.size(), 1u);
    EXPECT_FLOAT_EQ(further[0], 3.0f) << "and the lighter one is exactly its point";
}

TEST(CubeFaces, WhatIsDeeperThanTheLayersIsCounted) {
    std::vector<glm::vec3> points{{2, 1, 0}, {2, -1, 0}};
    for (int i = 0; i < 6; ++i)
        points.emplace_back(static_cast<float>(1 << i), 0.0f, 0.0f);
    CubeFaceOptions options;
    options.maxLayers = 2;
    const CubeFaces faces = projectToCubeFaces(loose(points), options);
    EXPECT_EQ(faces.report.dropped, 3);
    EXPECT_EQ(faces.report.held, 5);
    EXPECT_EQ(faces.faces.size(), 3u);
    EXPECT_EQ(faces.faces[2].name, "loose-front-3");
}

TEST(CubeFaces, PointsAtTheScannerAreDroppedAndCounted) {
    Scan scan = sweep(rangeToRoom);
    scan.pointsInScanner[0] = glm::vec3(0.0f);
    scan.pointsInScanner[7] = glm::vec3(5e-5f, 0, 0);
    const CubeFaces faces = projectToCubeFaces(scan);
    EXPECT_EQ(faces.report.dropped, 2);
    EXPECT_EQ(faces.report.held + 2, faces.report.points);
    forEachSample(faces, [&](const DepthImage& face, int x, int y) {
        ASSERT_TRUE(std::isfinite(face.disparity(x, y)) && face.disparity(x, y) > 0);
        ASSERT_GE(glm::length(pointAt(face, x, y)), 1e-4);
    });
}

TEST(CubeFaces, TooDenseAScanIsProjectedAtTheLargestSize) {
    CubeFaceOptions options;
    options.maxFaceSize = 64;
    const CubeFaces faces = projectToCubeFaces(sweep(rangeToRoom), options);
    EXPECT_TRUE(faces.report.coarserThanScan);
    EXPECT_EQ(faces.report.held + faces.report.dropped, faces.report.points);
    EXPECT_EQ(faces.report.dropped, 0);
    for (const DepthImage& face : faces.faces) {
        EXPECT_LE(face.camera.width, 64);
        EXPECT_LE(face.camera.height, 64);
    }
}

// As surveyors' scanners have them: 0.29 mrad between samples.
TEST(CubeFaces, ADenseScanHasItsOwnDensity) {
    Sweep dense;
    dense.azimuthFrom = -40, dense.azimuthTo = 40, dense.elevationFrom = -1, dense.elevationTo = 1;
    dense.stepDegrees = 0.0165;
    const CubeFaces faces = projectToCubeFaces(sweep(rangeToRoom, dense));
    EXPECT_FALSE(faces.report.coarserThanScan);
    EXPECT_EQ(faces.report.held, faces.report.points);
    ASSERT_EQ(faces.faces.size(), 1u);
    const double stepRadians = dense.stepDegrees * kDegree;
    EXPECT_NEAR(faces.faces[0].camera.fx, 1 / stepRadians, 0.01 / stepRadians);
    EXPECT_GT(faces.faces[0].camera.width, 5000);
}

TEST(CubeFaces, FewPointsTakeNoMemoryForMillions) {
    std::vector<glm::vec3> points;
    for (int y = -10; y <= 10; ++y)
        for (int z = -10; z <= 10; ++z)
            points.emplace_back(10.0f, 0.9f * static_cast<float>(y), 0.9f * static_cast<float>(z));
    const Scan scan = loose(points);
    const auto layouts = layOutFaces(scan, cubeFrame(scan, glm::dvec3(0)), {1e-5, 1e-5}, false, {});
    EXPECT_TRUE(layouts[0].coarserThanScan);
    EXPECT_LE(static_cast<double>(layouts[0].camera.width) * layouts[0].camera.height, 4096.0 * 4096.0);
}

TEST(CubeFaces, LoosePointsWithACrowdedOriginAreSeenFromTheRoomiestPlace) {
    // A room whose origin is a corner of its floor.
    std::mt19937 random(5);
    std::uniform_real_distribution<float> unit(0, 1);
    std::vector<glm::vec3> points;
    for (int i = 0; i < 30000; ++i) {
        glm::vec3 p(unit(random) * 6, unit(random) * 5, unit(random) * 3);
        p[i % 3] = i % 2 ? 0.0f : glm::vec3(6, 5, 3)[i % 3];
        points.push_back(p);
    }
    const CubeFaces faces = projectToCubeFaces(loose(points));
    EXPECT_EQ(faces.report.dropped, 0);
    EXPECT_TRUE(faces.report.isFromElsewhere);
    const glm::dvec3 cop = faces.faces.at(0).worldFromCamera.translation;
    EXPECT_GT(cop.x, 1);
    EXPECT_GT(cop.y, 1);
    EXPECT_GT(cop.z, 0.5);
    EXPECT_LT(cop.z, 2.5);
}

TEST(CubeFaces, LoosePointsOfAScannerKeepItsOrigin) {
    Scan scan = sweep(rangeToRoom);
    scan.rows = scan.columns = 0;
    scan.row.clear();
    scan.column.clear();
    const CubeFaces faces = projectToCubeFaces(scan);
    EXPECT_EQ(faces.report.held, faces.report.points);
    EXPECT_FALSE(faces.report.isFromElsewhere);
    EXPECT_EQ(faces.faces.at(0).worldFromCamera.translation, glm::dvec3(0.0));
    EXPECT_GT(faces.report.columnStepRadians, 0.1 * kDegree);
    EXPECT_LT(faces.report.columnStepRadians, 1.01 * kDegree);
}

TEST(CubeFaces, AGridThatIsNoneIsProjectedAsLoosePoints) {
    Scan scan = sweep(rangeToRoom);
    std::mt19937 random(6);
    std::shuffle(scan.pointsInScanner.begin(), scan.pointsInScanner.end(), random);
    const CubeFaces faces = projectToCubeFaces(scan);
    EXPECT_EQ(faces.report.held, faces.report.points);
    std::int64_t nearest = 0; // of the first layers: those of further ones end in a number
    forEachSample(faces, [&](const DepthImage& face, int, int) { nearest += std::isdigit(face.name.back()) == 0; });
    EXPECT_EQ(nearest, faces.report.pixels) << "no mesh between points that are no neighbours";
}

TEST(CubeFaces, RangeWithoutColourIsFlagged) {
    Scan scan = sweep(rangeToRoom);
    scan.hasColour = false;
    const CubeFaces faces = projectToCubeFaces(scan);
    forEachSample(faces, [&](const DepthImage& face, int x, int y) { ASSERT_TRUE(face.flags(x, y) & kNoColour); });
}

TEST(CubeFaces, PointsWithoutColourAreFlaggedAmongOthersAndGiveThemNoGrey) {
    Scan half = sweep(rangeToRoom);
    const Rgb8 none{255, 0, 255}; // colours of the sweep have green of 128 and more where y is positive
    for (std::size_t i = 0; i < half.pointsInScanner.size(); ++i) {
        half.isColoured.push_back(half.pointsInScanner[i].y > 0);
        if (!half.isColoured[i]) half.colours[i] = none;
    }
    for (const bool onGrid : {true, false}) {
        if (!onGrid) half.rows = half.columns = 0, half.row = {}, half.column = {};
        int with = 0, without = 0;
        forEachSample(projectToCubeFaces(half), [&](const DepthImage& face, int x, int y) {
            const Rgb8 c = face.colour(x, y);
            ASSERT_TRUE(c == none || c.g >= 127) << "a mixture at " << x << ", " << y << " of " << face.name;
            if (c == none) {
                ++without;
                ASSERT_TRUE(face.flags(x, y) & kNoColour) << x << ", " << y << " of " << face.name;
            }
            with += (face.flags(x, y) & kNoColour) == 0;
        });
        EXPECT_GT(with, 1000);
        EXPECT_GT(without, 1000);
    }
}

TEST(CubeFaces, NothingAndNextToNothing) {
    EXPECT_TRUE(projectToCubeFaces(Scan{}).faces.empty());
    const CubeFaces one = projectToCubeFaces(loose({{1, 2, 3}}));
    ASSERT_EQ(one.faces.size(), 1u);
    EXPECT_EQ(one.faces[0].camera.width * one.faces[0].camera.height, 1);
    EXPECT_EQ(one.report.held, 1);
    EXPECT_EQ(projectToCubeFaces(loose({{0, 0, 0}})).report.dropped, 1);
    const CubeFaces same = projectToCubeFaces(loose(std::vector<glm::vec3>(1000, glm::vec3(1, 2, 3))));
    EXPECT_EQ(same.report.held, 1000);
    const CubeFaces far = projectToCubeFaces(loose({{1e30f, 0, 0}, {1e-3f, 0, 1e-3f}, {-1e30f, 1e30f, 1e30f}}));
    EXPECT_EQ(far.report.held + far.report.dropped, 3);
}

TEST(CubeFaces, OneThreadAndManyGiveTheSameBytes) {
    Sweep fine;
    fine.stepDegrees = 0.4;
    const Scan scan = sweep(rangeToRoomWithBall, fine);
    Scan unordered = scan;
    unordered.rows = unordered.columns = 0;
    unordered.row.clear();
    unordered.column.clear();
    for (const Scan& each : {scan, unordered}) {
        const auto on = [&](std::size_t threads) {
            const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
            return projectToCubeFaces(each);
        };
        const CubeFaces one = on(1), many = on(8);
        ASSERT_EQ(one.faces.size(), many.faces.size());
        EXPECT_EQ(one.report.held, many.report.held);
        for (std::size_t i = 0; i < one.faces.size(); ++i) {
            EXPECT_EQ(one.faces[i].name, many.faces[i].name);
            EXPECT_EQ(one.faces[i].camera, many.faces[i].camera);
            EXPECT_TRUE(one.faces[i].colour == many.faces[i].colour) << one.faces[i].name;
            EXPECT_TRUE(one.faces[i].disparity == many.faces[i].disparity) << one.faces[i].name;
            EXPECT_TRUE(one.faces[i].flags == many.faces[i].flags) << one.faces[i].name;
        }
    }
}

} // namespace
} // namespace scene
