#include "scene/align/joint_turns.h"

#include "scene/align/neighbour_turn.h"
#include "scene/align/turn_network.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include <Eigen/Dense>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

namespace scene {

namespace {

constexpr double kSameCentreMetres = 0.003; ///< from farther apart near things would be seen to shift
constexpr double kInside = 0.04;            ///< of the neighbour's width: edges so near to its rim are left out
constexpr int kLeastRays = 150;             ///< that two photographs must share to be searched for each other
constexpr std::size_t kMostTops = 4;        ///< of that search, which are looked at closely
/// What deviations of pairs never fall below: lenses that are not quite known, and edges that light draws.
constexpr double kLeastPair = 0.003 * kDegree;
/// Times what the jackknife says, of a photograph that the scan says too little of.
constexpr double kUnsureOwn = 2;
constexpr double kMostPairDeviation = 0.0015; ///< radians; more than a pixel, it may lie on another edge
constexpr int kEdgeColumns = 16, kEdgeRows = 12, kMostEdgesInPart = 30; ///< that are searched for in another
/// Of greys: of a pair that is believed, of its parts; that a second top may have of the first one's.
constexpr double kLeastCorrelation = 0.5, kLeastAgreeing = 0.7, kMostRivalShare = 0.8;
/// Of a pair that is believed alone.
constexpr double kPlainCorrelation = 0.7, kPlainAgreeing = 0.8;
constexpr int kLeastParts = 4, kPlainParts = 6;
constexpr double kLeastOverlap = 0.03; ///< of a picture
/// Share of photographs that hang together which the scan itself must place: one that is by chance must not place all.
constexpr double kLeastAnchors = 0.25;
constexpr double kSameTurn = 0.1 * kDegree;

/// The edges of a as b sees them; parts are those of what they share.
PartRays raysInto(const std::vector<EdgePoint>& points, const Camera& cameraA, const Camera& cameraB,
                  const glm::dmat3& bFromA) {
    struct Shared {
        glm::dvec2 at{0.0};
        EdgeRay ray;
    };
    std::vector<Shared> shared;
    glm::dvec2 low(1e9), high(-1e9);
    const double rim = kInside * cameraB.width;
    for (const EdgePoint& point : points) {
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
        parts[static_cast<std::size_t>(pieceOf(s.at.y, low.y, high.y, rows) * columns +
                                       pieceOf(s.at.x, low.x, high.x, columns))]
            .push_back(s.ray);
    }
    return parts;
}

/// Turns of which one may lay a on b, by their edges; wherever within reach.
std::vector<Turn> searched(const SmallPhotograph& a, const SmallPhotograph& b, const glm::dmat3& bFromA,
                           double reachRadians) {
    const PartRays rays = raysInto(edgePoints(textureEdges(a.picture), kEdgeColumns, kEdgeRows, kMostEdgesInPart),
                                   a.camera, b.camera, bFromA);
    if (std::all_of(rays.begin(), rays.end(), [](const auto& part) { return part.empty(); })) return {};
    const EdgeImage edges = textureEdges(b.picture);
    const std::vector<EdgeLevel> levels = edgeLevels(edges, edges, 1 / b.camera.fx);
    std::vector<Turn> tops;
    // A thread that waits in there would begin another pair, and hold the pictures of both.
    tbb::this_task_arena::isolate([&] { tops = TurnSearch(levels, b.camera, rays).find(reachRadians).tops; });
    tops.resize(std::min(tops.size(), kMostTops));
    return tops;
}

enum class Laid { not_at_all, partly, wholly };

/// Partly: about one axis nothing holds it, as where all edges that both see run one way.
Laid howLaid(const NeighbourTurn& found) {
    if (found.correlation < kLeastCorrelation || found.parts < kLeastParts || found.agreeing < kLeastAgreeing)
        return Laid::not_at_all;
    const auto isExact = [](double variance) { return std::sqrt(variance) <= kMostPairDeviation; };
    if (isExact(found.covariance.trace())) return Laid::wholly;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(found.covariance, Eigen::EigenvaluesOnly);
    return isExact(solver.eigenvalues()[0] + solver.eigenvalues()[1]) ? Laid::partly : Laid::not_at_all;
}

bool doOverlap(const Camera& a, const Camera& b, const glm::dmat3& bFromA) {
    constexpr int kSteps = 16;
    int shared = 0;
    for (int y = 0; y < kSteps; ++y)
        for (int x = 0; x < kSteps; ++x) {
            const glm::dvec3 ray = bFromA * rayThrough(a, (x + 0.5) * a.width / kSteps, (y + 0.5) * a.height / kSteps);
            if (!(ray.z > 0.1)) continue;
            const glm::dvec2 at = project(b, ray);
            shared += at.x > 0 && at.y > 0 && at.x < b.width && at.y < b.height;
        }
    return shared >= kLeastOverlap * kSteps * kSteps;
}

/// How a stands to b as their greys have it.
struct Pair {
    std::size_t a = 0, b = 0;
    glm::dmat3 bFromA{1.0};
    Eigen::Matrix3d covariance; ///< of a further turn about b's axes
    bool isPlain = false;       ///< so sure that it needs no other to agree
    bool isWhole = false;       ///< known about all axes
};

/// The photographs of a scan, each placed as well as is known so far: by the scan, or by another beside it.
class Neighbours {
  public:
    Neighbours(std::span<const PhotographOnScan> photographs, const std::vector<ColourFit>& fits,
               const ColourToRangeOptions& options)
        : photographs_(photographs), options_(options) {
        for (std::size_t i = 0; i < photographs.size(); ++i) {
            // Where a fit is not believed the pose as given is the better guess.
            rotations.push_back(photographs[i].scannerFromGiven.rotation *
                                (fits[i].isFound ? fits[i].givenFromFound : glm::dmat3(1.0)));
            isPlaced_.push_back(fits[i].isFound);
        }
        for (std::size_t a = 0; a < photographs.size(); ++a)
            for (std::size_t b = a + 1; b < photographs.size(); ++b)
                if (glm::distance(photographs[a].scannerFromGiven.translation,
                                  photographs[b].scannerFromGiven.translation) <= kSameCentreMetres)
                    open_.push_back({a, b, false});
    }

