#include "scene/align/joint_turns.h"

#include "scene/align/turn_search.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <Eigen/Dense>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <tbb/parallel_for.h>

namespace scene {

namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kSamePlaceMetres = 0.003; ///< from farther apart near things would be seen to shift
constexpr double kInside = 0.04;           ///< of the neighbour's width: edges so near to its rim are left out
constexpr int kLeastRays = 150;            ///< that two photographs must share
/// What deviations never fall below: lenses that are not quite known, and edges that light draws.
constexpr double kLeastOwn = 0.004 * kDegree, kLeastPair = 0.004 * kDegree;
constexpr double kMostRivalShare = 0.7; ///< a strip that two share is less than a picture
constexpr int kLeastNeighbours = 2;     ///< that must agree on where one stands that its scan could not place
constexpr double kContradicts = 25;     ///< squared deviations, of three axes together
constexpr int kMostRays = 3000;

/// The edges of a photograph.
struct Edges {
    std::vector<EdgePoint> points;
    std::vector<EdgeLevel> levels;
};

Edges edgesOf(const PhotographOnScan& photograph) {
    const EdgeImage edges = textureEdges(*photograph.picture);
    return {edgePoints(edges, 16, 12, kMostRays / 100), edgeLevels(edges, edges, 1 / photograph.camera.fx)};
}

Eigen::Matrix3d eigenOf(const glm::dmat3& m) {
    Eigen::Matrix3d e;
    for (int i = 0; i < 9; ++i)
        e(i % 3, i / 3) = m[i / 3][i % 3];
    return e;
}

/// The edges of a as b sees them; parts are those of what they share. bFromA turns directions.
PartRays raysInto(const Edges& a, const Camera& cameraA, const Camera& cameraB, const glm::dmat3& bFromA) {
    struct Shared {
        glm::dvec2 at{0.0};
        EdgeRay ray;
    };
    std::vector<Shared> shared;
    glm::dvec2 low(1e9), high(-1e9);
    const double rim = kInside * cameraB.width;
    for (const EdgePoint& point : a.points) {
        // The normal's angle there: of the line through both neighbours along the edge.
        const double half = 0.5 * std::atan2(point.sine, point.cosine);
        const glm::dvec2 along(-std::sin(half), std::cos(half));
        const auto placeOf = [&](double t) -> std::optional<glm::dvec2> {
            const glm::dvec3 p = bFromA * rayThrough(cameraA, point.x + t * along.x, point.y + t * along.y);
            if (!(p.z > 0.1 * glm::length(p))) return std::nullopt;
            return project(cameraB, p);
        };
        const auto at = placeOf(0), before = placeOf(-1), after = placeOf(1);
        if (!at || !before || !after) continue;
        if (!(at->x > rim && at->y > rim && at->x < cameraB.width - rim && at->y < cameraB.height - rim)) continue;
        const glm::dvec2 edge = *after - *before;
        const double normal = std::atan2(edge.x, -edge.y);
        low = glm::min(low, *at), high = glm::max(high, *at);
        shared.push_back({*at,
                          {glm::vec3(rayThrough(cameraB, at->x, at->y)), point.strength,
                           static_cast<float>(std::cos(2 * normal)), static_cast<float>(std::sin(2 * normal))}});
    }
    PartRays parts;
    if (std::ssize(shared) < kLeastRays) return parts;
    // Two neighbours in a row share a strip that is higher than wide.
    const bool isHigh = high.y - low.y >= high.x - low.x;
    const int columns = isHigh ? 3 : 4, rows = isHigh ? 4 : 3;
    for (const Shared& s : shared) {
        const auto cell = [](double v, double from, double to, int count) {
            return std::clamp(static_cast<int>((v - from) / std::max(to - from, 1.0) * count), 0, count - 1);
        };
        parts[static_cast<std::size_t>(cell(s.at.y, low.y, high.y, rows) * columns +
                                       cell(s.at.x, low.x, high.x, columns))]
            .push_back(s.ray);
    }
    return parts;
}

/// How a stands to b: turn * bFromA is right, turn about b's axes.
struct Pair {
    std::size_t a = 0, b = 0;
    Eigen::Matrix3d bFromA; ///< as it was when they were compared
    Turn turn = Turn::Zero();
    Eigen::Matrix3d weight; ///< inverse covariance
};

std::optional<Pair> compare(std::size_t a, std::size_t b, std::span<const PhotographOnScan> photographs,
                            const std::vector<Edges>& edges, const std::vector<glm::dmat3>& scannerFromCamera,
                            const std::vector<ColourFit>& fits, const ColourToRangeOptions& options) {
    const glm::dmat3 bFromA = glm::transpose(scannerFromCamera[b]) * scannerFromCamera[a];
    if (bFromA[2].z < 0.3) return std::nullopt; // more than 70 degrees apart
    const PartRays rays = raysInto(edges[a], photographs[a].camera, photographs[b].camera, bFromA);
    std::size_t count = 0;
    for (const auto& part : rays)
        count += part.size();
    if (count == 0) return std::nullopt;
    const TurnSearch search(edges[b].levels, photographs[b].camera, rays);
    const bool areBothKnown = fits[a].isFound && fits[b].isFound;
    const TurnFound found = areBothKnown ? search.climbFrom(Turn::Zero()) : search.find(options.reachRadians);
    if (!found.covariance || found.parts < options.leastParts - 1 || found.agreeing < options.leastAgreeing ||
        found.score < options.leastScore)
        return std::nullopt;
    if (!areBothKnown && found.rivalShare > kMostRivalShare) return std::nullopt;
    if (std::sqrt(found.covariance->trace()) > options.mostDeviationRadians) return std::nullopt;
    const Eigen::Matrix3d covariance = *found.covariance + kLeastPair * kLeastPair * Eigen::Matrix3d::Identity();
    return Pair{a, b, eigenOf(bFromA), found.turn, covariance.inverse()};
}

/// What the scan says of a photograph itself: its turn from where it was found is zero, so exactly.
struct Own {
    std::size_t photograph = 0;
    Eigen::Matrix3d weight;
};

class Network {
  public:
    Network(std::size_t count, std::vector<Own> own, std::vector<Pair> pairs)
        : count_(count), own_(std::move(own)), pairs_(std::move(pairs)) {}

