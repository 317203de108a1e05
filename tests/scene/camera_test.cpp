#include "scene/camera.h"

#include "tests/scene/random_poses.h"

#include <cmath>
#include <limits>

#include <glm/geometric.hpp>
#include <glm/vec4.hpp>
#include <gtest/gtest.h>

namespace scene {
namespace {

constexpr int kCameraTrials = 2000;

TEST(Camera, ProjectsTheRayOfAPixelOntoThePixel) {
    RandomPlaces random(1);
    for (int trial = 0; trial < kCameraTrials; ++trial) {
        const Camera camera = random.camera();
        const glm::dvec2 place{random.between(0, camera.width), random.between(0, camera.height)};
        const double depth = std::exp(random.between(std::log(1e-4), std::log(1e5)));
        const glm::dvec2 back = project(camera, depth * rayThrough(camera, place.x, place.y));
        EXPECT_LT(glm::length(back - place), 1e-10);
    }
}

TEST(Camera, MatricesSayTheSameAsTheFormulas) {
    RandomPlaces random(2);
    for (int trial = 0; trial < kCameraTrials; ++trial) {
        const Camera camera = random.camera();
        const glm::dvec3 ray = rayThrough(camera, random.between(0, camera.width), random.between(0, camera.height));
        const double depth = std::exp(random.between(std::log(1e-4), std::log(1e5)));
        const glm::dvec3 pInCamera = depth * ray;

        const glm::dvec4 h = imageFromCamera(camera) * glm::dvec4(pInCamera, 1.0);
        const glm::dvec2 place = project(camera, pInCamera);
        EXPECT_LT(glm::length(glm::dvec2(h) / h.z - place), 1e-10);
        EXPECT_DOUBLE_EQ(h.z, depth);
        EXPECT_DOUBLE_EQ(h.w / h.z, 1.0 / depth);

        const glm::dvec4 back = cameraFromImage(camera) * glm::dvec4(place, 1.0, 1.0 / depth);
        EXPECT_LT(glm::length(glm::dvec3(back) / back.w - pInCamera), 1e-11 * glm::length(pInCamera));
    }
}

TEST(Camera, DisparityZeroIsADirection) {
    const Camera camera{640, 480, 500, 510, 320, 240};
    const glm::dvec4 direction = cameraFromImage(camera) * glm::dvec4(100, 200, 1, 0);
    EXPECT_EQ(direction.w, 0.0);
    EXPECT_LT(glm::length(glm::dvec3(direction) - rayThrough(camera, 100, 200)), 1e-15);
}

TEST(Camera, CentreLooksStraightAheadAndAxesPointRightAndDown) {
    const Camera camera{640, 480, 500, 510, 320, 240};
    EXPECT_EQ(rayThrough(camera, 320, 240), glm::dvec3(0, 0, 1));
    EXPECT_GT(project(camera, {1, 0, 2}).x, 320);
    EXPECT_GT(project(camera, {0, 1, 2}).y, 240);
}

TEST(Camera, UsableOnlyWithSizesAndFiniteNumbers) {
    const Camera good{640, 480, 500, 510, 320, 240};
    EXPECT_TRUE(isUsable(good));
    EXPECT_FALSE(isUsable(Camera{}));
    for (int Camera::*size : {&Camera::width, &Camera::height})
        for (const int bad : {0, -1}) {
            Camera camera = good;
            camera.*size = bad;
            EXPECT_FALSE(isUsable(camera));
        }
    for (double Camera::*number : {&Camera::fx, &Camera::fy, &Camera::cx, &Camera::cy})
        for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
            Camera camera = good;
            camera.*number = bad;
            EXPECT_FALSE(isUsable(camera));
        }
    for (double Camera::*focal : {&Camera::fx, &Camera::fy})
        for (const double bad : {0.0, -500.0}) {
            Camera camera = good;
            camera.*focal = bad;
            EXPECT_FALSE(isUsable(camera));
        }
}

} // namespace
} // namespace scene
