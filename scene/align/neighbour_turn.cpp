#include "scene/align/neighbour_turn.h"

#include "scene/srgb.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include <Eigen/Dense>
#include <opencv2/imgproc.hpp>

namespace scene {

namespace {

constexpr std::array kSigmas{16, 8, 4, 2, 1}; ///< pixels
/// From this one on levels say where exactly. Broader ones show how surfaces are lit, too, and that looks elsewhere to
/// another lens or another exposure.
constexpr std::size_t kFirstFine = 1;
constexpr double kBroad = 2; ///< times a level's sigma: what is taken off
constexpr double kRimShare = 0.02,
                 kRimSigmas = 2;              ///< of the width; of the broad blur. What lies beyond a rim is made up
constexpr double kLeastSharedArea = 0.02;     ///< of the picture
constexpr double kFarthest = 0.035;           ///< radians from the start: beyond it has gone astray
constexpr int kSteps = 8;                     ///< at most, with each further level
constexpr double kStill = 0.01;               ///< of the finest pixel: it moves no more
constexpr int kLeastPixels = 30;              ///< of a part on a level
constexpr double kLeastPartCorrelation = 0.1; ///< of a part on a level that has any say
/// Of the slopes along a direction, what both pictures must have in common for it to be held.
constexpr double kLeastCommonSlope = 0.1;
constexpr double kByChance = 4;  ///< over the root of how many pixels: noise has so much in common, being blurred
constexpr double kOpen = 0.0175; ///< radians: what is not held may be anywhere within what is looked through
/// Deviations over those of the jackknife, whose parts are few and unlike: of 1164 pairs of simulated
/// photographs 95 % are then off by no more than is said of so many.
constexpr double kFewParts = 1.5;
constexpr double kMuch = 0.4;  ///< correlation of a part that agrees
constexpr double kOutlier = 3; ///< times the usual residual: things that moved

/// How b's grey changes with the turn, so a's; and the residual b - scale * a. b's noise has slopes, too, that hold a
/// turn where it is, and are not to be told from edges by one picture. But a's noise is another: what the slopes of
/// both have in common is of what both see (instrumental variables: Reiersol, "Confluence analysis by means of
/// instrumental sets of variables", 1945, with a's slopes as instruments).
struct SlopeSums {
    Eigen::Matrix3d common = Eigen::Matrix3d::Zero();   ///< of a's slopes with b's
    Eigen::Matrix3d separate = Eigen::Matrix3d::Zero(); ///< of each with itself, the mean of both
    Eigen::Vector3d slope = Eigen::Vector3d::Zero();    ///< of a's slopes with the residual
    int count = 0;                                      ///< pixels

    void add(const SlopeSums& other, double weight) {
        common += weight * other.common, separate += weight * other.separate, slope += weight * other.slope;
        if (weight > 0) count += other.count;
    }
    /// Less one that was added, with its weight in it.
    SlopeSums without(const SlopeSums& part) const {
        return {common - part.common, separate - part.separate, slope - part.slope, count - part.count};
    }
};

/// What a part of a level says at a turn.
struct CorrelationSums {
    SlopeSums slopes;
    double aa = 0, ab = 0, bb = 0, squares = 0;

    double correlation() const { return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 0; }
    double weight() const {
        const double common = correlation() - kLeastPartCorrelation;
        return slopes.count >= kLeastPixels && common > 0 && squares > 0 ? common * common * slopes.count / squares : 0;
    }
};

using LevelSums = std::array<CorrelationSums, kParts>;

struct Box {
    double left = 1e9, right = -1e9, top = 1e9, bottom = -1e9;

