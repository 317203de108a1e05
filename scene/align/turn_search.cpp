#include "scene/align/turn_search.h"

#include "scene/pose.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Dense>
#include <tbb/parallel_for.h>

namespace scene {

namespace {

constexpr double kLeastStep = 0.002 * kDegree;
constexpr double kGridStep = 0.4 * kDegree; ///< between turns that are tried first
constexpr double kApart = 0.8 * kDegree;    ///< of these, such that climb by themselves
constexpr double kRollWeight = 0.5;         ///< a roll moves edges less than a turn to the side by so much
constexpr std::size_t kClimbers = 24, kSecondClimbers = 8;
constexpr double kSame = 0.3 * kDegree; ///< turns that are no rivals but the same one
constexpr std::size_t kFewRays = 1200;
constexpr int kLeastRaysOfPart = 25;
constexpr double kNeighbourhood = 1.5 * kDegree, kNeighbourStep = 0.15 * kDegree; ///< what a part compares with
constexpr double kPartReach = 0.1 * kDegree; ///< a part may have its best so far beside the turn
constexpr double kMostBetter = 0.1;          ///< a part likes a turn if less than this share about it is better

double distanceOf(const Turn& a, const Turn& b) {
    const Turn d = a - b;
    return std::hypot(std::hypot(d.x(), d.y()), kRollWeight * d.z());
}

/// Values of a function at ten places about a turn, and the quadratic through them.
struct Stencil {
    static constexpr int kCount = 10;
    static Turn place(int i, double step) {
        static constexpr int kPlaces[kCount][3] = {{0, 0, 0}, {1, 0, 0},  {-1, 0, 0}, {0, 1, 0}, {0, -1, 0},
                                                   {0, 0, 1}, {0, 0, -1}, {1, 1, 0},  {1, 0, 1}, {0, 1, 1}};
        return step * Turn(kPlaces[i][0], kPlaces[i][1], kPlaces[i][2] / kRollWeight);
    }

