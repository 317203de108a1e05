#pragma once
// Poses and cameras drawn at random, from a seed that each test states.

#include "scene/camera.h"
#include "scene/pose.h"

#include <random>

#include <glm/vec3.hpp>

/// Where national grids put a scan: no coordinate is small.
inline constexpr glm::dvec3 kFarFromOrigin{1.0e7, -0.7e7, 0.4e7};

class RandomPlaces {
  public:
    explicit RandomPlaces(unsigned seed) : generator_(seed) {}

    double between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(generator_); }
    int integerBetween(int low, int high) { return std::uniform_int_distribution<int>(low, high)(generator_); }
    glm::dvec3 point(double extent) {
        const double x = between(-extent, extent), y = between(-extent, extent), z = between(-extent, extent);
        return {x, y, z};
    }
    /// Any rotation, all equally likely; a translation within extent along each axis of about.
    scene::Pose pose(double extent, const glm::dvec3& about = glm::dvec3(0.0)) {
        std::normal_distribution<double> normal;
        const double x = normal(generator_), y = normal(generator_), z = normal(generator_), w = normal(generator_);
        return scene::poseFromQuaternion(about + point(extent), x, y, z, w);
    }
    /// Centres may lie well beside the middle, as those of an eye.
    scene::Camera camera() {
        scene::Camera camera;
        camera.width = integerBetween(1, 4096), camera.height = integerBetween(1, 4096);
        camera.fx = between(0.2, 3.0) * camera.width, camera.fy = between(0.2, 3.0) * camera.height;
        camera.cx = between(-0.5, 1.5) * camera.width, camera.cy = between(-0.5, 1.5) * camera.height;
        return camera;
    }

  private:
    std::mt19937 generator_;
};