    /// Takes away, one at a time, what contradicts the rest; then holds the turns of all that are joined to an own.
    void solve() {
        for (;;) {
            findAnchored();
            adjust();
            double worst = kContradicts;
            std::size_t worstOwn = own_.size(), worstPair = pairs_.size();
            for (std::size_t i = 0; i < own_.size(); ++i) {
                const Turn& r = turns[own_[i].photograph];
                const double squares = r.dot(own_[i].weight * r);
                if (squares > worst) worst = squares, worstOwn = i;
            }
            for (std::size_t i = 0; i < pairs_.size(); ++i) {
                const Turn r = residualOf(pairs_[i]);
                const double squares = r.dot(pairs_[i].weight * r);
                if (isAnchored[pairs_[i].a] && squares > worst) worst = squares, worstPair = i;
            }
            if (worstPair < pairs_.size()) {
                pairs_.erase(pairs_.begin() + static_cast<std::ptrdiff_t>(worstPair));
            } else if (worstOwn < own_.size()) {
                contradicted.push_back(own_[worstOwn].photograph);
                own_.erase(own_.begin() + static_cast<std::ptrdiff_t>(worstOwn));
            } else {
                return;
            }
        }
    }

    int neighboursOf(std::size_t photograph) const {
        return static_cast<int>(std::count_if(pairs_.begin(), pairs_.end(), [&](const Pair& pair) {
            return pair.a == photograph || pair.b == photograph;
        }));
    }
    /// Of two that contradict each other nobody knows which is wrong.
    bool isDisputed(std::size_t photograph) const {
        const auto isJoined = [&](std::size_t other) { return group_[other] == group_[photograph]; };
        const auto anchors =
            std::count_if(own_.begin(), own_.end(), [&](const Own& own) { return isJoined(own.photograph); });
        return anchors < 2 && std::any_of(contradicted.begin(), contradicted.end(), isJoined);
    }

    std::vector<Turn> turns;
    std::vector<Eigen::Matrix3d> covariances;
    std::vector<bool> isAnchored;
    std::vector<std::size_t> contradicted;

  private:
    Turn residualOf(const Pair& pair) const { return pair.turn - (pair.bFromA * turns[pair.a] - turns[pair.b]); }

    void findAnchored() {
        group_.resize(count_);
        for (std::size_t i = 0; i < count_; ++i)
            group_[i] = i;
        for (bool isChanged = true; isChanged;) {
            isChanged = false;
            for (const Pair& pair : pairs_) {
                const std::size_t least = std::min(group_[pair.a], group_[pair.b]);
                isChanged |= group_[pair.a] != least || group_[pair.b] != least;
                group_[pair.a] = group_[pair.b] = least;
            }
        }
        isAnchored.assign(count_, false);
        for (const Own& own : own_)
            for (std::size_t i = 0; i < count_; ++i)
                if (group_[i] == group_[own.photograph]) isAnchored[i] = true;
    }

