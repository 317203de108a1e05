#pragma once
// The turns of photographs from one place, by least squares: each as its scan has it, if it has, and neighbours as they
// stand to each other. What contradicts the rest is taken away.

#include "scene/align/turn_search.h"

#include <vector>

#include <Eigen/Core>

namespace scene {

/// What the scan says of a photograph itself: its turn from where it was found is zero, so exactly.
struct OwnTurn {
    std::size_t photograph = 0;
    Eigen::Matrix3d covariance;
    bool isSure = false; ///< by itself
};

/// How photograph a stands to b: matrixOf(turn) * bFromA is right, turn about b's axes. Radians.
struct PairTurn {
    std::size_t a = 0, b = 0;
    Eigen::Matrix3d bFromA; ///< as it was when they were compared
    Turn turn = Turn::Zero();
    Eigen::Matrix3d covariance;
    bool isPlain = false; ///< so sure that it needs no other to agree
    bool isWhole = true;  ///< known about all axes
};

class TurnNetwork {
  public:
    /// contradicted: photographs whose own turn is known to be wrong, and not among those given.
    TurnNetwork(std::size_t count, std::vector<OwnTurn> own, std::vector<PairTurn> pairs,
                std::vector<std::size_t> contradicted = {});

    /// Takes away what contradicts the rest most, until nothing does; then holds the turns of all that are joined to an
    /// own one. Baarda, "A testing procedure for use in geodetic networks", 1968: a residual counts by what it would be
    /// if all were right, so that what few others check is asked as strictly as what many do.
    void solve();

    const std::vector<PairTurn>& pairs() const { return pairs_; } ///< that are left
    int neighboursOf(std::size_t photograph) const;
    int joinedTo(std::size_t photograph) const;  ///< by pairs, one after another; itself, too
    int anchorsOf(std::size_t photograph) const; ///< of these, that have an own turn
    /// Of two that contradict each other nobody knows which is wrong.
    bool isDisputed(std::size_t photograph) const;

    std::vector<Turn> turns; ///< further turns, about each camera's axes
    std::vector<Eigen::Matrix3d> covariances;
    std::vector<bool> isAnchored; ///< joined to an own turn
    /// Those with an own turn, those with a plain pair to one that is believed, and those with two pairs to such,
    /// all of these known about all axes.
    std::vector<bool> isBelieved;
    std::vector<std::size_t> contradicted; ///< photographs whose own turn was taken away

  private:
    void findAnchored();
    void findBelieved();
    void adjust();
    double squaresOf(const OwnTurn& own) const;
    double squaresOf(const PairTurn& pair) const;
    Eigen::Matrix3d block(std::size_t i, std::size_t j) const;

    std::size_t count_;
    std::vector<OwnTurn> own_;
    std::vector<PairTurn> pairs_;
    std::vector<std::size_t> group_;
    Eigen::MatrixXd inverse_; ///< of the normal equations: covariances of all turns
};

} // namespace scene