    /// From those that are placed to those beside them, until no more is found.
    void compareAll() {
        for (;;) {
            const auto isWaiting = [&](const Open& open) {
                return !(isPlaced_[open.a] && isPlaced_[open.b]) &&
                       (open.isSearched || !(isPlaced_[open.a] || isPlaced_[open.b]));
            };
            const auto ready = std::stable_partition(open_.begin(), open_.end(), isWaiting);
            std::vector<Open> now(ready, open_.end());
            if (now.empty()) return;
            open_.erase(ready, open_.end());
            std::vector<std::optional<Pair>> found(now.size());
            tbb::parallel_for(std::size_t{0}, now.size(), [&](std::size_t i) { found[i] = compare(now[i]); });
            for (std::size_t i = 0; i < now.size(); ++i) {
                const bool arePlaced = isPlaced_[now[i].a] && isPlaced_[now[i].b];
                if (found[i])
                    pairs_.push_back(*found[i]);
                else if (!arePlaced) // once both are placed, one knows better where to look
                    open_.push_back({now[i].a, now[i].b, true});
            }
            placeBeside();
        }
    }

    /// Those that the rest contradicts are placed by their neighbours alone, as far as these are believed.
    void placeAgain(const std::vector<std::size_t>& contradicted, const std::vector<PairTurn>& believed) {
        pairs_.erase(std::remove_if(pairs_.begin(), pairs_.end(),
                                    [&](const Pair& pair) {
                                        return std::none_of(believed.begin(), believed.end(), [&](const PairTurn& b) {
                                            return b.a == pair.a && b.b == pair.b;
                                        });
                                    }),
                     pairs_.end());
        for (const std::size_t i : contradicted)
            isPlaced_[i] = false;
        for (std::size_t i = 0; i < contradicted.size(); ++i)
            placeBeside();
    }

    /// The pairs as turns from where all are placed.
    std::vector<PairTurn> turns() const {
        std::vector<PairTurn> turns;
        for (const Pair& pair : pairs_) {
            const glm::dmat3 bFromA = between(pair.a, pair.b);
            turns.push_back({pair.a, pair.b, eigenOf(bFromA), turnOf(pair.bFromA * glm::transpose(bFromA)),
                             pair.covariance, pair.isPlain, pair.isWhole});
        }
        return turns;
    }

    std::vector<glm::dmat3> rotations; ///< scannerFromCamera

  private:
    struct Open {
        std::size_t a = 0, b = 0;
        bool isSearched = false;
    };

    glm::dmat3 between(std::size_t a, std::size_t b) const { return glm::transpose(rotations[b]) * rotations[a]; }

