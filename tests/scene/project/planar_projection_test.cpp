// Scattered samples projected into a camera, against the ray-traced truth: planes are planes, and nothing hangs in the
// air at silhouettes.

#include "scene/project/planar_projection.h"

#include "scene/capture/simulated_scan.h"
#include "scene/project/dropouts.h"
#include "scene/synthetic_tracer.h"

#include <algorithm>
#include <cmath>
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

/// What share of a sample's solid angle a pixel takes up: a quarter in the middle, less towards the rim.
double samplesOf(int x, int y) {
    const glm::dvec3 ray = rayThrough(kCamera, x + 0.5, y + 0.5);
    return 0.25 * std::pow(glm::dot(ray, ray), -1.5);
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

/// The largest piece of neighbouring pixels that no surface is near to, in samples of the scan, over the whole horizon.
double largestFloating(const ScanOf& at, const PlanarOptions& options) {
    double largest = 0;
    for (const double azimuth : {0.0, 2.1, 4.2}) {
        const Pose scannerFromCamera = lookingTo(azimuth);
        DepthImage image = projectToCamera(at.scan, at.traits, inverse(scannerFromCamera), kCamera, options);
        fillDropouts(image);
        Image<std::uint8_t> floats(kCamera.width, kCamera.height, std::uint8_t{0});
        for (int y = 0; y < kCamera.height; ++y)
            for (int x = 0; x < kCamera.width; ++x)
                floats(x, y) =
                    isSurface(image.flags(x, y)) && !isTrue(at, scannerFromCamera, x, y, image.disparity(x, y));
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
    }
    return largest;
}

TEST(PlanarProjection, NoFalseSurfaceOfMoreThanThreeSamplesFloatsAtSilhouettes) {
    EXPECT_LE(largestFloating(ScanOf::room(), {}), 3);
    // The same without clusters: the mean of all that touch a pixel.
    PlanarOptions blurred;
    blurred.sameSurface = 1e6;
    EXPECT_GT(largestFloating(ScanOf::room(), blurred), 30) << "the test must see what it looks for";
}

// Leaves and rails thinner than the scan's spacing, edges whose sides are hardly apart: from every tripod.
TEST(PlanarProjection, NorAmongLeavesAndRails) {
    const SyntheticScene corner = makeStreetCorner();
    for (const SyntheticScene* place : {&theRoom(), &corner})
        for (const Pose& tripod : scanPositions(*place))
            EXPECT_LE(largestFloating(ScanOf(*place, tripod), {}), 3) << "from x " << tripod.translation.x;
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
