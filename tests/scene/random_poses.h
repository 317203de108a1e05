#pragma once
// Poses and cameras drawn at random, from a seed that each test states.

#include "scene/camera.h"
#include "scene/pose.h"
#include "scene/synthetic_random.h"

#include <cstdint>

#include <glm/vec3.hpp>

/// Where national grids put a scan: no coordinate is small.
inline constexpr glm::dvec3 kFarFromOrigin{1.0e7, -0.7e7, 0.4e7};

class RandomPlaces {
  public:
    explicit RandomPlaces(unsigned seed) : random_(seed) {}

    double between(double low, double high) { return random_.between(low, high); }
    int integerBetween(int low, int high) {
        return low + static_cast<int>(random_.bits() % static_cast<std::uint64_t>(std::int64_t{high} - low + 1));
    }
    glm::dvec3 point(double extent) {
        const double x = between(-extent, extent), y = between(-extent, extent), z = between(-extent, extent);
        return {x, y, z};
    }
    /// Any rotation, all equally likely; a translation within extent along each axis of about.
    scene::Pose pose(double extent, const glm::dvec3& about = glm::dvec3(0.0)) {
        const double x = random_.normal(), y = random_.normal(), z = random_.normal(), w = random_.normal();
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
    scene::SeededSequence random_;
};