    std::optional<Pair> compare(const Open& open) const {
        const auto [a, b, isSearched] = open;
        const glm::dmat3 bFromA = between(a, b);
        const SmallPhotograph &from = photographs_[a].small, &to = photographs_[b].small;
        if (!doOverlap(from.camera, to.camera, bFromA)) return std::nullopt;
        const GreyLevels greysA = greyLevels(from), greysB = greyLevels(to);
        std::optional<NeighbourTurn> best;
        if (isPlaced_[a] && isPlaced_[b]) best = layOnNeighbour(greysA, greysB, bFromA, Turn::Zero());
        const bool isNear = best && howLaid(*best) != Laid::not_at_all;
        if (!isSearched && !isNear) {
            // One of the two may stand elsewhere.
            best.reset();
            double second = 0;
            for (const Turn& start : searched(from, to, bFromA, options_.reachRadians)) {
                const auto found = layOnNeighbour(greysA, greysB, bFromA, start);
                if (!found || (best && (best->turn - found->turn).norm() < kSameTurn)) continue;
                second = std::max(second, best ? std::min(best->correlation, found->correlation) : 0);
                if (!best || found->correlation > best->correlation) best = found;
            }
            if (best && second > kMostRivalShare * best->correlation) best.reset();
        }
        const Laid laid = best ? howLaid(*best) : Laid::not_at_all;
        // What is partly laid says nothing of where else it might stand.
        if (laid == Laid::not_at_all || (laid == Laid::partly && !isNear)) return std::nullopt;
        Pair pair{a, b, matrixOf(best->turn) * bFromA, best->covariance};
        pair.covariance += kLeastPair * kLeastPair * Eigen::Matrix3d::Identity();
        pair.isWhole = laid == Laid::wholly;
        pair.isPlain = pair.isWhole && best->correlation >= kPlainCorrelation && best->parts >= kPlainParts &&
                       best->agreeing >= kPlainAgreeing;
        return pair;
    }

    /// Each that is not placed by the surest of its neighbours that is.
    void placeBeside() {
        std::vector<bool> isPlaced = isPlaced_;
        for (std::size_t i = 0; i < isPlaced.size(); ++i) {
            const Pair* surest = nullptr;
            for (const Pair& pair : pairs_) {
                if (isPlaced_[i] || !pair.isWhole || (pair.a != i && pair.b != i) ||
                    !isPlaced_[pair.a == i ? pair.b : pair.a])
                    continue;
                if (!surest || pair.covariance.trace() < surest->covariance.trace()) surest = &pair;
            }
            if (!surest) continue;
            rotations[i] = surest->b == i ? rotations[surest->a] * glm::transpose(surest->bFromA)
                                          : rotations[surest->b] * surest->bFromA;
            isPlaced[i] = true;
        }
        isPlaced_ = isPlaced;
    }

    std::span<const PhotographOnScan> photographs_;
    const ColourToRangeOptions& options_;
    std::vector<bool> isPlaced_;
    std::vector<Open> open_; ///< not compared yet
    std::vector<Pair> pairs_;
};

OwnTurn ownOf(std::size_t photograph, const ColourFit& fit) {
    const double scale = fit.isSure ? 1 : kUnsureOwn;
    return {photograph, scale * scale * eigenOf(fit.covariance), fit.isSure};
}

/// What the network says of a photograph. givenFromPlaced: as it was placed, before the network's turn.
void settle(ColourFit& fit, const TurnNetwork& network, std::size_t i, const glm::dmat3& givenFromPlaced,
            const ColourToRangeOptions& options) {
    const bool isContradicted =
        std::find(network.contradicted.begin(), network.contradicted.end(), i) != network.contradicted.end();
    if (!isContradicted && (!network.isAnchored[i] || network.neighboursOf(i) == 0)) return;
    const bool isItsOwn = fit.isFound && !isContradicted;
    if (!isItsOwn && !network.isBelieved[i]) {
        if (isContradicted) fit.isSure = false, fit.why = "it contradicts its neighbours";
        return;
    }
    if (network.isDisputed(i)) {
        fit.isSure = false;
        fit.why = "it contradicts its neighbour";
        return;
    }
    if (network.anchorsOf(i) < kLeastAnchors * network.joinedTo(i)) {
        fit.isSure = false;
        fit.why = "hardly any photograph that it is joined to lies on the scan";
        return;
    }
    fit.givenFromFound = givenFromPlaced * matrixOf(network.turns[i]);
    fit.turnedRadians = turnOf(fit.givenFromFound).norm();
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
    Neighbours neighbours(photographs, fits, options);
    neighbours.compareAll();
    std::vector<std::size_t> contradicted;
    const auto solved = [&] {
        std::vector<OwnTurn> own;
        for (std::size_t i = 0; i < photographs.size(); ++i)
            if (fits[i].isFound && std::find(contradicted.begin(), contradicted.end(), i) == contradicted.end())
                own.push_back(ownOf(i, fits[i]));
        TurnNetwork network(photographs.size(), std::move(own), neighbours.turns(), contradicted);
        network.solve();
        return network;
    };
    TurnNetwork network = solved();
    if (!network.contradicted.empty()) {
        // Far from where they were found, turns do not simply add.
        contradicted = network.contradicted;
        neighbours.placeAgain(contradicted, network.pairs());
        network = solved();
    }
    for (std::size_t i = 0; i < photographs.size(); ++i)
        settle(fits[i], network, i, glm::transpose(photographs[i].scannerFromGiven.rotation) * neighbours.rotations[i],
               options);
}

} // namespace scene
