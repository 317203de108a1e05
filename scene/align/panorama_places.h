#pragma once
// Where many points are seen in a panorama, by vectors: registration asks that for every pose that it tries.

#include "scene/pose.h"

#include <array>
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

namespace scene {

/// The arc tangent of t in [0, 1] is t (1 + (...((k7 t^2 + k6) t^2 + ...) + k0) t^2) to 2e-8 radians: 4.4.49 of
/// Abramowitz and Stegun, "Handbook of mathematical functions", 1964.
inline constexpr std::array kArcTangent{-0.3333314528, 0.1999355085, -0.1420889944, 0.1065626393,
                                        -0.0752896400, 0.0429096138, -0.0161657367, 0.0028662257};

/// Points are added, found in a panorama, and then asked about by the order in which they were added. What is said is
/// what Pose and Panorama::placeOf say of each, to the bit, on every processor.
class PanoramaPlaces {
  public:
    void clear() { count_ = 0; }
    int count() const { return static_cast<int>(count_); }
    /// Metres, in any frame.
    void add(const glm::vec3& point);

    /// May be called again with another panorama, of so many rows.
    void find(const Pose& panoramaFromPoints, int rows);

    /// In the panorama's frame.
    glm::dvec3 point(int i) const { return {x_[at(i)], y_[at(i)], z_[at(i)]}; }
    /// Index into the panorama's pixels; negative for the origin and what is no number.
    int cell(int i) const { return cells_[at(i)]; }

  private:
    static std::size_t at(int i) { return static_cast<std::size_t>(i); }

    std::size_t count_ = 0;
    std::vector<float> givenX_, givenY_, givenZ_; ///< of padded length, as all the others
    std::vector<double> x_, y_, z_;
    std::vector<std::int32_t> cells_;
};

} // namespace scene
