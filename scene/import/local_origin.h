#pragma once
// Points that carry a national grid's offsets inside, and an origin near them that single precision can bear.

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

namespace scene {

/// Ranges beyond this lose sub-millimetre accuracy in single precision (half a step at 10 km is 0.5 mm; we
/// stay below).
inline constexpr double kFarMetres = 1000.0;

/// A place amid the points if they stand so far from their origin that it cannot be the scanner: farther than
/// kFarMetres and than four times their own extent. Whole metres, so that shifting by it is exact. Judged by
/// medians: a few outliers, such as 0 0 0 for no return, do not matter. Nothing for points that belong where
/// they are, and for no points.
std::optional<glm::dvec3> localOrigin(std::span<const glm::dvec3> points);

/// Points in single precision about their local origin, of which the first stand for all: memory stays bounded.
class PointsAboutOrigin {
  public:
    /// points must outlive it, and is complete once finish was called.
    explicit PointsAboutOrigin(std::vector<glm::vec3>& points) : points_(points) {}

    void add(const glm::dvec3& p);
    /// The origin, if they need one.
    std::optional<glm::dvec3> finish();

  private:
    static constexpr std::size_t kDeciding = 1 << 16;

    void decide();

    std::vector<glm::vec3>& points_;
    bool isDecided_ = false;
    std::optional<glm::dvec3> origin_;
    glm::dvec3 shift_{0.0};
    std::vector<glm::dvec3> waiting_;
};

} // namespace scene
