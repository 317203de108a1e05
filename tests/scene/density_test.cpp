#include "scene/density.h"

#include "tests/scene/known_scenes.h"
#include "tests/scene/random_poses.h"

#include <cmath>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

namespace scene {
namespace {

/// One over the area of the plane that a pixel covers, from the pixel's four sides.
double densityOfPlane(const Camera& camera, const glm::dvec3& normal, double offset, double x, double y) {
    const auto point = [&](double px, double py) {
        return rayThrough(camera, px, py) / planeDisparity(camera, normal, offset, px, py);
    };
    constexpr double h = 1e-3;
    const glm::dvec3 alongX = (point(x + h, y) - point(x - h, y)) / (2 * h),
                     alongY = (point(x, y + h) - point(x, y - h)) / (2 * h);
    return 1 / glm::length(glm::cross(alongX, alongY));
}

TEST(Density, IsThatOfThePlane) {
    RandomPlaces random(1);
    const Camera camera{60, 50, 70, 45, 24, 31}; // denser along one axis, centre aside
    for (int i = 0; i < 30; ++i) {
        const glm::dvec3 normal = glm::normalize(glm::dvec3(random.between(-0.8, 0.8), random.between(-0.8, 0.8), 1));
        const double offset = random.between(0.5, 20);
        const auto disparity = [&](double x, double y) { return planeDisparity(camera, normal, offset, x, y); };
        if (std::min(std::min(disparity(0, 0), disparity(60, 0)), std::min(disparity(0, 50), disparity(60, 50))) <
            0.3 / offset)
            continue;
        const Image<float> density = computeDensity(imageOf(camera, {}, disparity));
        for (int y = 0; y < camera.height; ++y)
            for (int x = 0; x < camera.width; ++x) {
                const double truth = densityOfPlane(camera, normal, offset, x + 0.5, y + 0.5);
                ASSERT_NEAR(density(x, y), truth, 2e-3 * truth) << "plane " << i << " at " << x << ", " << y;
            }
    }
}

TEST(Density, IsEachSurfacesOwnBesideASilhouetteAndZeroWithoutSurface) {
    const Camera camera = smallCamera();
    DepthImage image = imageOf(camera, {}, [](double x, double) { return x < 80 ? 0.25 : 0.5; });
    for (int y = 20; y < 30; ++y)
        for (int x = 30; x < 50; ++x)
            image.flags(x, y) = y % 2 ? kNoSurface : kFloating;
    const Image<float> density = computeDensity(image);
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x) {
            const double d = x < 80 ? 0.25 : 0.5,
                         truth = isSurface(image.flags(x, y)) ? camera.fx * camera.fy * d * d : 0;
            ASSERT_NEAR(density(x, y), truth, 1e-4 * truth) << "at " << x << ", " << y;
        }
}

// Scanner noise of a few millimetres must not make a wall that is seen head-on look aslant.
TEST(Density, IsHardlyTiltedByNoise) {
    const Camera camera = smallCamera();
    RandomPlaces random(5);
    const DepthImage image =
        imageOf(camera, {}, [&](double, double) { return 0.5 * (1 + random.between(-0.002, 0.002)); });
    const Image<float> density = computeDensity(image);
    double sum = 0;
    for (const float value : density.pixels())
        sum += static_cast<double>(value) / static_cast<double>(density.size());
    const double truth = camera.fx * camera.fy * 0.25;
    EXPECT_NEAR(sum, truth, 0.02 * truth);
}

} // namespace
} // namespace scene
