// The simulated scanner in worlds of a formula: what it records, what it loses, and what it gets wrong.

#include "scene/capture/simulated_scan.h"

#include "scene/capture/write_scans.h"
#include "scene/errors.h"
#include "scene/import/e57.h"
#include "scene/import/ptx.h"
#include "scene/project/scan_grid.h"

#include "tests/scene/scratch_folder.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numeric>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace scene {
namespace {

/// A hall of 8 x 6 x 4 m about the origin, one reflectance all over.
ScannedWorld hall(double reflectance) {
    ScannedWorld world;
    world.echo = [reflectance](const glm::dvec3& origin, const glm::dvec3& direction) -> std::optional<Echo> {
        const glm::dvec3 half(4, 3, 2);
        double nearest = 1e9;
        int wall = 0;
        for (int axis = 0; axis < 3; ++axis) {
            if (direction[axis] == 0) continue;
            const double t = (std::copysign(half[axis], direction[axis]) - origin[axis]) / direction[axis];
            if (t < nearest) nearest = t, wall = axis;
        }
        return Echo{nearest, std::abs(direction[wall]), reflectance};
    };
    return world;
}

ScannerOptions coarse(double samplesPerDegree = 1.5) {
    ScannerOptions options;
    setDensity(options, samplesPerDegree);
    return options;
}

ScannerOptions perfect() {
    ScannerOptions options = coarse();
    options.noiseMetres = 0;
    options.apertureRays = 1;
    options.leastIntensity = 0;
    return options;
}

double hallDistance(const glm::vec3& p) {
    return std::max({std::abs(double{p.x}) - 4, std::abs(double{p.y}) - 3, std::abs(double{p.z}) - 2});
}

TEST(SimulatedScan, WithoutFaultsPointsLieOnTheSurfaceWithinTheEncodersSteps) {
    const ScannerOptions options = perfect();
    const ScanWithIntensity read = readRawScan(simulateRawScan(hall(0.5), {}, options), options.constants);
    ASSERT_GT(read.scan.pointsInScanner.size(), 50'000u);
    // Half a position of the mirror and half a step of the pan unit, at 5.4 m.
    for (const glm::vec3& p : read.scan.pointsInScanner)
        EXPECT_NEAR(hallDistance(p), 0, 0.0052);
    for (std::size_t i = 0; i < read.intensities.size(); ++i) {
        const double range = glm::length(glm::dvec3(read.scan.pointsInScanner[i]));
        EXPECT_LE(read.intensities[i], 0.5 / (range * range) * 1.01);
    }
}

TEST(SimulatedScan, TheGridIsOneThatProjectionTakesForAMesh) {
    const ScannerOptions options = perfect();
    const ScanWithIntensity read = readRawScan(simulateRawScan(hall(0.5), {}, options), options.constants);
    const auto grid = gridOf(read.scan, 0.02);
    ASSERT_TRUE(grid.has_value());
    EXPECT_TRUE(grid->closes) << "half a turn of the pan unit is all round";
    EXPECT_NEAR(grid->steps.vertical, 0.01163, 0.0008) << "1.5 samples a degree, in positions of the encoder";
    std::size_t linked = 0;
    for (const std::uint8_t link : grid->links.pixels())
        linked += link == (kLinkRight | kLinkBelow);
    EXPECT_GT(static_cast<double>(linked), 0.97 * static_cast<double>(read.scan.pointsInScanner.size()));
}

TEST(SimulatedScan, ConstantsThatAreWrongBendTheWalls) {
    ScannerOptions options = perfect();
    options.constants.panStepsPerHalfTurn = 14039;
    options.constants.mirrorRadians = 0.7819;
    const RawScan raw = simulateRawScan(hall(0.5), {}, options);
    const auto worst = [&](const ScannerConstants<double>& believed) {
        double most = 0;
        for (const glm::vec3& p : readRawScan(raw, believed).scan.pointsInScanner)
            most = std::max(most, std::abs(hallDistance(p)));
        return most;
    };
    EXPECT_LT(worst(options.constants), 0.0055);
    EXPECT_GT(worst({}), 0.02) << "several centimetres, as the paper says";
}

TEST(SimulatedScan, NoiseIsAsWideAsTheReturnAllows) {
    // A ball about the scanner: one range, one intensity.
    const auto deviationAt = [](double metres, double reflectance) {
        ScannedWorld ball;
        ball.echo = [=](const glm::dvec3&, const glm::dvec3&) { return Echo{metres, 1, reflectance}; };
        ScannerOptions options = coarse(0.7);
        options.noiseMetres = 0.004;
        const RawScan raw = simulateRawScan(ball, {}, options);
        double sum = 0, squares = 0;
        int count = 0;
        for (const RawSample& sample : raw.samples) {
            if (!(sample.rangeMetres > 0)) continue;
            const double off = static_cast<double>(sample.rangeMetres) - metres - options.constants.mirrorMetres;
            sum += off, squares += off * off, ++count;
        }
        EXPECT_GT(count, 20'000);
        EXPECT_NEAR(sum / count, 0, 4 * 0.016 / std::sqrt(count)) << "noise has no bias";
        return std::sqrt(squares / count);
    };
    EXPECT_NEAR(deviationAt(kReferenceMetres, 0.5), 0.004, 0.0001);
    EXPECT_NEAR(deviationAt(2 * kReferenceMetres, 0.5), 0.008, 0.0002) << "twice as far, a quarter comes back";
    EXPECT_NEAR(deviationAt(kReferenceMetres, 0.125), 0.008, 0.0002);
    EXPECT_NEAR(deviationAt(0.5, 1), 0.002, 0.0001) << "no better than the electronics";
}

TEST(SimulatedScan, DarkAndGlancingSurfacesGiveNothingBack) {
    const auto returnedShare = [](double reflectance, double cosine) {
        ScannedWorld ball;
        ball.echo = [=](const glm::dvec3&, const glm::dvec3&) { return Echo{4, cosine, reflectance}; };
        ScannerOptions options = coarse(0.7);
        options.lowestRadians = -2;
        const RawScan raw = simulateRawScan(ball, {}, options);
        const auto returned = std::count_if(raw.samples.begin(), raw.samples.end(),
                                            [](const RawSample& sample) { return sample.rangeMetres > 0; });
        return static_cast<double>(returned) / static_cast<double>(raw.samples.size());
    };
    EXPECT_EQ(returnedShare(0.5, 1), 1);
    EXPECT_LT(returnedShare(0.004, 1), 0.001) << "black";
    EXPECT_LT(returnedShare(0.5, 0.008), 0.001) << "seen along";
    const double edge = returnedShare(0.0128, 1); // just the threshold: 0.0008 at 4 m
    EXPECT_GT(edge, 0.3);
    EXPECT_LT(edge, 0.7);
}

TEST(SimulatedScan, WhatIsBeyondReachOrUnderTheTripodIsNotThere) {
    ScannerOptions options = perfect();
    options.farthestMetres = 3.5;
    options.lowestRadians = -0.5;
    const ScanWithIntensity read = readRawScan(simulateRawScan(hall(0.5), {}, options), options.constants);
    ASSERT_FALSE(read.scan.pointsInScanner.empty());
    for (const glm::vec3& p : read.scan.pointsInScanner) {
        const double range = glm::length(glm::dvec3(p));
        EXPECT_LE(range, 3.501);
        EXPECT_GE(std::asin(static_cast<double>(p.z) / range), -0.503);
    }
}

/// A wall 4 m away behind a board 2 m away that fills half of the sky to x > 0.
ScannedWorld silhouette() {
    ScannedWorld world;
    world.echo = [](const glm::dvec3&, const glm::dvec3& d) { return Echo{d.x > 0.3 ? 2.0 : 4.0, 1, 0.5}; };
    return world;
}

TEST(SimulatedScan, SamplesFloatAtSilhouettesBetweenFrontAndBack) {
    ScannerOptions options = coarse();
    options.noiseMetres = 0;
    const auto floatingOf = [&](int rays) {
        options.apertureRays = rays;
        const ScanWithIntensity read = readRawScan(simulateRawScan(silhouette(), {}, options), options.constants);
        int floating = 0;
        for (const glm::vec3& p : read.scan.pointsInScanner) {
            const double range = glm::length(glm::dvec3(p));
            EXPECT_GE(range, 2.0 - 1e-5);
            EXPECT_LE(range, 4.0 + 1e-5);
            if (range < 2.001 || range > 3.999) continue;
            ++floating;
            EXPECT_NEAR(double{p.x} / range, 0.3, 0.012) << "within the beam's sweep of the silhouette alone";
        }
        return floating;
    };
    EXPECT_EQ(floatingOf(1), 0) << "a point sample hits the one or the other";
    EXPECT_GT(floatingOf(7), 100);
}

TEST(SimulatedScan, TheBytesFollowFromTheSeedAloneOnAnyNumberOfThreads) {
    ScannerOptions options = coarse(0.7);
    const RawScan scan = simulateRawScan(hall(0.5), {}, options);
    {
        const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
        EXPECT_EQ(simulateRawScan(hall(0.5), {}, options).samples, scan.samples);
    }
    options.seed = 2;
    EXPECT_NE(simulateRawScan(hall(0.5), {}, options).samples, scan.samples);
}

Pose somewhere() {
    return poseFromQuaternion({12.5, -3, 1.6}, 0.1, -0.2, 0.3, 0.9);
}

class WrittenScans : public testing::Test {
  protected:
    static ScanWithIntensity scanned() {
        ScannerOptions options = coarse(0.5);
        ScannedWorld world = hall(0.5);
        world.colour = [](const glm::dvec3&, const glm::dvec3& d) {
            return Rgb8{static_cast<std::uint8_t>(127 + 120 * d.x), static_cast<std::uint8_t>(127 + 120 * d.y), 9};
        };
        ScanWithIntensity read = readRawScan(simulateRawScan(world, {}, options), options.constants);
        read.scan.name = "first";
        read.scan.worldFromScanner = somewhere();
        return read;
    }

    static void expectSame(const Scan& read, const Scan& written, double tolerance) {
        ASSERT_EQ(read.pointsInScanner.size(), written.pointsInScanner.size());
        EXPECT_EQ(read.hasColour, written.hasColour);
        EXPECT_LE(read.rows, written.rows) << "the last rows look at the tripod: nothing is there";
        EXPECT_EQ(read.columns, written.columns);
        for (int axis = 0; axis < 3; ++axis)
            EXPECT_LT(glm::distance(read.worldFromScanner.rotation[axis], written.worldFromScanner.rotation[axis]),
                      1e-9);
        EXPECT_LT(glm::distance(read.worldFromScanner.translation, written.worldFromScanner.translation), 1e-9);
        // PTX orders by cell, E57 not at all.
        const auto cellsOf = [](const Scan& scan) {
            std::vector<std::size_t> order(scan.row.size());
            std::iota(order.begin(), order.end(), std::size_t{0});
            std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
                return std::pair(scan.column[a], scan.row[a]) < std::pair(scan.column[b], scan.row[b]);
            });
            return order;
        };
        const std::vector<std::size_t> a = cellsOf(read), b = cellsOf(written);
        for (std::size_t i = 0; i < a.size(); ++i) {
            ASSERT_EQ(read.row[a[i]], written.row[b[i]]);
            ASSERT_EQ(read.column[a[i]], written.column[b[i]]);
            ASSERT_LE(glm::distance(read.pointsInScanner[a[i]], written.pointsInScanner[b[i]]), tolerance);
            ASSERT_EQ(read.colours[a[i]], written.colours[b[i]]);
        }
    }

    ScratchFolder folder_;
};

TEST_F(WrittenScans, E57ComesBackAsItWas) {
    const ScanWithIntensity written = scanned();
    writeE57(folder_ / "a.e57", 2, [&](std::size_t i) {
        ScanWithIntensity scan = written;
        if (i == 1) scan.scan.name = "second", scan.scan.hasColour = false;
        return scan;
    });
    std::vector<std::string> remarks;
    const std::vector<ScanSource> sources = listE57(folder_ / "a.e57", remarks);
    EXPECT_TRUE(remarks.empty());
    ASSERT_EQ(sources.size(), 2u);
    EXPECT_EQ(sources[0].name, "first");
    EXPECT_EQ(sources[1].name, "second");
    EXPECT_EQ(sources[0].rows, written.scan.rows);
    expectSame(readE57Scan(sources[0]), written.scan, 0);
    const Scan grey = readE57Scan(sources[1]);
    EXPECT_FALSE(grey.hasColour);
    const auto brightest = std::max_element(written.intensities.begin(), written.intensities.end());
    EXPECT_EQ(grey.colours[static_cast<std::size_t>(brightest - written.intensities.begin())], (Rgb8{255, 255, 255}));
}

TEST_F(WrittenScans, WhoeverMayReadOtherFilesMayReadAnE57) {
    writeE57(folder_ / "a.e57", 1, [&](std::size_t) { return scanned(); });
    std::ofstream(folder_ / "other").close();
    EXPECT_EQ(std::filesystem::status(folder_ / "a.e57").permissions(),
              std::filesystem::status(folder_ / "other").permissions());
}

TEST_F(WrittenScans, PtxComesBackToATenthOfAMillimetre) {
    const ScanWithIntensity written = scanned();
    writePtx(folder_ / "a.ptx", 2, [&](std::size_t) { return written; });
    std::vector<std::string> remarks;
    const std::vector<ScanSource> sources = listPtx(folder_ / "a.ptx", remarks);
    EXPECT_TRUE(remarks.empty());
    ASSERT_EQ(sources.size(), 2u);
    expectSame(readPtxScan(sources[1]), written.scan, 0.0001);
}

TEST_F(WrittenScans, AFolderThatIsNotThereIsAFailure) {
    const auto none = [](std::size_t) { return ScanWithIntensity{}; };
    EXPECT_THROW(writeE57(folder_ / "no/a.e57", 1, none), Failure);
    EXPECT_THROW(writePtx(folder_ / "no/a.ptx", 1, none), Failure);
    EXPECT_FALSE(std::filesystem::exists(folder_ / "no"));
}

} // namespace
} // namespace scene