    /// A further turn r of camera i: found * r. To first order a pair says that its turn is bFromA r_a - r_b.
    void adjust() {
        const auto size = static_cast<Eigen::Index>(3 * count_);
        Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(size, size);
        Eigen::VectorXd right = Eigen::VectorXd::Zero(size);
        const auto at = [](std::size_t i) { return static_cast<Eigen::Index>(3 * i); };
        for (const Own& own : own_)
            normal.block<3, 3>(at(own.photograph), at(own.photograph)) += own.weight;
        for (const Pair& pair : pairs_) {
            if (!isAnchored[pair.a]) continue;
            const Eigen::Matrix3d toA = pair.bFromA.transpose() * pair.weight;
            normal.block<3, 3>(at(pair.a), at(pair.a)) += toA * pair.bFromA;
            normal.block<3, 3>(at(pair.b), at(pair.b)) += pair.weight;
            normal.block<3, 3>(at(pair.a), at(pair.b)) -= toA;
            normal.block<3, 3>(at(pair.b), at(pair.a)) -= toA.transpose();
            right.segment<3>(at(pair.a)) += toA * pair.turn;
            right.segment<3>(at(pair.b)) -= pair.weight * pair.turn;
        }
        for (std::size_t i = 0; i < count_; ++i)
            if (!isAnchored[i]) normal.block<3, 3>(at(i), at(i)) = Eigen::Matrix3d::Identity();
        const Eigen::LDLT<Eigen::MatrixXd> solver(normal);
        const Eigen::VectorXd solution = solver.solve(right);
        const Eigen::MatrixXd covariance = solver.solve(Eigen::MatrixXd::Identity(size, size));
        turns.clear();
        covariances.clear();
        for (std::size_t i = 0; i < count_; ++i) {
            turns.emplace_back(solution.segment<3>(at(i)));
            covariances.emplace_back(covariance.block<3, 3>(at(i), at(i)));
        }
    }

    std::size_t count_;
    std::vector<Own> own_;
    std::vector<Pair> pairs_;
    std::vector<std::size_t> group_;
};

void settle(ColourFit& fit, const Network& network, std::size_t i, const ColourToRangeOptions& options) {
    const bool isContradicted =
        std::find(network.contradicted.begin(), network.contradicted.end(), i) != network.contradicted.end();
    if (!network.isAnchored[i] || (network.neighboursOf(i) == 0 && !isContradicted)) return;
    const bool isItsOwn = fit.isFound && !isContradicted;
    if (!isItsOwn && network.neighboursOf(i) < kLeastNeighbours) {
        if (isContradicted) fit.isSure = false, fit.why = "it contradicts its neighbours";
        return;
    }
    if (network.isDisputed(i)) {
        fit.isSure = false;
        fit.why = "it contradicts its neighbour";
        return;
    }
    fit.givenFromFound = fit.givenFromFound * matrixOf(network.turns[i]);
    const glm::dmat3& r = fit.givenFromFound;
    const glm::dvec3 twist(r[1][2] - r[2][1], r[2][0] - r[0][2], r[0][1] - r[1][0]);
    fit.turnedRadians = std::atan2(glm::length(twist) / 2, (r[0][0] + r[1][1] + r[2][2] - 1) / 2);
    for (int k = 0; k < 9; ++k)
        fit.covariance[k / 3][k % 3] = network.covariances[i](k % 3, k / 3);
    fit.deviationRadians = std::sqrt(network.covariances[i].trace());
    fit.neighbours = network.neighboursOf(i);
    if (isItsOwn) return judge(fit, options);
    // What the scan itself said of it is not believed; its neighbours are.
    fit.isSure = fit.turnedRadians <= options.reachRadians && fit.deviationRadians <= options.mostDeviationRadians;
    if (fit.isSure) fit.why.clear();
}

} // namespace

void joinTurns(std::span<const PhotographOnScan> photographs, std::vector<ColourFit>& fits,
               const ColourToRangeOptions& options) {
    if (photographs.size() < 2) return;
    std::vector<Edges> edges(photographs.size());
    tbb::parallel_for(std::size_t{0}, edges.size(), [&](std::size_t i) { edges[i] = edgesOf(photographs[i]); });
    std::vector<glm::dmat3> scannerFromCamera;
    std::vector<Own> own;
    for (std::size_t i = 0; i < photographs.size(); ++i) {
        // Where a fit is not believed the pose as given is the better guess.
        if (!fits[i].isFound) fits[i].givenFromFound = glm::dmat3(1.0);
        scannerFromCamera.push_back(photographs[i].scannerFromGiven.rotation * fits[i].givenFromFound);
        const Eigen::Matrix3d covariance =
            eigenOf(fits[i].covariance) + kLeastOwn * kLeastOwn * Eigen::Matrix3d::Identity();
        if (fits[i].isFound) own.push_back({i, covariance.inverse()});
    }
    std::vector<std::pair<std::size_t, std::size_t>> candidates;
    for (std::size_t a = 0; a < photographs.size(); ++a)
        for (std::size_t b = a + 1; b < photographs.size(); ++b)
            if (glm::distance(photographs[a].scannerFromGiven.translation,
                              photographs[b].scannerFromGiven.translation) <= kSamePlaceMetres &&
                (fits[a].isFound || fits[b].isFound))
                candidates.emplace_back(a, b);
    std::vector<std::optional<Pair>> compared(candidates.size());
    tbb::parallel_for(std::size_t{0}, candidates.size(), [&](std::size_t i) {
        compared[i] =
            compare(candidates[i].first, candidates[i].second, photographs, edges, scannerFromCamera, fits, options);
    });
    std::vector<Pair> pairs;
    for (const auto& pair : compared)
        if (pair) pairs.push_back(*pair);
    Network network(photographs.size(), std::move(own), std::move(pairs));
    network.solve();
    for (std::size_t i = 0; i < photographs.size(); ++i)
        settle(fits[i], network, i, options);
}

} // namespace scene
