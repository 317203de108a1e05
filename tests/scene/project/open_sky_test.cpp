// Directions that met the sky, against a synthetic place where it is known which did.

#include "scene/project/open_sky.h"

#include "scene/project/cube_faces.h"
#include "scene/synthetic.h"

#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

namespace scene {
namespace {

constexpr double kSameSurface = 0.02;

/// The street corner, scanned with all rays or some of them.
Scan cornerScan(int columns = 720, int rows = 300) {
    static const SyntheticScene corner = makeStreetCorner();
    ScanOptions options;
    options.withColour = false;
    return simulateScan(corner, scanPositions(corner).front(), columns, rows, options);
}

OpenSky skyOf(const Scan& scan) {
    const auto grid = gridOf(scan, kSameSurface);
    EXPECT_TRUE(grid);
    return OpenSky(scan, *grid);
}

struct Against {
    int sky = 0, open = 0, wronglyOpen = 0; ///< directions: into the sky above the horizon, taken for it, and not so
};

Against compareWithTruth(const OpenSky& sky, const Pose& worldFromScanner) {
    static const SyntheticScene corner = makeStreetCorner();
    Against found;
    for (int i = 0; i < 60; ++i)
        for (int j = 0; j < 360; ++j) {
            const double elevation = (i - 15 + 0.37) / 45 * 0.5 * std::numbers::pi, azimuth = (j + 0.21) * 0.0174532925;
            const glm::dvec3 d(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                               std::sin(elevation));
            const bool isSky = !castRay(corner, worldFromScanner.translation, worldFromScanner.rotation * d);
            const bool isOpen = sky.isOpen(d);
            found.sky += isSky && elevation > 0;
            found.open += isOpen;
            found.wronglyOpen += isOpen && !isSky;
        }
    return found;
}

TEST(OpenSky, OfAStreetIsFoundAndNothingElse) {
    const Scan scan = cornerScan();
    const OpenSky sky = skyOf(scan);
    const Against found = compareWithTruth(sky, scan.worldFromScanner);
    EXPECT_GT(found.sky, 2000);
    EXPECT_GT(found.open - found.wronglyOpen, 0.9 * found.sky) << "crowns of trees keep what is seen through them";
    EXPECT_LT(found.wronglyOpen, 0.01 * found.open) << "at most by half a cell, beside edges";
    EXPECT_NEAR(sky.share(), 1 - static_cast<double>(scan.pointsInScanner.size()) / (720. * 300), 0.1);
}

TEST(OpenSky, WhatIsBelowARoofOrTheHorizonIsNone) {
    Scan scan = cornerScan();
    const auto keep = [&](const auto& isKept) {
        Scan kept = scan;
        kept.pointsInScanner.clear(), kept.colours.clear(), kept.row.clear(), kept.column.clear();
        for (std::size_t i = 0; i < scan.pointsInScanner.size(); ++i) {
            if (!isKept(scan.row[i], scan.column[i])) continue;
            kept.pointsInScanner.push_back(scan.pointsInScanner[i]);
            kept.colours.push_back(scan.colours[i]);
            kept.row.push_back(scan.row[i]), kept.column.push_back(scan.column[i]);
        }
        return kept;
    };
    // A hole in the road, and nothing at all below the horizon.
    const OpenSky whole = skyOf(scan);
    const Scan holed = keep([](int row, int column) { return row < 230 || row > 260 || column < 100 || column > 300; });
    EXPECT_EQ(skyOf(holed).share(), whole.share());
    // A row of a lid, one cell thick, over all: nothing hangs together with the top any more.
    Scan lidded = scan;
    for (int column = 0; column < 720; ++column) {
        const double azimuth = -(column + 0.5) * 2 * std::numbers::pi / 720, elevation = 1.3;
        const int row =
            static_cast<int>(std::lround((std::numbers::pi / 2 - elevation) / (5 * std::numbers::pi / 6) * 300));
        bool isThere = false;
        for (std::size_t i = 0; i < lidded.row.size() && !isThere; ++i)
            isThere = lidded.row[i] == row && lidded.column[i] == column;
        if (isThere) continue;
        lidded.pointsInScanner.emplace_back(10 * std::cos(elevation) * std::cos(azimuth),
                                            10 * std::cos(elevation) * std::sin(azimuth), 10 * std::sin(elevation));
        lidded.colours.push_back({}), lidded.row.push_back(row), lidded.column.push_back(column);
    }
    const OpenSky above = skyOf(lidded);
    EXPECT_LT(above.share(), 0.12);
    EXPECT_FALSE(above.isOpen({1, 0.3, 1}));
    EXPECT_TRUE(above.isOpen({0.05, 0.02, 1}));
}

TEST(OpenSky, OfColumnsOverTheZenithIsTheSame) {
    // The same rays as a scanner has them that turns by half and nods over the zenith.
    const Scan scan = cornerScan();
    Scan over = scan;
    over.columns = 360, over.rows = 600;
    for (std::size_t i = 0; i < scan.row.size(); ++i) {
        const bool isBehind = scan.column[i] >= 360;
        over.column[i] = scan.column[i] % 360;
        over.row[i] = isBehind ? 299 - scan.row[i] : 300 + scan.row[i];
    }
    const OpenSky one = skyOf(scan), other = skyOf(over);
    EXPECT_NEAR(other.share(), one.share(), 0.02);
    const Against found = compareWithTruth(other, scan.worldFromScanner);
    EXPECT_GT(found.open - found.wronglyOpen, 0.9 * found.sky);
    EXPECT_LT(found.wronglyOpen, 0.01 * found.open);
}

TEST(OpenSky, IsAboveTheHorizonOfAWorldWhoseYIsUpToo) {
    Scan scan = cornerScan();
    const OpenSky upright = skyOf(scan);
    scan.worldFromScanner.rotation = glm::dmat3({0, 0, 1}, {1, 0, 0}, {0, 1, 0}) * scan.worldFromScanner.rotation;
    const OpenSky turned = skyOf(scan);
    EXPECT_EQ(turned.share(), upright.share());
    for (const glm::dvec3& below : {glm::dvec3(1, 0, -0.3), glm::dvec3(0, -1, -0.2), glm::dvec3(-1, 1, -0.6)})
        EXPECT_FALSE(turned.isOpen(below));
}

TEST(OpenSky, IsOnTheFacesThatLookThereAndOnNoOther) {
    const Scan scan = cornerScan(360, 150);
    CubeFaceOptions options;
    const CubeFaces without = projectToCubeFaces(scan, options);
    options.opensSky = true;
    const CubeFaces with = projectToCubeFaces(scan, options);
    EXPECT_EQ(with.report.held, without.report.held);
    EXPECT_EQ(without.report.skyShare, 0);
    EXPECT_GT(with.report.skyShare, 0.2);
    std::int64_t open = 0, samples = 0, samplesWithout = 0;
    for (const DepthImage& face : with.faces)
        for (int y = 0; y < face.camera.height; ++y)
            for (int x = 0; x < face.camera.width; ++x) {
                const std::uint8_t flags = face.flags(x, y);
                samples += isSurface(flags);
                if (!isOpenSky(flags)) continue;
                ++open;
                ASSERT_EQ(face.disparity(x, y), 0);
                const glm::dvec3 ray = face.worldFromCamera.rotation * rayThrough(face.camera, x + 0.5, y + 0.5);
                ASSERT_GT(ray.z, -0.03 * glm::length(ray)) << "below the horizon by more than a cell";
            }
    for (const DepthImage& face : without.faces)
        for (const std::uint8_t flags : face.flags.pixels()) {
            samplesWithout += isSurface(flags);
            ASSERT_FALSE(isOpenSky(flags));
        }
    EXPECT_EQ(samples, samplesWithout);
    EXPECT_GT(open, 10000);
}

} // namespace
} // namespace scene
