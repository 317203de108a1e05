#include "scene/align/colour_to_range.h"

#include "scene/align/edge_score.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>

#include <Eigen/Dense>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <tbb/parallel_for.h>

namespace scene {

namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kBroadestSigma = 0.5 * kDegree; ///< of the levels, in the middle of the picture
constexpr double kFinestSigmaPixels = 1.2;
constexpr std::size_t kMostLevels = 5;
constexpr double kGridStep = 0.4 * kDegree; ///< between turns that are tried first
constexpr double kApart = 0.8 * kDegree;    ///< of these, such that climb by themselves
constexpr double kRollWeight = 0.5;         ///< a roll moves edges less than a turn to the side by so much
constexpr std::size_t kClimbers = 24, kSecondClimbers = 8;
constexpr double kSame = 0.3 * kDegree; ///< turns that are no rivals but the same one
constexpr int kMostRays = 4200, kFewRays = 1200;
constexpr int kLeastRaysOfPart = 25;
constexpr double kNeighbourhood = 1.5 * kDegree, kNeighbourStep = 0.15 * kDegree; ///< what a part compares with
constexpr double kPartReach = 0.1 * kDegree; ///< a part may have its best so far beside the turn
constexpr double kMostBetter = 0.1;          ///< a part likes a turn if less than this share about it is better

using Turn = Eigen::Vector3d; ///< a rotation by its axis and angle; x and y look elsewhere, z rolls

glm::dmat3 matrixOf(const Turn& turn) {
    return rotationOf({turn.x(), turn.y(), turn.z()});
}

double distanceOf(const Turn& a, const Turn& b) {
    const Turn d = a - b;
    return std::hypot(std::hypot(d.x(), d.y()), kRollWeight * d.z());
}

struct Candidate {
    Turn turn = Turn::Zero();
    double score = 0;
};

/// Better first; ties by the turn itself, so that the order does not depend on threads.
bool isBetter(const Candidate& a, const Candidate& b) {
    if (a.score != b.score) return a.score > b.score;
    return std::lexicographical_compare(a.turn.data(), a.turn.data() + 3, b.turn.data(), b.turn.data() + 3);
}

using Score = std::function<double(const Turn&)>;

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

/// Climbs to a top by quadratics, or from the best place of a stencil to the next, in steps that become smaller.
Candidate climb(const Score& score, Candidate from, double step, double leastStep) {
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
std::vector<Candidate> apart(std::vector<Candidate> list, double distance, std::size_t most) {
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

class Search {
  public:
    Search(const std::vector<EdgeLevel>& levels, const Camera& scanCamera, double pixelRadians,
           std::array<std::vector<EdgeRay>, kParts> rays, const ColourToRangeOptions& options)
        : edgeScore_(levels, scanCamera), levels_(levels), pixelRadians_(pixelRadians), partRays_(std::move(rays)),
          options_(options) {
        for (const auto& part : partRays_)
            rays_.insert(rays_.end(), part.begin(), part.end());
        const std::size_t stride = std::max<std::size_t>(1, rays_.size() / kFewRays);
        for (std::size_t i = 0; i < rays_.size(); i += stride)
            fewRays_.push_back(rays_[i]);
    }

    ColourFit find() const {
        ColourFit fit;
        std::vector<Candidate> climbers = apart(grid(), kApart, kClimbers);
        climbAll(climbers, 1, fewRays_, kGridStep / 2);
        climbers = apart(std::move(climbers), kSame, kSecondClimbers);
        for (std::size_t end = 2; end <= levels_.size(); ++end)
            climbAll(climbers, end, rays_, sigmaOf(end - 1));
        climbers = apart(std::move(climbers), kSame, kSecondClimbers);
        const Candidate& best = climbers.front();
        fit.score = best.score;
        fit.rivalShare = climbers.size() > 1 && best.score > 0 ? std::max(climbers[1].score, 0.0) / best.score : 0;
        // The finest levels alone say where exactly.
        const std::size_t fine = levels_.size() > 1 ? levels_.size() - 2 : 0;
        const Score finest = [&](const Turn& turn) {
            return edgeScore_.at(matrixOf(turn), rays_, fine, levels_.size());
        };
        const Candidate top =
            climb(finest, {best.turn, finest(best.turn)}, sigmaOf(levels_.size() - 1), 0.002 * kDegree);
        const Turn& found = top.turn;
        fit.givenFromFound = matrixOf(found);
        fit.turnedRadians = found.norm();
        fit.deviationRadians = deviationAt(found, fine);
        askParts(found, fine, fit);
        return fit;
    }

  private:
    double sigmaOf(std::size_t level) const { return levels_[level].sigmaPixels * pixelRadians_; }

    std::vector<Candidate> grid() const {
        const int reach = static_cast<int>(std::ceil(options_.reachRadians / kGridStep));
        std::vector<Candidate> turns;
        for (int z = -reach; z <= reach; ++z)
            for (int y = -reach; y <= reach; ++y)
                for (int x = -reach; x <= reach; ++x) {
                    const Turn turn = kGridStep * Turn(x, y, z);
                    if (turn.norm() <= options_.reachRadians + 0.5 * kGridStep) turns.push_back({turn, 0});
                }
        tbb::parallel_for(std::size_t{0}, turns.size(), [&](std::size_t i) {
            turns[i].score = edgeScore_.at(matrixOf(turns[i].turn), fewRays_, 0, 1);
        });
        return turns;
    }

    void climbAll(std::vector<Candidate>& climbers, std::size_t end, const std::vector<EdgeRay>& rays,
                  double step) const {
        tbb::parallel_for(std::size_t{0}, climbers.size(), [&](std::size_t i) {
            const Score score = [&](const Turn& turn) { return edgeScore_.at(matrixOf(turn), rays, 0, end); };
            climbers[i] = climb(score, {climbers[i].turn, score(climbers[i].turn)}, step, step / 20);
        });
    }

    /// Efron, "The jackknife, the bootstrap and other resampling plans", 1982: over the parts of the picture, whose
    /// faults (a lens that is not quite known, things that moved) are those of all edges in it.
    double deviationAt(const Turn& found, std::size_t fine) const {
        const double step = 0.7 * sigmaOf(levels_.size() - 1);
        std::array<PartSums, Stencil::kCount> sums;
        for (int k = 0; k < Stencil::kCount; ++k)
            sums[static_cast<std::size_t>(k)] =
                edgeScore_.partsAt(matrixOf(found + Stencil::place(k, step)), partRays_, fine, levels_.size());
        std::vector<Turn> tops;
        for (int part = 0; part < kParts; ++part) {
            if (!hasSay(part)) continue;
            std::array<double, Stencil::kCount> f;
            for (std::size_t k = 0; k < f.size(); ++k)
                f[k] = sums[k].scoreWithout(part);
            const auto top = Stencil::top(f);
            if (!top) return std::numbers::pi;
            tops.push_back(step * *top);
        }
        if (tops.size() < 2) return std::numbers::pi;
        Turn mean = Turn::Zero();
        for (const Turn& top : tops)
            mean += top / static_cast<double>(tops.size());
        double squares = 0;
        for (const Turn& top : tops)
            squares += (top - mean).squaredNorm();
        return std::sqrt(squares * (static_cast<double>(tops.size()) - 1) / static_cast<double>(tops.size()));
    }

    bool hasSay(int part) const { return std::ssize(partRays_[static_cast<std::size_t>(part)]) >= kLeastRaysOfPart; }

    void askParts(const Turn& found, std::size_t fine, ColourFit& fit) const {
        const auto scoresAt = [&](const Turn& turn) {
            const PartSums sums = edgeScore_.partsAt(matrixOf(found + turn), partRays_, fine, levels_.size());
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
        for (int part = 0; part < kParts; ++part) {
            if (!hasSay(part)) continue;
            const auto p = static_cast<std::size_t>(part);
            const auto better =
                std::count_if(others.begin(), others.end(), [&](const auto& scores) { return scores[p] >= best[p]; });
            ++fit.parts;
            agreeing += static_cast<double>(better) <= kMostBetter * static_cast<double>(others.size());
        }
        fit.agreeing = fit.parts > 0 ? static_cast<double>(agreeing) / fit.parts : 0;
    }

    EdgeScore edgeScore_;
    const std::vector<EdgeLevel>& levels_;
    double pixelRadians_;
    std::array<std::vector<EdgeRay>, kParts> partRays_;
    std::vector<EdgeRay> rays_, fewRays_;
    const ColourToRangeOptions& options_;
};

std::array<std::vector<EdgeRay>, kParts> raysOf(const EdgeImage& edges, const Camera& camera) {
    std::array<std::vector<EdgeRay>, kParts> parts;
    // Each part in four by four, so that edges of one window do not stand for all of it.
    for (const EdgePoint& point : edgePoints(edges, 4 * kPartColumns, 4 * kPartRows, kMostRays / (16 * kParts))) {
        const int column = std::min(static_cast<int>(point.x) * kPartColumns / edges.width(), kPartColumns - 1),
                  row = std::min(static_cast<int>(point.y) * kPartRows / edges.height(), kPartRows - 1);
        parts[static_cast<std::size_t>(row * kPartColumns + column)].push_back(
            {glm::vec3(rayThrough(camera, point.x, point.y)), point.strength, point.cosine, point.sine});
    }
    return parts;
}

void judge(ColourFit& fit, const ColourToRangeOptions& options) {
    if (fit.parts < options.leastParts)
        fit.why = "too little of it has edges";
    else if (fit.rivalShare > options.mostRivalShare || !(fit.score > 0))
        fit.why = "other turns fit nearly as well";
    else if (fit.agreeing < options.leastAgreeing)
        fit.why = "most parts of it fit other turns better";
    else if (!(fit.turnedRadians <= options.reachRadians))
        fit.why = "the best turn is beyond what was looked through";
    else if (!(fit.deviationRadians <= options.mostDeviationRadians))
        fit.why = "its edges do not say exactly enough how it is turned";
    fit.isSure = fit.why.empty();
}

} // namespace

glm::dmat3 rotationOf(const glm::dvec3& turn) {
    const double angle = glm::length(turn);
    if (angle < 1e-12) return glm::dmat3(1.0);
    const double half = angle / 2;
    const glm::dvec3 v = turn / angle * std::sin(half);
    return poseFromQuaternion({}, v.x, v.y, v.z, std::cos(half)).rotation;
}

Camera widened(const Camera& camera, double reachRadians, double pixelRadians) {
    const double scaleX = 1 / (pixelRadians * camera.fx), scaleY = 1 / (pixelRadians * camera.fy);
    const auto edge = [&](double tangent) { // of an edge's angle from the axis, turned outwards
        return std::tan(std::min(std::atan(tangent) + 1.1 * reachRadians, 1.45));
    };
    const double corner = std::max(camera.cx, camera.width - camera.cx) / camera.fx; // a roll lifts corners
    const double corner2 = std::max(camera.cy, camera.height - camera.cy) / camera.fy;
    const double left = edge(camera.cx / camera.fx + corner2 * reachRadians),
                 right = edge((camera.width - camera.cx) / camera.fx + corner2 * reachRadians);
    const double up = edge(camera.cy / camera.fy + corner * reachRadians),
                 down = edge((camera.height - camera.cy) / camera.fy + corner * reachRadians);
    Camera wide;
    wide.fx = camera.fx * scaleX, wide.fy = camera.fy * scaleY;
    wide.cx = std::ceil(left * wide.fx), wide.cy = std::ceil(up * wide.fy);
    wide.width = static_cast<int>(wide.cx + std::ceil(right * wide.fx));
    wide.height = static_cast<int>(wide.cy + std::ceil(down * wide.fy));
    return wide;
}

ColourFit findTurn(const DepthImage& scan, const Image<Rgb8>& photograph, const Camera& camera,
                   const ColourToRangeOptions& options) {
    assert(photograph.width() == camera.width && photograph.height() == camera.height);
    const double pixelRadians = 1 / scan.camera.fx;
    const EdgeImage edges = scanEdges(scan);
    std::vector<EdgeLevel> levels;
    for (double sigma = kBroadestSigma / pixelRadians;
         sigma > kFinestSigmaPixels * 1.2 && levels.size() + 1 < kMostLevels; sigma /= 2)
        levels.push_back(blurredEdges(edges, sigma));
    levels.push_back(blurredEdges(edges, kFinestSigmaPixels));
    const Search search(levels, scan.camera, pixelRadians, raysOf(photographEdges(photograph), camera), options);
    ColourFit fit = search.find();
    judge(fit, options);
    return fit;
}

} // namespace scene
