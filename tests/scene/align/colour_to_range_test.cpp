// Photographs laid on the simulated scan they were taken beside: right to a fraction of the scan's spacing, or refused.

#include "scene/capture/simulated_camera.h"
#include "scene/project/photographs_on_scan.h"
#include "scene/synthetic_random.h"

#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace scene {
namespace {

constexpr double kPi = std::numbers::pi, kDegrees = 180 / kPi;

double degreesBetween(const glm::dmat3& a, const glm::dmat3& b) {
    return std::acos(std::clamp(cosineBetween(a, b), -1.0, 1.0)) * kDegrees;
}

glm::dmat3 turnBy(double degrees, const glm::dvec3& axis) {
    const double half = degrees / kDegrees / 2;
    const glm::dvec3 v = glm::normalize(axis) * std::sin(half);
    return poseFromQuaternion({}, v.x, v.y, v.z, std::cos(half)).rotation;
}

Pose lookingTo(double azimuth, double elevation) {
    const glm::dvec3 forward(std::cos(azimuth) * std::cos(elevation), std::sin(azimuth) * std::cos(elevation),
                             std::sin(elevation));
    const glm::dvec3 right = glm::normalize(glm::cross(forward, glm::dvec3(0, 0, 1)));
    return {glm::dmat3(right, glm::cross(forward, right), forward), glm::dvec3(0)};
}

/// Three shots of the room beside a scan of 4 samples a degree, with lens, exposure and noise; and another scan, of
/// another place in it. Overlapping by half.
struct Shots {
    CameraFile lens = usualCamera(400, 300, 65);
    ScanForPhotographs scan, elsewhere;
    std::vector<Pose> truth;
    std::vector<Image<Rgb8>> pictures;

    Shots() {
        const SyntheticScene room = makeRoom();
        const ScannedWorld world = worldOf(room, false), coloured = worldOf(room, true);
        const std::vector<Pose> tripods = scanPositions(room);
        const auto scanFrom = [&](const Pose& tripod) {
            ScannerOptions options;
            options.seed = 5;
            setDensity(options, 4);
            return forPhotographs(readRawScan(simulateRawScan(world, tripod, options), options.constants));
        };
        scan = scanFrom(tripods[0]);
        elsewhere = scanFrom(tripods[2]);
        for (int i = 0; i < 3; ++i) {
            truth.push_back(lookingTo(2.6 + 0.6 * i, -0.05));
            SimulatedCameraOptions camera;
            camera.lens = lens;
            camera.raysPerPixel = 4;
            camera.exposureStops = 0.5 - 0.5 * i;
            camera.whiteBalance = {1 + 0.1 * i, 1, 1};
            camera.seed = static_cast<std::uint32_t>(i);
            pictures.push_back(takePhotograph(coloured, tripods[0] * truth.back(), camera));
        }
    }
    static Shots& all() {
        static Shots made;
        return made;
    }

    /// As if their poses were wrong by a turn of so many degrees, each about an axis of its own.
    std::vector<PhotographForScan> turnedBy(double degrees) const {
        std::vector<PhotographForScan> turned;
        for (std::size_t i = 0; i < truth.size(); ++i) {
            Pose given = truth[i];
            given.rotation = given.rotation * turnBy(degrees, {1.0, static_cast<double>(i) - 1, 0.7});
            turned.push_back(forScan(pictures[i], lens, given, scan));
        }
        return turned;
    }
};

TEST(ColourToRange, FindsHowPhotographsAreTurnedAndSaysHowExactly) {
    Shots& shots = Shots::all();
    const std::vector<PhotographForScan> turned = shots.turnedBy(2.9);
    const std::vector<ColourFit> fits = layOnScan(shots.scan, turned);
    for (std::size_t i = 0; i < fits.size(); ++i) {
        EXPECT_TRUE(fits[i].isSure) << i << ": " << fits[i].why;
        EXPECT_NEAR(fits[i].turnedRadians * kDegrees, 2.9, 0.12) << i;
        const double error =
            degreesBetween(shots.truth[i].rotation, turned[i].scannerFromGiven.rotation * fits[i].givenFromFound);
        EXPECT_LT(error, 0.1) << i << ": spacing is 0.25 degrees";
        EXPECT_LT(error, 4 * fits[i].deviationRadians * kDegrees) << i;
        EXPECT_LT(fits[i].deviationRadians * kDegrees, 0.1) << i;
        EXPECT_GT(fits[i].neighbours, 0) << i << ": they overlap";
    }
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    const std::vector<ColourFit> single = layOnScan(shots.scan, turned);
    for (std::size_t i = 0; i < fits.size(); ++i)
        EXPECT_EQ(single[i].givenFromFound, fits[i].givenFromFound) << "one thread and many";
}

TEST(ColourToRange, PosesThatAreRightStayRight) {
    Shots& shots = Shots::all();
    for (const ColourFit& fit : layOnScan(shots.scan, shots.turnedBy(0))) {
        EXPECT_TRUE(fit.isSure) << fit.why;
        EXPECT_LT(fit.turnedRadians, 4 * fit.deviationRadians);
    }
}

TEST(ColourToRange, RefusesWhatItCannotTellFromChance) {
    Shots& shots = Shots::all();
    // Taken beside another scan; together they agree with each other, and are not to be believed for that.
    for (const ColourFit& fit : layOnScan(shots.elsewhere, shots.turnedBy(1))) {
        EXPECT_FALSE(fit.isSure);
        EXPECT_FALSE(fit.why.empty());
    }
    // Beyond reach: found nearby where the search climbs so far, and told, or refused; never wrong.
    const std::vector<PhotographForScan> far = shots.turnedBy(8);
    const std::vector<ColourFit> fits = layOnScan(shots.scan, far);
    for (std::size_t i = 0; i < fits.size(); ++i)
        EXPECT_FALSE(fits[i].isSure);
    // Of a wall without anything on it.
    std::vector<PhotographForScan> blank = shots.turnedBy(1);
    SeededSequence chance(3);
    for (PhotographForScan& photograph : blank)
        for (Rgb8& pixel : photograph.straight.colour.pixels()) {
            const auto grey = static_cast<std::uint8_t>(128 + 2 * chance.normal());
            pixel = {grey, grey, grey};
        }
    for (const ColourFit& fit : layOnScan(shots.scan, blank))
        EXPECT_FALSE(fit.isSure);
}

TEST(ColourToRange, OneThatItsScanCannotPlaceIsPlacedByItsNeighboursOrTold) {
    Shots& shots = Shots::all();
    std::vector<PhotographForScan> turned = shots.turnedBy(1);
    // The middle one is beyond reach of what the scan was searched through; its neighbours do not help it there.
    turned[1].scannerFromGiven.rotation = shots.truth[1].rotation * turnBy(9, {0, 1, 0});
    const std::vector<ColourFit> fits = layOnScan(shots.scan, turned);
    EXPECT_TRUE(fits[0].isSure) << fits[0].why;
    EXPECT_FALSE(fits[1].isSure);
    EXPECT_TRUE(fits[2].isSure) << fits[2].why;
}

} // namespace
} // namespace scene
