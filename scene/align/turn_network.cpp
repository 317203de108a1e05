#include "scene/align/turn_network.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include <Eigen/Dense>

namespace scene {

namespace {

constexpr double kContradicts = 25; ///< squared deviations, of three axes together
constexpr double kAboutAsBad = 0.9;
constexpr int kLeastNeighbours = 2; ///< that must say where one stands that its scan could not place
/// What nothing checks has no residual and no deviation of it; this share of its own keeps one from dividing by it.
constexpr double kUnchecked = 1e-7;

Eigen::Index at(std::size_t photograph) {
    return static_cast<Eigen::Index>(3 * photograph);
}

double squares(const Turn& residual, const Eigen::Matrix3d& covariance) {
    return residual.dot(covariance.ldlt().solve(residual));
}

template <class T>
void eraseAt(std::vector<T>& list, std::size_t i) {
    list.erase(list.begin() + static_cast<std::ptrdiff_t>(i));
}

} // namespace

TurnNetwork::TurnNetwork(std::size_t count, std::vector<OwnTurn> own, std::vector<PairTurn> pairs,
                         std::vector<std::size_t> known)
    : contradicted(std::move(known)), count_(count), own_(std::move(own)), pairs_(std::move(pairs)) {}

void TurnNetwork::solve() {
    for (;;) {
        findAnchored();
        adjust();
        std::vector<double> own, pairs;
        for (const OwnTurn& turn : own_)
            own.push_back(squaresOf(turn));
        for (const PairTurn& turn : pairs_)
            pairs.push_back(squaresOf(turn));
        double worst = 0;
        for (const double found : own)
            worst = std::max(worst, found);
        for (const double found : pairs)
            worst = std::max(worst, found);
        if (worst <= kContradicts) return findBelieved();
        // Those that are about as bad cannot be told apart: nobody knows which of them is wrong. But what a scan says
        // unsurely is it before what it says surely, or two photographs of each other.
        const double bad = kAboutAsBad * worst;
        bool isUnsure = false;
        for (std::size_t i = 0; i < own_.size(); ++i)
            isUnsure |= own[i] >= bad && !own_[i].isSure;
        for (std::size_t i = own_.size(); i-- > 0;)
            if (own[i] >= bad && (!isUnsure || !own_[i].isSure)) {
                contradicted.push_back(own_[i].photograph);
                eraseAt(own_, i);
            }
        for (std::size_t i = pairs_.size(); i-- > 0;)
            if (pairs[i] >= bad && !isUnsure) eraseAt(pairs_, i);
    }
}

int TurnNetwork::neighboursOf(std::size_t photograph) const {
    return static_cast<int>(std::count_if(pairs_.begin(), pairs_.end(), [&](const PairTurn& pair) {
        return pair.a == photograph || pair.b == photograph;
    }));
}

int TurnNetwork::joinedTo(std::size_t photograph) const {
    return static_cast<int>(std::count(group_.begin(), group_.end(), group_[photograph]));
}

int TurnNetwork::anchorsOf(std::size_t photograph) const {
    return static_cast<int>(std::count_if(
        own_.begin(), own_.end(), [&](const OwnTurn& own) { return group_[own.photograph] == group_[photograph]; }));
}

bool TurnNetwork::isDisputed(std::size_t photograph) const {
    return anchorsOf(photograph) < 2 && std::any_of(contradicted.begin(), contradicted.end(), [&](std::size_t other) {
               return group_[other] == group_[photograph];
           });
}

void TurnNetwork::findAnchored() {
    group_.resize(count_);
    for (std::size_t i = 0; i < count_; ++i)
        group_[i] = i;
    for (bool isChanged = true; isChanged;) {
        isChanged = false;
        for (const PairTurn& pair : pairs_) {
            const std::size_t least = std::min(group_[pair.a], group_[pair.b]);
            isChanged |= group_[pair.a] != least || group_[pair.b] != least;
            group_[pair.a] = group_[pair.b] = least;
        }
    }
    isAnchored.assign(count_, false);
    for (const OwnTurn& own : own_)
        for (std::size_t i = 0; i < count_; ++i)
            if (group_[i] == group_[own.photograph]) isAnchored[i] = true;
}

void TurnNetwork::findBelieved() {
    isBelieved.assign(count_, false);
    for (const OwnTurn& own : own_)
        isBelieved[own.photograph] = true;
    for (bool isChanged = true; isChanged;) {
        isChanged = false;
        for (std::size_t i = 0; i < count_; ++i) {
            if (isBelieved[i]) continue;
            int votes = 0;
            for (const PairTurn& pair : pairs_) {
                if (!pair.isWhole || (pair.a != i && pair.b != i)) continue;
                if (isBelieved[pair.a == i ? pair.b : pair.a]) votes += pair.isPlain ? kLeastNeighbours : 1;
            }
            isBelieved[i] = votes >= kLeastNeighbours;
            isChanged |= isBelieved[i];
        }
    }
}

/// A further turn r of camera i: found * r. To first order a pair says that its turn is bFromA r_a - r_b.
void TurnNetwork::adjust() {
    const auto size = static_cast<Eigen::Index>(3 * count_);
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(size, size);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(size);
    for (const OwnTurn& own : own_)
        normal.block<3, 3>(at(own.photograph), at(own.photograph)) += own.covariance.inverse();
    for (const PairTurn& pair : pairs_) {
        if (!isAnchored[pair.a]) continue;
        const Eigen::Matrix3d weight = pair.covariance.inverse(), toA = pair.bFromA.transpose() * weight;
        normal.block<3, 3>(at(pair.a), at(pair.a)) += toA * pair.bFromA;
        normal.block<3, 3>(at(pair.b), at(pair.b)) += weight;
        normal.block<3, 3>(at(pair.a), at(pair.b)) -= toA;
        normal.block<3, 3>(at(pair.b), at(pair.a)) -= toA.transpose();
        right.segment<3>(at(pair.a)) += toA * pair.turn;
        right.segment<3>(at(pair.b)) -= weight * pair.turn;
    }
    for (std::size_t i = 0; i < count_; ++i)
        if (!isAnchored[i]) normal.block<3, 3>(at(i), at(i)) = Eigen::Matrix3d::Identity();
    const Eigen::LDLT<Eigen::MatrixXd> solver(normal);
    const Eigen::VectorXd solution = solver.solve(right);
    inverse_ = solver.solve(Eigen::MatrixXd::Identity(size, size));
    turns.clear();
    covariances.clear();
    for (std::size_t i = 0; i < count_; ++i) {
        turns.emplace_back(solution.segment<3>(at(i)));
        covariances.push_back(block(i, i));
    }
}

double TurnNetwork::squaresOf(const OwnTurn& own) const {
    const std::size_t i = own.photograph;
    return squares(turns[i], (1 + kUnchecked) * own.covariance - covariances[i]);
}

double TurnNetwork::squaresOf(const PairTurn& pair) const {
    if (!isAnchored[pair.a]) return 0;
    const Turn residual = pair.turn - (pair.bFromA * turns[pair.a] - turns[pair.b]);
    const Eigen::Matrix3d both = pair.bFromA * block(pair.a, pair.b);
    const Eigen::Matrix3d known =
        pair.bFromA * covariances[pair.a] * pair.bFromA.transpose() + covariances[pair.b] - both - both.transpose();
    return squares(residual, (1 + kUnchecked) * pair.covariance - known);
}

Eigen::Matrix3d TurnNetwork::block(std::size_t i, std::size_t j) const {
    return inverse_.block<3, 3>(at(i), at(j));
}

} // namespace scene