    /// From the middle to the top of the quadratic, in steps; nothing where it has none.
    static std::optional<Turn> top(const std::array<double, kCount>& f) {
        Turn slope;
        Eigen::Matrix3d bend;
        for (int axis = 0; axis < 3; ++axis) {
            const double plus = f[static_cast<std::size_t>(1 + 2 * axis)],
                         minus = f[static_cast<std::size_t>(2 + 2 * axis)];
            slope[axis] = (plus - minus) / 2;
            bend(axis, axis) = plus + minus - 2 * f[0];
        }
        const auto mixed = [&](int a, int b, double both) {
            const double fa = f[static_cast<std::size_t>(1 + 2 * a)], fb = f[static_cast<std::size_t>(1 + 2 * b)];
            bend(a, b) = bend(b, a) = both - fa - fb + f[0];
        };
        mixed(0, 1, f[7]);
        mixed(0, 2, f[8]);
        mixed(1, 2, f[9]);
        const Eigen::LLT<Eigen::Matrix3d> solver(-bend);
        if (solver.info() != Eigen::Success) return std::nullopt;
        Turn top = solver.solve(slope);
        top.z() /= kRollWeight;
        return top;
    }
};

} // namespace

glm::dmat3 matrixOf(const Turn& turn) {
    const double angle = turn.norm();
    if (angle < 1e-12) return glm::dmat3(1.0);
    const Turn v = turn * (std::sin(angle / 2) / angle);
    return poseFromQuaternion({}, v.x(), v.y(), v.z(), std::cos(angle / 2)).rotation;
}

Turn turnOf(const glm::dmat3& r) {
    const Turn twist(r[1][2] - r[2][1], r[2][0] - r[0][2], r[0][1] - r[1][0]); // twice the sine along the axis
    const double sine = twist.norm() / 2, cosine = (r[0][0] + r[1][1] + r[2][2] - 1) / 2;
    return sine > 1e-12 ? Turn(twist / (2 * sine) * std::atan2(sine, cosine)) : Turn(twist / 2);
}

Eigen::Matrix3d eigenOf(const glm::dmat3& matrix) {
    Eigen::Matrix3d eigen;
    for (int i = 0; i < 9; ++i)
        eigen(i % 3, i / 3) = matrix[i / 3][i % 3];
    return eigen;
}

/// Better first; ties by the turn itself, so that the order does not depend on threads.
bool TurnSearch::isBetter(const Candidate& a, const Candidate& b) {
    if (a.score != b.score) return a.score > b.score;
    return std::lexicographical_compare(a.turn.data(), a.turn.data() + 3, b.turn.data(), b.turn.data() + 3);
}

/// Climbs to a top by quadratics, or from the best place of a stencil to the next, in steps that become smaller.
TurnSearch::Candidate TurnSearch::climb(const Score& score, Candidate from, double step, double leastStep) {
    for (int i = 0; i < 40 && step > leastStep; ++i) {
        std::array<double, Stencil::kCount> f;
        f[0] = from.score;
        Candidate best = from;
        for (int k = 1; k < Stencil::kCount; ++k) {
            const Turn turn = from.turn + Stencil::place(k, step);
            f[static_cast<std::size_t>(k)] = score(turn);
            if (f[static_cast<std::size_t>(k)] > best.score) best = {turn, f[static_cast<std::size_t>(k)]};
        }
        if (const auto top = Stencil::top(f)) {
            const double length = distanceOf(*top, Turn::Zero());
            const Turn turn = from.turn + step * *top * std::min(1.0, 2 / std::max(length, 1e-9));
            const double there = score(turn);
            if (there > best.score) best = {turn, there};
        }
        const double moved = distanceOf(best.turn, from.turn);
        from = best;
        if (moved < step / 2) step /= 2.5;
    }
    return from;
}

/// The best of a list, in order, each so far from all before it.
std::vector<TurnSearch::Candidate> TurnSearch::apart(std::vector<Candidate> list, double distance, std::size_t most) {
    std::sort(list.begin(), list.end(), isBetter);
    std::vector<Candidate> kept;
    for (const Candidate& c : list) {
        if (kept.size() == most) break;
        if (std::all_of(kept.begin(), kept.end(),
                        [&](const Candidate& k) { return distanceOf(k.turn, c.turn) >= distance; }))
            kept.push_back(c);
    }
    return kept;
}

TurnSearch::TurnSearch(const std::vector<EdgeLevel>& levels, const Camera& scanCamera, PartRays rays)
    : levels_(levels), edgeScore_(levels, scanCamera), pixelRadians_(1 / scanCamera.fx), partRays_(std::move(rays)) {
    for (const auto& part : partRays_)
        rays_.insert(rays_.end(), part.begin(), part.end());
    const std::size_t stride = std::max<std::size_t>(1, rays_.size() / kFewRays);
    for (std::size_t i = 0; i < rays_.size(); i += stride)
        fewRays_.push_back(rays_[i]);
}

TurnFound TurnSearch::find(double reachRadians) const {
    TurnFound found;
    std::vector<Candidate> climbers = apart(grid(reachRadians), kApart, kClimbers);
    climbAll(climbers, 1, fewRays_, kGridStep / 2);
    climbers = apart(std::move(climbers), kSame, kSecondClimbers);
    for (std::size_t end = 2; end <= levels_.size(); ++end)
        climbAll(climbers, end, rays_, sigmaOf(end - 1));
    climbers = apart(std::move(climbers), kSame, kSecondClimbers);
    const Candidate& best = climbers.front();
    found.turn = best.turn;
    found.score = best.score;
    for (const Candidate& top : climbers)
        found.tops.push_back(top.turn);
    found.rivalShare = climbers.size() > 1 && best.score > 0 ? std::max(climbers[1].score, 0.0) / best.score : 0;
    sharpen(found);
    return found;
}

TurnFound TurnSearch::climbFrom(const Turn& turn) const {
    TurnFound found;
    std::vector<Candidate> climber{{turn, 0}};
    for (std::size_t end = 1; end <= levels_.size(); ++end)
        climbAll(climber, end, rays_, sigmaOf(end - 1));
    found.turn = climber.front().turn;
    found.score = climber.front().score;
    sharpen(found);
    return found;
}

/// The finest levels alone say where exactly.
void TurnSearch::sharpen(TurnFound& found) const {
    const Score finest = [&](const Turn& turn) {
        return edgeScore_.at(matrixOf(turn), rays_, firstFine(), levels_.size());
    };
    found.turn = climb(finest, {found.turn, finest(found.turn)}, sigmaOf(levels_.size() - 1), kLeastStep).turn;
    found.covariance = covarianceAt(found.turn);
    askParts(found);
}

bool TurnSearch::hasSay(std::size_t part) const {
    return std::ssize(partRays_[part]) >= kLeastRaysOfPart;
}

std::vector<TurnSearch::Candidate> TurnSearch::grid(double reachRadians) const {
    const int reach = static_cast<int>(std::ceil(reachRadians / kGridStep));
    std::vector<Candidate> turns;
    for (int z = -reach; z <= reach; ++z)
        for (int y = -reach; y <= reach; ++y)
            for (int x = -reach; x <= reach; ++x) {
                const Turn turn = kGridStep * Turn(x, y, z);
                if (turn.norm() <= reachRadians + 0.5 * kGridStep) turns.push_back({turn, 0});
            }
    tbb::parallel_for(std::size_t{0}, turns.size(),
                      [&](std::size_t i) { turns[i].score = edgeScore_.at(matrixOf(turns[i].turn), fewRays_, 0, 1); });
    return turns;
}

void TurnSearch::climbAll(std::vector<Candidate>& climbers, std::size_t end, const std::vector<EdgeRay>& rays,
                          double step) const {
    tbb::parallel_for(std::size_t{0}, climbers.size(), [&](std::size_t i) {
        const Score score = [&](const Turn& turn) { return edgeScore_.at(matrixOf(turn), rays, 0, end); };
        climbers[i] = climb(score, {climbers[i].turn, score(climbers[i].turn)}, step, step / 20);
    });
}

/// Efron, "The jackknife, the bootstrap and other resampling plans", 1982: over the parts of the picture, whose
/// faults (a lens that is not quite known, things that moved) are those of all edges in it.
std::optional<Eigen::Matrix3d> TurnSearch::covarianceAt(const Turn& found) const {
    const std::size_t fine = firstFine();
    const double step = 0.7 * sigmaOf(levels_.size() - 1);
    std::array<PartSums, Stencil::kCount> sums;
    for (int k = 0; k < Stencil::kCount; ++k)
        sums[static_cast<std::size_t>(k)] =
            edgeScore_.partsAt(matrixOf(found + Stencil::place(k, step)), partRays_, fine, levels_.size());
    std::vector<Turn> tops;
    for (int part = 0; part < kParts; ++part) {
        if (!hasSay(static_cast<std::size_t>(part))) continue;
        std::array<double, Stencil::kCount> f;
        for (std::size_t k = 0; k < f.size(); ++k)
            f[k] = sums[k].scoreWithout(part);
        const auto top = Stencil::top(f);
        if (!top) return std::nullopt;
        tops.push_back(step * *top);
    }
    if (tops.size() < 2) return std::nullopt;
    Turn mean = Turn::Zero();
    for (const Turn& top : tops)
        mean += top / static_cast<double>(tops.size());
    Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
    for (const Turn& top : tops)
        squares += (top - mean) * (top - mean).transpose();
    return squares * ((static_cast<double>(tops.size()) - 1) / static_cast<double>(tops.size()));
}

void TurnSearch::askParts(TurnFound& found) const {
    const auto scoresAt = [&](const Turn& turn) {
        const PartSums sums = edgeScore_.partsAt(matrixOf(found.turn + turn), partRays_, firstFine(), levels_.size());
        std::array<double, kParts> scores{};
        for (std::size_t part = 0; part < scores.size(); ++part)
            if (sums.weights[part] > 0) scores[part] = sums.gains[part] / sums.weights[part];
        return scores;
    };
    std::vector<Turn> near, about;
    for (const double x : {-kPartReach, -kPartReach / 2, 0.0, kPartReach / 2, kPartReach})
        for (const double y : {-kPartReach, -kPartReach / 2, 0.0, kPartReach / 2, kPartReach})
            near.emplace_back(x, y, 0);
    const int steps = static_cast<int>(kNeighbourhood / kNeighbourStep);
    for (int y = -steps; y <= steps; ++y)
        for (int x = -steps; x <= steps; ++x)
            if (std::hypot(x, y) * kNeighbourStep > kSame) about.push_back(kNeighbourStep * Turn(x, y, 0));
    std::array<double, kParts> best;
    best.fill(-1e9);
    for (const Turn& turn : near) {
        const auto scores = scoresAt(turn);
        for (std::size_t part = 0; part < scores.size(); ++part)
            best[part] = std::max(best[part], scores[part]);
    }
    std::vector<std::array<double, kParts>> others(about.size());
    tbb::parallel_for(std::size_t{0}, about.size(), [&](std::size_t i) { others[i] = scoresAt(about[i]); });
    int agreeing = 0;
    for (std::size_t p = 0; p < partRays_.size(); ++p) {
        if (!hasSay(p)) continue;
        const auto better =
            std::count_if(others.begin(), others.end(), [&](const auto& scores) { return scores[p] >= best[p]; });
        ++found.parts;
        agreeing += static_cast<double>(better) <= kMostBetter * static_cast<double>(others.size());
    }
    found.agreeing = found.parts > 0 ? static_cast<double>(agreeing) / found.parts : 0;
}

} // namespace scene
