#pragma once
// The turn of a camera at which its edges lie best on those of a picture: all turns within reach, the best of them
// climbing from broad edges to sharp ones; how much better the best is than the others; and how exactly it is known.

#include "scene/align/edge_score.h"

#include <array>
#include <functional>
#include <numbers>
#include <optional>
#include <vector>

#include <Eigen/Core>

namespace scene {

inline constexpr double kDegree = std::numbers::pi / 180; ///< in radians

/// A rotation by its axis and angle, radians, about the camera's axes: x and y look elsewhere, z rolls.
using Turn = Eigen::Vector3d;

glm::dmat3 matrixOf(const Turn& turn);
Turn turnOf(const glm::dmat3& rotation);
Eigen::Matrix3d eigenOf(const glm::dmat3& matrix);

/// What a search found. Radians; scores in standard deviations of the picture's edges, summed over the levels.
struct TurnFound {
    Turn turn = Turn::Zero();
    double score = 0;
    double rivalShare = 1; ///< the best other turn's score over that
    double agreeing = 0;   ///< share of the parts that like the turn better than others about it
    int parts = 0;         ///< that have edges
    /// Of the turn; nothing where the score has no top.
    std::optional<Eigen::Matrix3d> covariance;
    std::vector<Turn> tops; ///< that were climbed to, the best first; of find alone
};

using PartRays = std::array<std::vector<EdgeRay>, kParts>;

class TurnSearch {
  public:
    /// Lends the levels, broadest first, pictures of scanCamera. The last two say where exactly.
    TurnSearch(const std::vector<EdgeLevel>& levels, const Camera& scanCamera, PartRays rays);

    TurnFound find(double reachRadians) const;

    /// The nearest top, for turns that are known to about the width of the broadest level; rivals are not looked for.
    TurnFound climbFrom(const Turn& turn) const;

  private:
    struct Candidate {
        Turn turn = Turn::Zero();
        double score = 0;
    };
    using Score = std::function<double(const Turn&)>;

    static bool isBetter(const Candidate& a, const Candidate& b);
    static Candidate climb(const Score& score, Candidate from, double step, double leastStep);
    static std::vector<Candidate> apart(std::vector<Candidate> list, double distance, std::size_t most);

    double sigmaOf(std::size_t level) const { return levels_[level].sigmaPixels * pixelRadians_; }
    std::size_t firstFine() const { return levels_.size() > 1 ? levels_.size() - 2 : 0; }
    bool hasSay(std::size_t part) const;
    std::vector<Candidate> grid(double reachRadians) const;
    void climbAll(std::vector<Candidate>& climbers, std::size_t end, const std::vector<EdgeRay>& rays,
                  double step) const;
    void sharpen(TurnFound& found) const;
    std::optional<Eigen::Matrix3d> covarianceAt(const Turn& found) const;
    void askParts(TurnFound& found) const;

    const std::vector<EdgeLevel>& levels_;
    EdgeScore edgeScore_;
    double pixelRadians_;
    PartRays partRays_;
    std::vector<EdgeRay> rays_, fewRays_;
};

} // namespace scene