    void hold(const glm::dvec2& at) {
        left = std::min(left, at.x), right = std::max(right, at.x);
        top = std::min(top, at.y), bottom = std::max(bottom, at.y);
    }
    int partOf(const glm::dvec2& at) const {
        return pieceOf(at.y, top, bottom, kPartRows) * kPartColumns + pieceOf(at.x, left, right, kPartColumns);
    }
};

bool isInside(const Camera& camera, double rim, double x, double y) {
    return x > rim && y > rim && x < camera.width - rim && y < camera.height - rim;
}

/// Calls with each pixel of a's level that both see: its place there, and in b's full picture with the ray to it.
template <class Function>
void forShared(const GreyLevels& a, const GreyLevels& b, std::size_t level, const glm::dmat3& bFromA,
               const Function& function) {
    const GreyLevel& from = a.levels[level];
    const int n = from.pixelsPerPixel;
    const double beside = kRimSigmas * kBroad * kSigmas[level];
    const double rimA = std::max(kRimShare * a.camera.width, beside),
                 rimB = std::max(kRimShare * b.camera.width, beside);
    for (int y = 0; y < from.grey.height(); ++y)
        for (int x = 0; x < from.grey.width(); ++x) {
            const double u = (x + 0.5) * n, v = (y + 0.5) * n;
            if (!isInside(a.camera, rimA, u, v)) continue;
            const glm::dvec3 ray = bFromA * rayThrough(a.camera, u, v);
            if (!(ray.z > 0.1)) continue;
            const glm::dvec2 at = project(b.camera, ray);
            if (isInside(b.camera, rimB, at.x, at.y)) function(x, y, ray, at);
        }
}

/// How the grey along a ray changes with a turn about the camera's axes; du, dv: with the place in a level's picture.
/// The turn moves the ray by turn x ray, and that its place.
Eigen::Vector3d slopeOf(const Camera& camera, double per, const glm::dvec3& ray, double du, double dv) {
    const double kx = camera.fx * per / ray.z * du, ky = camera.fy * per / ray.z * dv;
    const double kz = -(kx * ray.x + ky * ray.y) / ray.z;
    return {ray.y * kz - ray.z * ky, ray.z * kx - ray.x * kz, ray.x * ky - ray.y * kx};
}

/// scale: of a against b. usual: of residuals, as they were before; none yet if it is zero.
LevelSums sumsOf(const GreyLevels& a, const GreyLevels& b, std::size_t level, const glm::dmat3& bFromA, const Box& box,
                 double scale, double usual) {
    LevelSums parts;
    const Image<float>&from = a.levels[level].grey, &to = b.levels[level].grey;
    const double per = 1.0 / b.levels[level].pixelsPerPixel;
    const glm::dmat3 aFromB = glm::transpose(bFromA);
    const Eigen::Matrix3d toB = eigenOf(bFromA);
    forShared(a, b, level, bFromA, [&](int x, int y, const glm::dvec3& ray, const glm::dvec2& at) {
        const double u = at.x * per - 0.5, v = at.y * per - 0.5;
        const int i = static_cast<int>(u), j = static_cast<int>(v);
        if (!(u >= 0 && v >= 0) || i + 1 >= to.width() || j + 1 >= to.height()) return;
        const double p = u - i, q = v - j;
        const auto f = [&](int di, int dj) { return static_cast<double>(to(i + di, j + dj)); };
        const double upper = (1 - p) * f(0, 0) + p * f(1, 0), lower = (1 - p) * f(0, 1) + p * f(1, 1);
        const double seen = (1 - q) * upper + q * lower;
        const double du = (1 - q) * (f(1, 0) - f(0, 0)) + q * (f(1, 1) - f(0, 1)), dv = lower - upper;
        const double grey = static_cast<double>(from(x, y)), residual = seen - scale * grey;
        const double times = residual / (kOutlier * usual);
        const double weight = usual > 0 ? 1 / (1 + times * times) : 1;
        const Eigen::Vector3d slopeB = slopeOf(b.camera, per, ray, du, dv);
        const int left = std::max(x - 1, 0), right = std::min(x + 1, from.width() - 1);
        const int above = std::max(y - 1, 0), below = std::min(y + 1, from.height() - 1);
        const double dx = static_cast<double>(from(right, y) - from(left, y)) / (right - left),
                     dy = static_cast<double>(from(x, below) - from(x, above)) / (below - above);
        const Eigen::Vector3d slopeA =
            scale * (toB * slopeOf(a.camera, 1.0 / a.levels[level].pixelsPerPixel, aFromB * ray, dx, dy));
        CorrelationSums& sums = parts[static_cast<std::size_t>(box.partOf(at))];
        sums.slopes.common += weight * slopeA * slopeB.transpose();
        sums.slopes.separate += 0.5 * weight * (slopeA * slopeA.transpose() + slopeB * slopeB.transpose());
        sums.slopes.slope += weight * residual * slopeA;
        sums.aa += grey * grey, sums.ab += grey * seen, sums.bb += seen * seen;
        sums.squares += weight * residual * residual;
        ++sums.slopes.count;
    });
    return parts;
}

using Axes = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 3>; ///< in columns

/// Turns by how much both pictures show them alike, ascending: axes along which slopes are as great as one and have
/// nothing to do with each other, and the share of them that is common.
struct Shares {
    Axes axes;
    Eigen::VectorXd shares;
};

/// Within the space of some orthonormal axes; nothing where one of them has no slopes.
std::optional<Shares> sharesOf(const SlopeSums& sums, const Axes& within) {
    const Eigen::MatrixXd common = 0.5 * within.transpose() * (sums.common + sums.common.transpose()) * within,
                          separate = within.transpose() * sums.separate * within;
    if (!(separate.determinant() > 0)) return std::nullopt;
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(common, separate);
    if (solver.info() != Eigen::Success) return std::nullopt;
    return Shares{within * solver.eigenvectors(), solver.eigenvalues()};
}

/// The turns that both pictures show alike, and the one they do not: along edges that all run one way nothing is known.
struct Directions {
    Axes held = Eigen::Matrix3d::Identity();        ///< orthonormal
    Eigen::Matrix3d open = Eigen::Matrix3d::Zero(); ///< covariance of the other
    double least = 0;                               ///< share in common at which a direction is held
};

/// Nothing where two directions are open.
std::optional<Directions> directionsOf(const SlopeSums& sums) {
    Directions directions;
    directions.least = std::max(kLeastCommonSlope, kByChance / std::sqrt(static_cast<double>(sums.count)));
    const auto all = sharesOf(sums, directions.held);
    if (!all) return std::nullopt;
    if (all->shares[0] >= directions.least) return directions;
    // The others of these axes may lie close to the open one, where moving costs little.
    const Eigen::Vector3d axis = all->axes.col(0).normalized();
    directions.open = kOpen * kOpen * axis * axis.transpose();
    directions.held.resize(3, 2);
    directions.held.col(0) = axis.unitOrthogonal();
    directions.held.col(1) = axis.cross(directions.held.col(0));
    const auto others = sharesOf(sums, directions.held);
    if (!others || others->shares[0] < directions.least) return std::nullopt;
    return directions;
}

/// The step that takes the residuals away, within what is held. What is held the less without some part of the
/// picture is taken for held as little as is just allowed.
std::optional<Turn> stepOf(const SlopeSums& sums, const Directions& directions) {
    const auto within = sharesOf(sums, directions.held);
    if (!within) return std::nullopt;
    const Eigen::VectorXd along = within->axes.transpose() * sums.slope;
    return Turn(-within->axes * along.cwiseQuotient(within->shares.cwiseMax(directions.least)));
}

class Descent {
  public:
    Descent(const GreyLevels& a, const GreyLevels& b, const glm::dmat3& bFromA, const Turn& start)
        : turn(start), a_(a), b_(b), bFromA_(bFromA), start_(start) {
        scales_.fill(1);
    }

