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
constexpr std::size_t kFirstFine = 2;
constexpr double kBroad = 2;                  ///< times a level's sigma: what is taken off
constexpr double kRim = 0.02, kRimSigmas = 2; ///< of the width; of the broad blur. What lies beyond a rim is made up
constexpr double kLeastShared = 0.02;         ///< of the picture
constexpr double kFarthest = 0.035;           ///< radians from the start: beyond it has gone astray
constexpr int kSteps = 8;                     ///< at most, with each further level
constexpr double kStill = 0.01;               ///< of the finest pixel: it moves no more
constexpr int kLeastPixels = 30;              ///< of a part on a level
constexpr double kLeastCorrelation = 0.1;     ///< of a part on a level that has any say
constexpr double kMuch = 0.4;                 ///< correlation of a part that agrees
constexpr double kOutlier = 3;                ///< times the usual residual: things that moved

/// What a part of a level says at a turn, of the residual b - scale * a.
struct Sums {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d slope = Eigen::Vector3d::Zero();
    double aa = 0, ab = 0, bb = 0, squares = 0;
    int count = 0;

    double correlation() const { return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 0; }
    double weight() const {
        const double common = correlation() - kLeastCorrelation;
        return count >= kLeastPixels && common > 0 && squares > 0 ? common * common * count / squares : 0;
    }
};

using LevelSums = std::array<Sums, kParts>;

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
    const double rimA = std::max(kRim * a.camera.width, beside), rimB = std::max(kRim * b.camera.width, beside);
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

/// scale: of a against b. usual: of residuals, as they were before; none yet if it is zero.
LevelSums sumsOf(const GreyLevels& a, const GreyLevels& b, std::size_t level, const glm::dmat3& bFromA, const Box& box,
                 double scale, double usual) {
    LevelSums parts;
    const Image<float>&from = a.levels[level].grey, &to = b.levels[level].grey;
    const double per = 1.0 / b.levels[level].pixelsPerPixel;
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
        // A turn about b's axes moves the ray by turn x ray, and that its place in the picture.
        const double kx = b.camera.fx * per / ray.z * du, ky = b.camera.fy * per / ray.z * dv;
        const double kz = -(kx * ray.x + ky * ray.y) / ray.z;
        const Eigen::Vector3d slope(ray.y * kz - ray.z * ky, ray.z * kx - ray.x * kz, ray.x * ky - ray.y * kx);
        Sums& sums = parts[static_cast<std::size_t>(box.partOf(at))];
        sums.normal += weight * slope * slope.transpose();
        sums.slope += weight * residual * slope;
        sums.aa += grey * grey, sums.ab += grey * seen, sums.bb += seen * seen;
        sums.squares += weight * residual * residual;
        ++sums.count;
    });
    return parts;
}

/// The sums of all levels of one part, each by its say.
struct Equation {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d slope = Eigen::Vector3d::Zero();

    void add(const Sums& sums) {
        const double weight = sums.weight();
        normal += weight * sums.normal, slope += weight * sums.slope;
    }
    std::optional<Turn> step() const {
        const Eigen::LLT<Eigen::Matrix3d> solver(normal);
        if (solver.info() != Eigen::Success || solver.rcond() < 1e-6) return std::nullopt;
        return -solver.solve(slope);
    }
};

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
        return count > kLeastShared * static_cast<double>(a_.levels[1].grey.size());
    }

    enum class Descended { held, open, astray };

    /// With the levels [first, end).
    Descended descend(std::size_t first, std::size_t end) {
        look(first, end); // how much brighter the one is, and how far off they are
        for (int i = 0; i < kSteps; ++i) {
            look(first, end);
            Equation all;
            for (std::size_t level = first; level < end; ++level)
                for (const Sums& sums : said[level])
                    all.add(sums);
            const auto step = all.step();
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
            for (const Sums& sums : said[level])
                aa += sums.aa, bb += sums.bb, squares += sums.squares, count += sums.count;
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
    std::array<Equation, kParts> equations;
    Equation all;
    const auto fine = std::span(descent.said).subspan(kFirstFine);
    for (const LevelSums& level : fine) {
        Sums whole;
        for (std::size_t part = 0; part < level.size(); ++part) {
            equations[part].add(level[part]), all.add(level[part]);
            whole.aa += level[part].aa, whole.ab += level[part].ab, whole.bb += level[part].bb;
        }
        found.correlation = std::max(found.correlation, whole.correlation());
    }
    // Efron's jackknife over the parts, as turn_search.h has it.
    std::vector<Turn> without;
    double shown = 0, agreed = 0;
    for (std::size_t part = 0; part < equations.size(); ++part) {
        double best = 0, deviation = 0;
        for (const LevelSums& level : fine) {
            const Sums& sums = level[part];
            if (sums.count < kLeastPixels) continue;
            best = std::max(best, sums.correlation());
            deviation = std::max(deviation, std::sqrt(sums.bb / sums.count));
        }
        shown += deviation, agreed += best >= kMuch ? deviation : 0, found.parts += best >= kMuch;
        if (!(equations[part].normal.trace() > 0)) continue; // it has no say
        const Equation rest{all.normal - equations[part].normal, all.slope - equations[part].slope};
        const auto step = rest.step();
        if (!step) return std::nullopt;
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
    return found;
}

} // namespace scene
