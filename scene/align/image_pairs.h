#pragma once
// What two photographs with range say of how they stand to each other: the least-squares sums of all samples of one
// that the other saw, too.

#include "scene/align/image_sketch.h"
#include "scene/sample_comparison.h"

#include <array>
#include <cstdint>

#include <Eigen/Core>

namespace scene {

/// Residuals of both kinds count less from about here on.
struct ResidualScales {
    double range = 0.01, grey = 0.3;
};

/// Counts of sizes in steps of a two-hundredth of a power of ten: their median without keeping them, the same in any
/// order.
class SizeCounts {
  public:
    void add(double size);
    void add(const SizeCounts& other);
    std::int64_t count() const { return count_; }
    /// Within 0.6 %; 0 of none.
    double median() const;

  private:
    static constexpr int kPerDecade = 200, kDecades = 8;
    std::array<std::int32_t, kPerDecade * kDecades> counts_{};
    std::int64_t count_ = 0;
};

/// Of one pair: A's motion against B's, translation (metres) and then turn (radians) about the pivot, in the world.
struct ImagePairSums {
    Eigen::Matrix<double, 6, 6> square = Eigen::Matrix<double, 6, 6>::Zero(); ///< only the lower half is filled
    Eigen::Matrix<double, 6, 1> slope = Eigen::Matrix<double, 6, 1>::Zero();
    int agreeing = 0; ///< samples on the same surface
    int against = 0;  ///< samples that b saw through
};

struct ResidualSizes {
    SizeCounts range, grey;
};

struct ImagePairOptions {
    std::size_t level = 0; ///< of the greys
    ComparisonOptions comparison;
    ResidualScales scales;
};

/// Each step-th sample each way that is a surface.
SampleComparison samplesOf(const ImageSketch& sketch, int step);

/// samples: a's, in b, each where its pose has it. Adds the sizes of residuals to those given.
ImagePairSums comparePair(const ImageSketch& a, SampleComparison& samples, const Pose& worldFromA, const ImageSketch& b,
                          const Pose& worldFromB, const glm::dvec3& pivotInWorld, const ImagePairOptions& options,
                          ResidualSizes& sizes);

} // namespace scene
