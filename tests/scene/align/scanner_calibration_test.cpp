// The constants of a scanner, found from what it scanned, against those it was simulated with.

#include "scene/align/scanner_calibration.h"
#include "scene/errors.h"

#include "tests/repetitions.h"
#include "tests/scene/align/scanned_places.h"

#include <glm/trigonometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <span>
#include <vector>

namespace scene {
namespace {

using testing::HasSubstr;

ScannerConstants<double> asFoundByThePaper() {
    return {14039, glm::radians(44.8), 7.3, 0.128};
}

/// As the scanner's program would have it, which believes in round numbers.
Scan scanOf(const SyntheticScene& place, const Pose& worldFromScanner, std::uint32_t seed, double panDegrees,
            double noiseMetres = 0.005) {
    ScannerOptions options;
    options.constants = asFoundByThePaper();
    options.seed = seed;
    options.apertureRays = 3;
    options.noiseMetres = noiseMetres;
    options.panDegrees = panDegrees;
    setDensity(options, 3);
    Scan scan = readRawScan(simulateRawScan(worldOf(place, false), worldFromScanner, options), {}).scan;
    scan.name = "scan" + std::to_string(seed);
    return scan;
}

ScannerCalibration calibrated(const std::vector<Scan>& scans) {
    return calibrateScanner(scans.size(), [&](std::size_t i) { return scans[i]; }, {});
}

TEST(ScannerCalibration, FindsTheFourConstantsToAStepAndFiveThousandthsOfADegree) {
    const SyntheticScene place = office();
    const std::vector<Scan> scans{scanOf(place, setUpAt({1.4, 1.1, 1.5}, 1), 1, 360),
                                  scanOf(place, setUpAt({4.4, 2.9, 1.6}, 2), 2, 360)};
    const ScannerCalibration found = calibrated(scans);
    ASSERT_EQ(found.why, "");
    const ScannerConstants<double> truth = asFoundByThePaper();
    EXPECT_NEAR(found.constants.panStepsPerHalfTurn, truth.panStepsPerHalfTurn, 1);
    EXPECT_NEAR(glm::degrees(found.constants.mirrorRadians), glm::degrees(truth.mirrorRadians), 0.005);
    EXPECT_NEAR(found.constants.horizonPosition * 360 / kEncoderPositions, 7.3 * 360 / kEncoderPositions, 0.005);
    EXPECT_NEAR(found.constants.mirrorMetres, truth.mirrorMetres, 0.001);
    EXPECT_LT(found.rmsAfterMetres, 0.4 * found.rmsBeforeMetres);
    EXPECT_GE(found.planes, 10);
    // What it says of itself holds within a few deviations.
    EXPECT_LT(std::abs(found.constants.panStepsPerHalfTurn - truth.panStepsPerHalfTurn),
              4 * found.deviations.panStepsPerHalfTurn + 0.1);
    EXPECT_LT(found.deviations.panStepsPerHalfTurn, 1.5);
}

// Far ground seen glancingly: which of its noisy samples count must not depend on which side they err to.
TEST(ScannerCalibration, TwoCentimetresOfNoiseInTheOpenDrawNothingAside) {
    const SyntheticScene place = makeStreetCorner();
    std::vector<Scan> scans;
    const std::vector<Pose> tripods = scanPositions(place);
    for (const Pose& tripod : std::span(tripods).first(tests::areLong() ? tripods.size() : 2))
        scans.push_back(scanOf(place, setUpAt(tripod.translation, 1 + static_cast<std::uint32_t>(scans.size())),
                               1 + static_cast<std::uint32_t>(scans.size()), 360, 0.02));
    const ScannerCalibration found = calibrated(scans);
    ASSERT_EQ(found.why, "");
    const ScannerConstants<double> truth = asFoundByThePaper();
    std::printf("off by %.2f steps, %.4f and %.4f degrees, %.1f mm; %.1f said of the last\n",
                found.constants.panStepsPerHalfTurn - truth.panStepsPerHalfTurn,
                glm::degrees(found.constants.mirrorRadians - truth.mirrorRadians),
                (found.constants.horizonPosition - truth.horizonPosition) * 360 / kEncoderPositions,
                1e3 * (found.constants.mirrorMetres - truth.mirrorMetres), 1e3 * found.deviations.mirrorMetres);
    EXPECT_NEAR(found.constants.panStepsPerHalfTurn, truth.panStepsPerHalfTurn, 1);
    EXPECT_NEAR(glm::degrees(found.constants.mirrorRadians), glm::degrees(truth.mirrorRadians), 0.005);
    EXPECT_NEAR(found.constants.horizonPosition * 360 / kEncoderPositions,
                truth.horizonPosition * 360 / kEncoderPositions, 0.005);
    EXPECT_LT(std::abs(found.constants.mirrorMetres - truth.mirrorMetres), 2 * found.deviations.mirrorMetres);
    EXPECT_LT(found.constants.mirrorMetres - truth.mirrorMetres, 0.008);
}

/// A hall whose walls are panelled: boards of any width, as thick as noise.
SyntheticScene panelledHall() {
    const glm::dvec3 size(6, 5, 2.7);
    BoxPlace place;
    place.addHall({0, 0, 0}, size);
    SeededSequence chance(5);
    for (const int along : {0, 1})
        for (const bool isFar : {false, true})
            for (double at = 0.1; at < size[along] - 1;) {
                const double wide = chance.between(0.25, 0.9), thick = chance.between(0.01, 0.035),
                             high = chance.between(0.7, 2.6);
                glm::dvec3 low(0, 0, chance.between(0, 0.6)), top(0, 0, std::min(low.z + high, 2.65));
                low[along] = at, top[along] = at + wide;
                low[1 - along] = isFar ? size[1 - along] - thick : 0, top[1 - along] = low[1 - along] + thick;
                place.add(low, top);
                at += wide + chance.between(0.1, 0.5);
            }
    return place.build();
}

// As far as such noise lets one see, boards are part of the wall: both faces say that it is uneven.
TEST(ScannerCalibration, PanelledWallsDrawNothingAside) {
    const SyntheticScene place = panelledHall();
    const std::vector<Scan> scans{scanOf(place, setUpAt({1.4, 1.1, 1.5}, 1), 1, 360, 0.02),
                                  scanOf(place, setUpAt({4.4, 2.9, 1.6}, 10), 10, 360, 0.02)};
    const ScannerCalibration found = calibrated(scans);
    ASSERT_EQ(found.why, "");
    // With walls taken for planes: 1.19, and 0.86 said of it.
    EXPECT_NEAR(found.constants.panStepsPerHalfTurn, asFoundByThePaper().panStepsPerHalfTurn, 1);
    EXPECT_LT(found.deviations.panStepsPerHalfTurn, 0.7);
}

TEST(ScannerCalibration, ScansOfHalfATurnHoldThemLessExactlyAndOneAloneDoesNot) {
    // Each half of the mirror's turn sees another half of the room; little but floor and ceiling joins them.
    const SyntheticScene place = office();
    const std::vector<Scan> scans{scanOf(place, setUpAt({1.4, 1.1, 1.5}, 1), 1, 180),
                                  scanOf(place, setUpAt({4.4, 2.9, 1.6}, 2), 2, 180),
                                  scanOf(place, setUpAt({2.5, 3.6, 1.4}, 3), 3, 180)};
    EXPECT_THAT(calibrated({scans[0]}).why, HasSubstr("six planes"));
    const ScannerCalibration found = calibrated(scans);
    ASSERT_EQ(found.why, "");
    EXPECT_GT(found.deviations.panStepsPerHalfTurn, 0.13);
    EXPECT_LT(std::abs(found.constants.panStepsPerHalfTurn - 14039), 3 * found.deviations.panStepsPerHalfTurn);
    EXPECT_LT(std::abs(glm::degrees(found.constants.mirrorRadians) - 44.8), 0.01);
}

TEST(ScannerCalibration, OnePlaneIsRefused) {
    const SyntheticScene field = BoxPlace().add({-50, -50, -1}, {50, 50, 0}).build();
    const ScannerCalibration found = calibrated({scanOf(field, setUpAt({0, 0, 1.5}, 2), 2, 360)});
    EXPECT_THAT(found.why, HasSubstr("six planes"));
    EXPECT_EQ(found.constants.panStepsPerHalfTurn, 14000);
}

TEST(ScannerCalibration, AScanWithoutItsGridIsRefusedByName) {
    Scan loose = scanOf(office(), setUpAt({1.4, 1.1, 1.5}, 1), 1, 360);
    loose.rows = loose.columns = 0;
    loose.row.clear(), loose.column.clear();
    try {
        calibrated({loose});
        FAIL();
    } catch (const Failure& failure) {
        EXPECT_THAT(failure.what(), HasSubstr("scan1: has no grid"));
    }
    Scan shuffled = scanOf(office(), setUpAt({1.4, 1.1, 1.5}, 1), 1, 360);
    for (std::int32_t& column : shuffled.column)
        column = (column * 7919) % shuffled.columns;
    EXPECT_THROW(calibrated({shuffled}), Failure);
}

TEST(ScannerRecords, AreThoseThatTheScannerTook) {
    ScannerOptions options;
    options.constants = asFoundByThePaper();
    options.apertureRays = 1;
    options.panDegrees = 360;
    setDensity(options, 1);
    const SyntheticScene place = office();
    const RawScan raw = simulateRawScan(worldOf(place, false), setUpAt({1.4, 1.1, 1.5}, 1), options);
    const Scan read = readRawScan(raw, {}).scan;
    const ScanRecords records = recordsOf(read, {}, "scan");
    EXPECT_NEAR(records.panTurns, 1, 0.02);
    std::size_t k = 0;
    for (const RawSample& sample : raw.samples) {
        if (!(sample.rangeMetres > 0)) continue;
        const ScannerRecord& record = records.records[k++];
        ASSERT_NEAR(std::remainder(record.encoder - sample.encoder - 0.5, kEncoderPositions), 0, 0.01);
        ASSERT_NEAR(record.pan, sample.panStep + 0.5, 0.05);
        ASSERT_NEAR(record.rangeMetres, static_cast<double>(sample.rangeMetres), 1e-5);
    }
    ASSERT_EQ(k, records.records.size());

    // Read with the true constants, the points stand where they are.
    Scan anew = read;
    readAnew(anew, records, options.constants);
    const Scan right = readRawScan(raw, options.constants).scan;
    double worst = 0;
    for (std::size_t i = 0; i < anew.pointsInScanner.size(); ++i)
        worst = std::max(worst, static_cast<double>(glm::distance(anew.pointsInScanner[i], right.pointsInScanner[i])));
    EXPECT_LT(worst, 1e-4);
}

} // namespace
} // namespace scene