    bool sharesEnough() {
        int count = 0;
        forShared(a_, b_, 1, matrixOf(turn) * bFromA_, [&](int, int, const glm::dvec3&, const glm::dvec2& at) {
            box_.hold(at);
            ++count;
        });
        return count > kLeastSharedArea * static_cast<double>(a_.levels[1].grey.size());
    }

    enum class Descended { held, open, astray };

    /// With the levels [first, end).
    Descended descend(std::size_t first, std::size_t end) {
        look(first, end); // how much brighter the one is, and how far off they are
        for (int i = 0; i < kSteps; ++i) {
            look(first, end);
            SlopeSums all;
            for (std::size_t level = first; level < end; ++level)
                for (const CorrelationSums& sums : said[level])
                    all.add(sums.slopes, sums.weight());
            const auto directions = directionsOf(all);
            if (!directions) return Descended::open;
            const auto step = stepOf(all, *directions);
            if (!step) return Descended::open;
            turn += *step;
            if ((turn - start_).norm() > kFarthest) return Descended::astray;
            if (step->norm() * b_.camera.fx < kStill * b_.levels[end - 1].pixelsPerPixel) break;
        }
        return Descended::held;
    }

    /// Asks the levels [first, end) anew, where it is.
    void look(std::size_t first, std::size_t end) {
        for (std::size_t level = first; level < end; ++level) {
            said[level] = sumsOf(a_, b_, level, matrixOf(turn) * bFromA_, box_, scales_[level], usual_[level]);
            double aa = 0, bb = 0, squares = 0, count = 0;
            for (const CorrelationSums& sums : said[level])
                aa += sums.aa, bb += sums.bb, squares += sums.squares, count += sums.slopes.count;
            // Of two pictures with the same noise neither is the truth.
            if (aa > 0 && bb > 0) scales_[level] = std::sqrt(bb / aa);
            if (count > 0) usual_[level] = std::sqrt(squares / count);
        }
    }

    Turn turn;
    std::array<LevelSums, kSigmas.size()> said; ///< when they were asked last

