#pragma once
// How well the edges of a photograph lie on those of a scan when the photograph's camera is turned.

#include "scene/align/edge_pictures.h"
#include "scene/camera.h"

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include <glm/mat3x3.hpp>

namespace scene {

inline constexpr int kPartColumns = 4, kPartRows = 3; ///< of the picture, that are asked by themselves
inline constexpr int kParts = kPartColumns * kPartRows;

/// Which of count equal pieces of [from, to] holds v, or is nearest to it.
inline int pieceOf(double v, double from, double to, int count) {
    return std::clamp(static_cast<int>((v - from) / std::max(to - from, 1.0) * count), 0, count - 1);
}

/// An edge of the photograph as a direction of its camera (z = 1).
struct EdgeRay {
    glm::vec3 direction{0.0f};
    float strength = 0, cosine = 1, sine = 0; ///< see EdgePoint
};

/// Sums over the parts of the picture: score = sum of gains / sum of weights.
struct PartSums {
    std::array<double, kParts> gains{}, weights{};

    double score() const { return scoreWithout(-1); }
    double scoreWithout(int part) const;
};

class EdgeScore {
  public:
    /// Lends the levels, broadest first, pictures of scanCamera.
    EdgeScore(const std::vector<EdgeLevel>& levels, const Camera& scanCamera) : levels_(levels), camera_(scanCamera) {}

    /// The mean over the rays, weighed by strength, of what each level holds where the turned ray falls, by the angle
    /// between the two edges; summed over the levels [first, end). givenFromTurned turns the rays.
    double at(const glm::dmat3& givenFromTurned, std::span<const EdgeRay> rays, std::size_t first,
              std::size_t end) const;

    /// The same, part by part.
    PartSums partsAt(const glm::dmat3& givenFromTurned, const std::array<std::vector<EdgeRay>, kParts>& rays,
                     std::size_t first, std::size_t end) const;

  private:
    struct Sum {
        double gain = 0, weight = 0;
    };
    Sum sumAt(const glm::dmat3& givenFromTurned, std::span<const EdgeRay> rays, std::size_t first,
              std::size_t end) const;

    const std::vector<EdgeLevel>& levels_;
    Camera camera_;
};

} // namespace scene
