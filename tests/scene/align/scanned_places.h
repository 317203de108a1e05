#pragma once
// Bare places to scan, and scans of them from poses that nobody wrote down.

#include "scene/align/register_pair.h"
#include "scene/capture/simulated_scan.h"
#include "scene/synthetic.h"
#include "scene/synthetic_model.h"
#include "scene/synthetic_random.h"

#include <cmath>
#include <string>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scene {

/// A place of boxes, lit as little as may be: a scanner brings its own light.
class BoxPlace {
  public:
    BoxPlace() {
        model_.name = "boxes";
        model_.lightSpacing = 20;
        material_ = addMaterial(model_, {});
    }
    BoxPlace& add(const glm::dvec3& low, const glm::dvec3& high) {
        addBox(model_, {}, low, high, material_);
        return *this;
    }
    /// Walls, floor and ceiling about an empty box.
    BoxPlace& addHall(const glm::dvec3& low, const glm::dvec3& high) {
        const glm::dvec3 l = low - 1.0, h = high + 1.0;
        add(l, {h.x, h.y, low.z}).add({l.x, l.y, high.z}, h);
        add({l.x, l.y, low.z}, {low.x, h.y, high.z}).add({high.x, l.y, low.z}, {h.x, h.y, high.z});
        return add({low.x, l.y, low.z}, {high.x, low.y, high.z}).add({low.x, high.y, low.z}, {high.x, h.y, high.z});
    }
    SyntheticScene build() { return SyntheticScene(std::move(model_)); }

  private:
    SyntheticModel model_;
    int material_ = 0;
};

/// A furnished office of 6 x 5 x 2.7 m.
inline SyntheticScene office() {
    BoxPlace place;
    place.addHall({0, 0, 0}, {6, 5, 2.7});
    place.add({0, 1.2, 0}, {0.4, 2.8, 2.1}).add({2.2, 0, 0}, {3.7, 0.8, 0.75}).add({4.6, 3.9, 0}, {6, 5, 0.45});
    place.add({3.1, 4.7, 0.9}, {4.2, 5, 1.8}).add({5.6, 1, 0}, {6, 1.9, 1.2}).add({1.0, 4.4, 0}, {1.6, 5, 1.1});
    return place.build();
}

/// Turned any way, tilted as a tripod set up by eye.
inline Pose setUpAt(const glm::dvec3& position, std::uint64_t seed) {
    SeededSequence chance(seed);
    Pose pose =
        poseFromQuaternion({}, 0.01 * chance.normal(), 0.01 * chance.normal(), chance.normal(), chance.normal());
    pose.translation = position;
    return pose;
}

inline Scan scanFrom(const SyntheticScene& place, const Pose& worldFromScanner, std::uint32_t seed,
                     double farthestMetres = 30) {
    ScannerOptions options;
    options.seed = seed;
    options.farthestMetres = farthestMetres;
    options.apertureRays = 3;
    setDensity(options, 2.2);
    Scan scan = readRawScan(simulateRawScan(worldOf(place, false), worldFromScanner, options), options.constants).scan;
    scan.name = "scan" + std::to_string(seed);
    return scan;
}

inline double degreesBetween(const Pose& a, const Pose& b) {
    const glm::dmat3 r = glm::transpose(a.rotation) * b.rotation;
    const glm::dvec3 twist(r[1][2] - r[2][1], r[2][0] - r[0][2], r[0][1] - r[1][0]);
    return std::atan2(glm::length(twist), r[0][0] + r[1][1] + r[2][2] - 1) * 57.29577951308232;
}

inline double metresBetween(const Pose& a, const Pose& b) {
    return glm::distance(a.translation, b.translation);
}

} // namespace scene