  private:
    const GreyLevels &a_, &b_;
    glm::dmat3 bFromA_;
    Turn start_;
    Box box_;
    std::array<double, kSigmas.size()> scales_{}, usual_{};
};

} // namespace

GreyLevels greyLevels(const SmallPhotograph& photograph) {
    const Image<Rgb8>& picture = photograph.picture;
    cv::Mat1f grey(picture.height(), picture.width());
    for (int y = 0; y < grey.rows; ++y)
        for (int x = 0; x < grey.cols; ++x) {
            // In linear light another exposure is a factor.
            const Rgb8& c = picture(x, y);
            grey(y, x) = 255 * (0.25f * linearFromSrgb(c.r) + 0.5f * linearFromSrgb(c.g) + 0.25f * linearFromSrgb(c.b));
        }
    GreyLevels levels;
    levels.camera = photograph.camera;
    for (const int sigma : kSigmas) {
        GreyLevel level;
        level.pixelsPerPixel = std::min({sigma, grey.rows, grey.cols});
        const int n = level.pixelsPerPixel;
        cv::Mat1f small = grey, fine, broad;
        if (n > 1) {
            // Whole pixels: the rest at the right and lower rim is left out.
            const cv::Rect whole(0, 0, grey.cols / n * n, grey.rows / n * n);
            cv::resize(grey(whole), small, {}, 1.0 / n, 1.0 / n, cv::INTER_AREA);
        }
        cv::GaussianBlur(small, fine, {}, static_cast<double>(sigma) / n);
        cv::GaussianBlur(small, broad, {}, kBroad * sigma / n);
        fine -= broad;
        level.grey = Image<float>(fine.cols, fine.rows);
        for (int y = 0; y < fine.rows; ++y)
            std::copy_n(fine.ptr<float>(y), fine.cols, level.grey.row(y).data());
        levels.levels.push_back(std::move(level));
    }
    return levels;
}

std::optional<NeighbourTurn> layOnNeighbour(const GreyLevels& a, const GreyLevels& b, const glm::dmat3& bFromA,
                                            const Turn& start) {
    Descent descent(a, b, bFromA, start);
    if (!descent.sharesEnough()) return std::nullopt;
    using Descended = Descent::Descended;
    for (std::size_t end = 1; end <= kSigmas.size(); ++end) // coarse levels alone need not hold it
        if (descent.descend(0, end) == Descended::astray) return std::nullopt;
    if (descent.descend(kFirstFine, kSigmas.size()) != Descended::held) return std::nullopt;
    descent.look(kFirstFine, kSigmas.size());

    NeighbourTurn found;
    found.turn = descent.turn;
    std::array<SlopeSums, kParts> slopes;
    SlopeSums all;
    const auto fine = std::span(descent.said).subspan(kFirstFine);
    for (const LevelSums& level : fine) {
        CorrelationSums whole;
        for (std::size_t part = 0; part < level.size(); ++part) {
            const double weight = level[part].weight();
            slopes[part].add(level[part].slopes, weight), all.add(level[part].slopes, weight);
            whole.aa += level[part].aa, whole.ab += level[part].ab, whole.bb += level[part].bb;
        }
        found.correlation = std::max(found.correlation, whole.correlation());
    }
    const auto directions = directionsOf(all);
    if (!directions) return std::nullopt;
    // Efron's jackknife over the parts, as turn_search.h has it.
    std::vector<Turn> without;
    double shown = 0, agreed = 0;
    for (std::size_t part = 0; part < slopes.size(); ++part) {
        double best = 0, deviation = 0;
        for (const LevelSums& level : fine) {
            const CorrelationSums& sums = level[part];
            if (sums.slopes.count < kLeastPixels) continue;
            best = std::max(best, sums.correlation());
            deviation = std::max(deviation, std::sqrt(sums.bb / sums.slopes.count));
        }
        shown += deviation, agreed += best >= kMuch ? deviation : 0, found.parts += best >= kMuch;
        if (!(slopes[part].separate.trace() > 0)) continue; // it has no say
        const auto step = stepOf(all.without(slopes[part]), *directions);
        if (!step) return std::nullopt; // one part says it all
        without.push_back(*step);
    }
    if (without.size() < 2 || !(shown > 0)) return std::nullopt;
    found.agreeing = agreed / shown;
    const auto count = static_cast<double>(without.size());
    Turn mean = Turn::Zero();
    for (const Turn& turn : without)
        mean += turn / count;
    found.covariance = mean * mean.transpose(); // what is left to go, if anything
    for (const Turn& turn : without)
        found.covariance += (turn - mean) * (turn - mean).transpose() * ((count - 1) / count);
    found.covariance *= kFewParts * kFewParts;
    found.covariance += directions->open;
    return found;
}

} // namespace scene
