// Scattered samples projected into a camera, against the ray-traced truth: planes are planes, and nothing hangs in the
// air at silhouettes.

#include "scene/project/planar_projection.h"

#include "scene/capture/simulated_scan.h"
#include "scene/project/dropouts.h"
#include "scene/synthetic_tracer.h"
#include "tests/repetitions.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <span>
#include <vector>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace scene {
namespace {

constexpr double kDensity = 3;        ///< samples a degree
constexpr double kSameSurface = 0.02; ///< relative: what the build takes for one surface

const SyntheticScene& theRoom() {
    static const SyntheticScene made = makeRoom();
    return made;
}

/// A scan of a place by the simulated scanner, its beam as wide as it is and swept as it is.
struct ScanOf {
    const SyntheticScene& place;
    Pose worldFromScanner;
    Scan scan;
    ScanTraits traits;

    ScanOf(const SyntheticScene& of, const Pose& tripod) : place(of), worldFromScanner(tripod) {
        ScannerOptions options;
        options.noiseMetres = 0.002;
        setDensity(options, kDensity);
        const ScannedWorld world = worldOf(place, false);
        scan = readRawScan(simulateRawScan(world, worldFromScanner, options), options.constants).scan;
        traits = traitsOf(scan);
    }
    static const ScanOf& room() {
        static const ScanOf made(theRoom(), scanPositions(theRoom()).front());
        return made;
    }
};

/// Looks level, x right, y down.
Pose lookingTo(double azimuth) {
    const glm::dvec3 forward(std::cos(azimuth), std::sin(azimuth), 0), right(std::sin(azimuth), -std::cos(azimuth), 0);
    return {glm::dmat3(right, glm::dvec3(0, 0, -1), forward), glm::dvec3(0)};
}

/// Pixels half of the scan's spacing wide.
const Camera kCamera{400, 300, 2 * kDensity * 57.3, 2 * kDensity * 57.3, 200, 150};

/// What share of a sample's solid angle a pixel takes up: a quarter in the middle, less towards the rim. Samples are as
/// wide as high in angles, so that towards the zenith they take up less as well.
double samplesOf(int x, int y) {
    const glm::dvec3 ray = rayThrough(kCamera, x + 0.5, y + 0.5);
    return 0.25 * std::pow(glm::dot(ray, ray), -1.5) * glm::length(ray) / std::hypot(ray.x, ray.z);
}

/// Whether any surface stands at the pixel's range within so many pixels about it.
bool isTrue(const ScanOf& at, const Pose& scannerFromCamera, int x, int y, double disparity) {
    const Pose worldFromCamera = at.worldFromScanner * scannerFromCamera;
    const auto isThere = [&](int i, int j) {
        const glm::dvec3 ray = rayThrough(kCamera, x + 0.5 + 0.75 * i, y + 0.5 + 0.75 * j);
        const auto hit = at.place.tracer().cast(worldFromCamera.translation, worldFromCamera.rotation * ray);
        return hit && std::abs(hit->t * disparity - 1) < kSameSurface;
    };
    if (isThere(0, 0)) return true;
    for (int j = -4; j <= 4; ++j)
        for (int i = -4; i <= 4; ++i)
            if (isThere(i, j)) return true;
    return false;
}

struct Outcome {
    double largestFloating = 0; ///< piece of neighbouring pixels that no surface is near to, in samples of the scan
    double rightShare = 0;      ///< of the pixels with a surface in their middle: those that show it
};

Image<std::uint8_t> floatingIn(const ScanOf& at, const Pose& scannerFromCamera, const DepthImage& image) {
    Image<std::uint8_t> floats(kCamera.width, kCamera.height, std::uint8_t{0});
    for (int y = 0; y < kCamera.height; ++y)
        for (int x = 0; x < kCamera.width; ++x)
            floats(x, y) = isSurface(image.flags(x, y)) && !isTrue(at, scannerFromCamera, x, y, image.disparity(x, y));
    return floats;
}

double largestPieceOf(Image<std::uint8_t> floats) {
    double largest = 0;
    for (int y = 0; y < kCamera.height; ++y)
        for (int x = 0; x < kCamera.width; ++x) {
            if (!floats(x, y)) continue;
            double size = 0;
            std::vector<std::pair<int, int>> open{{x, y}};
            floats(x, y) = 0;
            while (!open.empty()) {
                const auto [u, v] = open.back();
                open.pop_back();
                size += samplesOf(u, v);
                for (int j = std::max(v - 1, 0); j <= std::min(v + 1, kCamera.height - 1); ++j)
                    for (int i = std::max(u - 1, 0); i <= std::min(u + 1, kCamera.width - 1); ++i)
                        if (floats(i, j)) floats(i, j) = 0, open.emplace_back(i, j);
            }
            largest = std::max(largest, size);
        }
    return largest;
}

/// Once about the horizon.
Outcome outcomeOf(const ScanOf& at, const PlanarOptions& options) {
    Outcome outcome;
    std::int64_t there = 0, right = 0;
    for (int i = 0; i < 6; ++i) {
        const Pose scannerFromCamera = lookingTo(i * std::numbers::pi / 3),
                   worldFromCamera = at.worldFromScanner * scannerFromCamera;
        DepthImage image = projectToCamera(at.scan, at.traits, inverse(scannerFromCamera), kCamera, options);
        fillDropouts(image);
        outcome.largestFloating =
            std::max(outcome.largestFloating, largestPieceOf(floatingIn(at, scannerFromCamera, image)));
        for (int y = 0; y < kCamera.height; ++y)
            for (int x = 0; x < kCamera.width; ++x) {
                const glm::dvec3 ray = rayThrough(kCamera, x + 0.5, y + 0.5);
                const auto hit = at.place.tracer().cast(worldFromCamera.translation, worldFromCamera.rotation * ray);
                if (!hit) continue;
                ++there;
                right += isSurface(image.flags(x, y)) && std::abs(hit->t * image.disparity(x, y) - 1) < kSameSurface;
            }
    }
    outcome.rightShare = static_cast<double>(right) / static_cast<double>(there);
    return outcome;
}

TEST(PlanarProjection, NoFalseSurfaceOfMoreThanThreeSamplesFloatsAtSilhouettes) {
    EXPECT_LE(outcomeOf(ScanOf::room(), {}).largestFloating, 3);
    // The same without clusters: the mean of all that touch a pixel.
    PlanarOptions blurred;
    blurred.sameSurface = 1e6;
    EXPECT_GT(outcomeOf(ScanOf::room(), blurred).largestFloating, 30) << "the test must see what it looks for";
}

// Leaves and rails thinner than the scan's spacing, edges whose sides are hardly apart: from every tripod. And what is
// there must still be there: much of the corner gives no echo, whatever is done with those that come back.
TEST(PlanarProjection, NorAmongLeavesAndRails) {
    const SyntheticScene corner = makeStreetCorner();
    for (const SyntheticScene* place : {&theRoom(), &corner}) {
        const std::vector<Pose> tripods = scanPositions(*place);
        for (const Pose& tripod : std::span(tripods).first(tests::areLong() ? tripods.size() : 1)) {
            const Outcome outcome = outcomeOf(ScanOf(*place, tripod), {});
            const char* name = place == &corner ? "corner" : "room";
            std::printf("%s from x %.1f, y %.1f: %.2f samples at most, %.1f %% right\n", name, tripod.translation.x,
                        tripod.translation.y, outcome.largestFloating, 100 * outcome.rightShare);
            EXPECT_LE(outcome.largestFloating, 3) << name << " from x " << tripod.translation.x;
            EXPECT_GE(outcome.rightShare, place == &corner ? 0.42 : 0.95);
        }
    }
}

TEST(PlanarProjection, MostOfThePictureHasRangeAndLiesOnTheSurface) {
    const ScanOf& at = ScanOf::room();
    const Pose scannerFromCamera = lookingTo(2.1);
    DepthImage image = projectToCamera(at.scan, at.traits, inverse(scannerFromCamera), kCamera);
    fillDropouts(image);
    std::vector<double> errors;
    int there = 0;
    const Pose worldFromCamera = at.worldFromScanner * scannerFromCamera;
    for (int y = 0; y < kCamera.height; ++y)
        for (int x = 0; x < kCamera.width; ++x) {
            const glm::dvec3 ray = rayThrough(kCamera, x + 0.5, y + 0.5);
            const auto hit = at.place.tracer().cast(worldFromCamera.translation, worldFromCamera.rotation * ray);
            if (!hit) continue;
            ++there;
            if (isSurface(image.flags(x, y))) errors.push_back(std::abs(hit->t - 1 / double{image.disparity(x, y)}));
        }
    EXPECT_GT(static_cast<double>(errors.size()), 0.97 * there);
    std::sort(errors.begin(), errors.end());
    EXPECT_LT(errors[errors.size() / 2], 0.002) << "the noise of a sample, less what the mean of several leaves";
    EXPECT_LT(errors[errors.size() * 9 / 10], 0.01);
}

TEST(PlanarProjection, IsTheSameOnAnyNumberOfThreads) {
    const ScanOf& at = ScanOf::room();
    const DepthImage many = projectToCamera(at.scan, at.traits, inverse(lookingTo(1)), kCamera);
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    const DepthImage single = projectToCamera(at.scan, at.traits, inverse(lookingTo(1)), kCamera);
    EXPECT_EQ(many.disparity, single.disparity);
    EXPECT_EQ(many.colour, single.colour);
    EXPECT_EQ(many.flags, single.flags);
}

TEST(PlanarProjection, NoiseIsFoundInTheScanItself) {
    const double found = rangeNoiseOf(ScanOf::room().scan);
    EXPECT_GT(found, 0.001);
    EXPECT_LT(found, 0.004);
    EXPECT_EQ(rangeNoiseOf(Scan{}), 0);
}

} // namespace
} // namespace scene
