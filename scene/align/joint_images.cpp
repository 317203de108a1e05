#include "scene/align/joint_images.h"

#include "scene/align/image_pairs.h"
#include "scene/align/normal_equations.h"
#include "scene/median.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/SparseCore>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <tbb/parallel_for.h>

namespace scene {

namespace {

using Indices = std::vector<std::uint32_t>;

constexpr int kRounds = 8;              ///< as often strayed images are taken out,
constexpr int kPatientRounds = 5;       ///< so often the worst of them first
constexpr double kDeviations = 3;       ///< of the residuals: what is farther off counts less
constexpr double kPerMedian = 1.4826;   ///< a normal distribution's deviation, over its median size
constexpr double kSharpestRange = 3e-4; ///< deviations that are never believed to be less: of the range,
constexpr double kSharpestGrey = 5e-3;  ///< of light
constexpr double kWorse = 1.02;         ///< times as far apart, or as few that agree: chance makes no more of it
constexpr double kChance = 1e-3;        ///< share of samples that may speak against by chance
constexpr double kLeftAlone = 0.7;      ///< of the samples that agreed, an image that kept fewer has strayed
constexpr double kNearWorst = 0.9;      ///< of the worst share that speaks against an image; and where there are so
constexpr double kHalfWorst = 0.5;      ///< many wrong ones that there would be no end
constexpr double kLoosePixels = 0.25, kLooseShare = 0.2; ///< of the sketch; of how far images move
constexpr double kStillPixels = 0.01;                    ///< of the level: passes end
constexpr int kGridColumns = 8, kGridRows = 6;           ///< samples by which motion is told in pixels
constexpr double kMostPairs = 0.95;                      ///< 19 of 20

struct Problem {
    const std::vector<ImageSketch>& sketches;
    const JointImagesOptions& options;
    std::vector<Indices> partners;
    std::vector<std::uint8_t> isFree;
    std::vector<double> ranges; ///< of each image's samples, the middle one; 0 without any
    glm::dvec3 pivot{0};
};

/// Those that see much of an image and those that see little: the former hold it exactly, the latter keep errors from
/// adding up along the way.
Indices spreadOver(const std::vector<Partner>& partners, int most, const std::vector<std::uint8_t>& isAsked) {
    Indices asked, chosen;
    for (const Partner& partner : partners)
        if (isAsked[partner.image]) asked.push_back(partner.image);
    const std::size_t count = std::min(asked.size(), static_cast<std::size_t>(most));
    for (std::size_t i = 0; i < count; ++i)
        chosen.push_back(asked[i * asked.size() / count]);
    return chosen;
}

double middleRange(const DepthImage& image) {
    std::vector<float> disparities;
    for (std::size_t i = 0; i < image.flags.size(); i += 7)
        if (isSurface(image.flags.pixels()[i])) disparities.push_back(image.disparity.pixels()[i]);
    if (disparities.empty()) return 0;
    return 1 / static_cast<double>(medianOf(disparities));
}

struct AllSums {
    std::vector<std::vector<ImagePairSums>> ofPairs; ///< image by image, partner by partner
    ResidualSizes sizes;
};

AllSums compareAll(const Problem& problem, const std::vector<Pose>& poses, std::size_t level,
                   const ResidualScales& scales) {
    AllSums all;
    all.ofPairs.resize(poses.size());
    std::vector<ResidualSizes> sizes(poses.size());
    tbb::parallel_for(std::size_t{0}, poses.size(), [&](std::size_t i) {
        const Camera& camera = problem.sketches[i].depth.camera;
        const double pixels = static_cast<double>(camera.width) * camera.height;
        const int step = std::max(1, static_cast<int>(std::sqrt(pixels / problem.options.samplesPerPair)));
        SampleComparison samples = samplesOf(problem.sketches[i], step);
        for (const std::uint32_t other : problem.partners[i])
            all.ofPairs[i].push_back(comparePair(problem.sketches[i], samples, poses[i], problem.sketches[other],
                                                 poses[other], problem.pivot,
                                                 {level, problem.options.comparison, scales}, sizes[i]));
    });
    for (const ResidualSizes& some : sizes)
        all.sizes.range.add(some.range), all.sizes.grey.add(some.grey);
    return all;
}

ResidualScales scalesOf(const AllSums& all) {
    return {std::max(kSharpestRange, kDeviations * kPerMedian * all.sizes.range.median()),
            std::max(kSharpestGrey, kDeviations * kPerMedian * all.sizes.grey.median())};
}

/// What the pairs of an image say of it.
struct Say {
    std::int64_t agreeing = 0, against = 0; ///< samples
    double againstShare() const {
        return against > 0 ? static_cast<double>(against) / static_cast<double>(agreeing + against) : 0;
    }
    void add(const ImagePairSums& pair) { agreeing += pair.agreeing, against += pair.against; }
};

Apartness apartnessOf(const AllSums& all) {
    Say say;
    for (const auto& pairs : all.ofPairs)
        for (const ImagePairSums& pair : pairs)
            say.add(pair);
    return {all.sizes.range.median(), all.sizes.grey.median(), say.againstShare(), say.agreeing};
}

/// The pose moved by a translation and a turn about the pivot, radians.
Pose moved(const Pose& pose, const glm::dvec3& pivot, const Eigen::Matrix<double, 6, 1>& by) {
    const Eigen::Vector3d turn = by.tail<3>();
    const double angle = turn.norm();
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
    if (angle > 0) rotation = Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
    glm::dmat3 r(1);
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
            r[column][row] = rotation(row, column);
    return {r * pose.rotation, r * (pose.translation - pivot) + pivot + glm::dvec3(by[0], by[1], by[2])};
}

/// One step of all free images; returns how far the farthest moved, in pixels of its sketch.
double step(const Problem& problem, const AllSums& all, std::vector<Pose>& poses) {
    Indices row(poses.size(), 0);
    int rows = 0;
    for (std::size_t i = 0; i < poses.size(); ++i)
        if (problem.isFree[i]) row[i] = static_cast<std::uint32_t>(rows++);
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::VectorXd right = Eigen::VectorXd::Zero(6 * rows);
    const auto put = [&](std::size_t a, std::size_t b, const Eigen::Matrix<double, 6, 6>& block) {
        for (int c = 0; c < 6; ++c)
            for (int r = 0; r < 6; ++r)
                entries.emplace_back(static_cast<int>(6 * row[a]) + r, static_cast<int>(6 * row[b]) + c, block(r, c));
    };
    for (std::size_t i = 0; i < poses.size(); ++i) {
        if (problem.isFree[i]) {
            const double turn = 1 / problem.options.damping, way = turn / std::max(problem.ranges[i], 1e-6);
            Eigen::Matrix<double, 6, 1> damping;
            damping << way, way, way, turn, turn, turn;
            put(i, i, damping.cwiseAbs2().asDiagonal());
        }
        for (std::size_t k = 0; k < problem.partners[i].size(); ++k) {
            const ImagePairSums& pair = all.ofPairs[i][k];
            const std::size_t j = problem.partners[i][k];
            if (pair.agreeing < problem.options.leastAgreeing) continue;
            const Eigen::Matrix<double, 6, 6> square = pair.square.selfadjointView<Eigen::Lower>();
            if (problem.isFree[i]) put(i, i, square), right.segment<6>(6 * row[i]) -= pair.slope;
            if (problem.isFree[j]) put(j, j, square), right.segment<6>(6 * row[j]) += pair.slope;
            if (problem.isFree[i] && problem.isFree[j]) put(i, j, -square), put(j, i, -square);
        }
    }
    Eigen::SparseMatrix<double> matrix(6 * rows, 6 * rows);
    matrix.setFromTriplets(entries.begin(), entries.end());
    const Eigen::VectorXd by = solveNormalEquations(matrix, right);
    double farthest = 0;
    for (std::size_t i = 0; i < poses.size(); ++i) {
        if (!problem.isFree[i]) continue;
        const Pose before = poses[i];
        poses[i] = moved(before, problem.pivot, by.segment<6>(6 * row[i]));
        const double way = glm::length(poses[i].translation - before.translation) / std::max(problem.ranges[i], 1e-6);
        farthest = std::max(farthest,
                            problem.sketches[i].depth.camera.fx * std::max(way, by.segment<3>(6 * row[i] + 3).norm()));
    }
    return farthest;
}

void settle(const Problem& problem, std::vector<Pose>& poses, const std::function<void()>& onPass) {
    const std::size_t levels = problem.sketches.front().greys.size();
    for (std::size_t level = levels; level-- > 0;) {
        ResidualScales scales = scalesOf(compareAll(problem, poses, level, {}));
        double farthest = 1e9;
        for (int pass = 0; pass < problem.options.passes; ++pass) {
            if (farthest > kStillPixels * static_cast<double>(1 << level)) {
                const AllSums all = compareAll(problem, poses, level, scales);
                scales = scalesOf(all);
                farthest = step(problem, all, poses);
            }
            if (onPass) onPass();
        }
    }
}

bool isInside(const Camera& camera, float u, float v) {
    return u >= 0 && v >= 0 && u <= static_cast<float>(camera.width) && v <= static_cast<float>(camera.height);
}

/// How far samples of a are seen elsewhere in b than they were: root mean squares, pixels of the sketch; nothing if
/// none are seen there.
std::optional<double> pixelsMoved(const DepthImage& a, const DepthImage& b, const Reprojection& then,
                                  const Reprojection& now) {
    double squares = 0;
    int count = 0;
    for (int row = 0; row < kGridRows; ++row)
        for (int column = 0; column < kGridColumns; ++column) {
            const int x = (2 * column + 1) * a.camera.width / (2 * kGridColumns);
            const int y = (2 * row + 1) * a.camera.height / (2 * kGridRows);
            if (!isSurface(a.flags(x, y))) continue;
            const float u = static_cast<float>(x) + 0.5f, v = static_cast<float>(y) + 0.5f;
            const Sighting was = sightingOf(then, u, v, a.disparity(x, y));
            const Sighting is = sightingOf(now, u, v, a.disparity(x, y));
            if (!(was.w > 0) || !(is.w > 0) || !isInside(b.camera, was.u, was.v)) continue;
            squares += std::pow(static_cast<double>(is.u - was.u), 2) + std::pow(static_cast<double>(is.v - was.v), 2);
            ++count;
        }
    if (count == 0) return std::nullopt;
    return std::sqrt(squares / count);
}

/// How far pairs moved: each, and those of each image. An image that alone was wrong has moved against all it has a
/// pair with; its neighbours only against it.
struct Moves {
    std::vector<double> all;
    std::vector<std::vector<double>> ofImages;

    double most() const {
        if (all.empty()) return 0;
        std::vector<double> sorted = all;
        const auto at = sorted.begin() + static_cast<std::ptrdiff_t>(kMostPairs * static_cast<double>(all.size() - 1));
        std::nth_element(sorted.begin(), at, sorted.end());
        return *at;
    }
    double ofImage(std::size_t i) const {
        // The lower of two middle ones: of two partners one may be wrong.
        std::vector<double> own = ofImages[i];
        if (own.empty()) return 0;
        const auto middle = own.begin() + (std::ssize(own) - 1) / 2;
        std::nth_element(own.begin(), middle, own.end());
        return *middle;
    }
};

Moves movesOf(const Problem& problem, const std::vector<Pose>& before, const std::vector<Pose>& after) {
    Moves moves;
    moves.ofImages.resize(before.size());
    for (std::size_t i = 0; i < before.size(); ++i)
        for (const std::uint32_t other : problem.partners[i]) {
            const DepthImage &a = problem.sketches[i].depth, &b = problem.sketches[other].depth;
            const std::optional<double> move =
                pixelsMoved(a, b, reprojectionInto(b.camera, before[other], a.camera, before[i]),
                            reprojectionInto(b.camera, after[other], a.camera, after[i]));
            if (!move) continue;
            moves.all.push_back(*move);
            moves.ofImages[i].push_back(*move);
            moves.ofImages[other].push_back(*move);
        }
    return moves;
}

std::vector<Say> saysOf(const AllSums& all) {
    std::vector<Say> says(all.ofPairs.size());
    for (std::size_t i = 0; i < says.size(); ++i)
        for (const ImagePairSums& pair : all.ofPairs[i])
            says[i].add(pair);
    return says;
}

bool wentTooFar(const Problem& problem, std::size_t i, const Pose& given, const Pose& found) {
    const double most = problem.options.mostMoved;
    return glm::length(found.translation - given.translation) > most * problem.ranges[i] ||
           cosineBetween(given.rotation, found.rotation) < std::cos(most);
}

/// Free images that went too far, away from the others, or stand where others saw through them; of the last kind the
/// worst alone (nearWorst: down to this share of the worst), since one makes its neighbours look wrong, too.
Indices strayed(const Problem& problem, const std::vector<Pose>& given, const std::vector<Pose>& found,
                const AllSums& before, const AllSums& after, double nearWorst) {
    const std::vector<Say> then = saysOf(before), now = saysOf(after);
    double most = problem.options.mostAgainst;
    for (std::size_t i = 0; i < now.size(); ++i)
        if (problem.isFree[i]) most = std::max(most, nearWorst * now[i].againstShare());
    Indices result;
    for (std::size_t i = 0; i < now.size(); ++i) {
        const bool isAway = static_cast<double>(now[i].agreeing) < kLeftAlone * static_cast<double>(then[i].agreeing);
        if (problem.isFree[i] && (isAway || now[i].againstShare() > most || wentTooFar(problem, i, given[i], found[i])))
            result.push_back(static_cast<std::uint32_t>(i));
    }
    return result;
}

/// How far an image itself has moved, pixels of its sketch.
double ownMove(const Problem& problem, std::size_t i, const Pose& given, const Pose& found) {
    const double way = glm::length(found.translation - given.translation) / std::max(problem.ranges[i], 1e-6);
    const double turn = std::acos(std::clamp(cosineBetween(found.rotation, given.rotation), -1.0, 1.0));
    return problem.sketches[i].depth.camera.fx * std::max(way, turn);
}

/// How exactly each free image is held by those about it, were they right: the deviation along the motion that is known
/// least, pixels of its sketch.
std::vector<double> deviationsOf(const Problem& problem, const std::vector<Pose>& poses, const AllSums& all) {
    using Square = Eigen::Matrix<double, 6, 6>;
    std::vector<Square> squares(poses.size(), Square::Zero());
    for (std::size_t i = 0; i < poses.size(); ++i)
        for (std::size_t k = 0; k < problem.partners[i].size(); ++k) {
            const ImagePairSums& pair = all.ofPairs[i][k];
            if (pair.agreeing < problem.options.leastAgreeing) continue;
            const Square square = pair.square.selfadjointView<Eigen::Lower>();
            squares[i] += square, squares[problem.partners[i][k]] += square;
        }
    std::vector<double> deviations(poses.size(), 0);
    for (std::size_t i = 0; i < poses.size(); ++i) {
        if (!problem.isFree[i]) continue;
        // Turns about the image's own place, and all in pixels.
        const glm::dvec3 arm = poses[i].translation - problem.pivot;
        Square about = Square::Identity();
        about.block<3, 3>(0, 3) << 0, -arm.z, arm.y, arm.z, 0, -arm.x, -arm.y, arm.x, 0;
        Eigen::Matrix<double, 6, 1> perPixel;
        perPixel << Eigen::Vector3d::Constant(problem.ranges[i]), Eigen::Vector3d::Ones();
        about = about * (perPixel / problem.sketches[i].depth.camera.fx).asDiagonal();
        const Square square = about.transpose() * squares[i] * about;
        const double least = Eigen::SelfAdjointEigenSolver<Square>(square, Eigen::EigenvaluesOnly).eigenvalues()[0];
        deviations[i] = 1 / std::sqrt(std::max(least, 1e-12));
    }
    return deviations;
}

/// Free images that nothing holds, for how far images moved: they would go where noise takes them.
Indices loose(const Problem& problem, const std::vector<Pose>& given, const std::vector<Pose>& found,
              const AllSums& after) {
    const std::vector<double> deviations = deviationsOf(problem, found, after);
    std::vector<double> moves;
    for (std::size_t i = 0; i < given.size(); ++i)
        if (problem.isFree[i]) moves.push_back(ownMove(problem, i, given[i], found[i]));
    const double most = std::max(kLoosePixels, kLooseShare * medianOf(moves));
    Indices result;
    for (std::size_t i = 0; i < given.size(); ++i)
        if (problem.isFree[i] && deviations[i] > most) result.push_back(static_cast<std::uint32_t>(i));
    return result;
}

/// Takes images out that strayed, or that nothing holds, and begins anew without them; those that are free at the end
/// have their places.
std::vector<Pose> placed(Problem& problem, const std::vector<Pose>& given, JointImages& result,
                         const std::function<void()>& onPass) {
    for (int round = 0; round < kRounds; ++round) {
        const AllSums before = compareAll(problem, given, 0, {});
        std::vector<Pose> found = given;
        settle(problem, found, round == 0 ? onPass : std::function<void()>());
        const AllSums after = compareAll(problem, found, 0, scalesOf(compareAll(problem, found, 0, {})));
        result.before = apartnessOf(before);
        result.after = apartnessOf(after);
        ImagePlace place = ImagePlace::strayed;
        Indices out = strayed(problem, given, found, before, after, round < kPatientRounds ? kNearWorst : kHalfWorst);
        if (out.empty()) place = ImagePlace::loose, out = loose(problem, given, found, after);
        if (out.empty()) return found;
        for (const std::uint32_t i : out) {
            result.places[i] = place;
            problem.isFree[i] = 0, problem.partners[i].clear();
            for (Indices& partners : problem.partners)
                std::erase(partners, i);
        }
    }
    result.isWorse = true;
    return given;
}

/// Better in one way, and worse in none.
bool isBetter(const Apartness& before, const Apartness& after) {
    const auto isLess = [](double a, double b, double least) { return kWorse * a < b && b > least; };
    const bool isWorse = isLess(before.range, after.range, kSharpestRange) ||
                         isLess(before.grey, after.grey, kSharpestGrey) ||
                         after.against > kWorse * before.against + kChance ||
                         kWorse * static_cast<double>(after.agreeing) < static_cast<double>(before.agreeing);
    return !isWorse &&
           (isLess(after.range, before.range, kSharpestRange) || isLess(after.grey, before.grey, kSharpestGrey) ||
            after.against + kChance < before.against / kWorse);
}

void accept(const Problem& problem, const std::vector<Pose>& found, JointImages& result) {
    for (std::size_t i = 0; i < found.size(); ++i)
        if (problem.isFree[i]) result.worldFromCameras[i] = found[i], result.places[i] = ImagePlace::adjusted;
}

/// The same with these alone free, and no pairs but theirs.
Problem onlyPairsOf(Problem problem, const std::vector<std::uint8_t>& isAsked) {
    for (std::size_t i = 0; i < isAsked.size(); ++i) {
        problem.isFree[i] = problem.isFree[i] && isAsked[i];
        if (!isAsked[i]) std::erase_if(problem.partners[i], [&](std::uint32_t other) { return !isAsked[other]; });
    }
    return problem;
}

/// Lays those that are free on the others, which stay. isRight: the others were found to be right; an image then stays
/// where it was said to be unless it moves by pixels and fits better afterwards, each judged by itself.
void layOnTheRest(Problem problem, int shrink, bool isRight, JointImages& result) {
    if (std::count(problem.isFree.begin(), problem.isFree.end(), 1) == 0) return;
    const std::vector<Pose> led = result.worldFromCameras;
    const std::vector<Pose> found = placed(problem, led, result, {});
    if (std::exchange(result.isWorse, false)) return;
    const Moves moves = movesOf(problem, led, found);
    std::vector<std::uint8_t> isAccepted = problem.isFree;
    for (std::size_t i = 0; i < found.size() && isRight; ++i) {
        if (!problem.isFree[i]) continue;
        std::vector<std::uint8_t> isAlone(found.size(), 0);
        isAlone[i] = 1;
        std::vector<Pose> then = led;
        then[i] = found[i];
        const Problem alone = onlyPairsOf(problem, isAlone);
        isAccepted[i] =
            shrink * moves.ofImage(i) >= problem.options.leastPixels &&
            isBetter(apartnessOf(compareAll(alone, led, 0, {})), apartnessOf(compareAll(alone, then, 0, {})));
    }
    problem.isFree = isAccepted;
    accept(problem, found, result);
}

} // namespace

JointImages layImagesOnEachOther(const std::vector<ImageSketch>& sketches, int shrink,
                                 const std::vector<std::vector<Partner>>& partners,
                                 const std::vector<std::uint8_t>& isFollower, const JointImagesOptions& options,
                                 const std::function<void()>& onPass) {
    JointImages result;
    const std::size_t count = sketches.size();
    std::vector<Pose> given;
    for (const ImageSketch& sketch : sketches)
        given.push_back(sketch.depth.worldFromCamera);
    result.worldFromCameras = given;
    result.places.assign(count, ImagePlace::given);
    std::vector<std::uint8_t> isLeader(count, 1);
    for (std::size_t i = 0; i < isFollower.size(); ++i)
        isLeader[i] = isFollower[i] ? 0 : 1;

    int leaders = 0;
    Problem problem{sketches, options, std::vector<Indices>(count), std::vector<std::uint8_t>(count, 0), {}};
    for (std::size_t i = 0; i < count; ++i) {
        problem.ranges.push_back(middleRange(sketches[i].depth));
        if (!isLeader[i]) continue;
        problem.pivot += given[i].translation;
        ++leaders;
        problem.partners[i] = spreadOver(partners[i], options.maxPartners, isLeader);
        problem.isFree[i] = !problem.partners[i].empty() && problem.ranges[i] > 0;
    }
    problem.pivot /= std::max(leaders, 1);
    if (std::count(problem.isFree.begin(), problem.isFree.end(), 1) == 0) return result;
    const std::vector<Pose> found = placed(problem, given, result, onPass);
    const Moves moves = movesOf(problem, given, found);
    result.movedPixels = shrink * moves.most();
    const bool isMoved = result.movedPixels >= options.leastPixels;
    result.isWorse = result.isWorse || (isMoved && !isBetter(result.before, result.after));
    if (result.isWorse) return result;
    const Apartness before = result.before;
    Apartness after = result.after;
    if (isMoved) {
        accept(problem, found, result);
    } else {
        // A capture that is right, but for some.
        std::vector<std::uint8_t> isWrong(count, 0);
        for (std::size_t i = 0; i < count; ++i)
            isWrong[i] = problem.isFree[i] && shrink * moves.ofImage(i) >= options.leastPixels;
        layOnTheRest(onlyPairsOf(problem, isWrong), shrink, true, result);
        const std::vector<Pose>& now = result.worldFromCameras;
        after = apartnessOf(compareAll(problem, now, 0, {}));
    }

    // Those that the others must not know of are laid on them as they now stand.
    for (std::size_t i = 0; i < count; ++i) {
        problem.isFree[i] = 0, problem.partners[i].clear();
        if (result.places[i] == ImagePlace::strayed || result.places[i] == ImagePlace::loose) isLeader[i] = 0;
    }
    for (std::size_t i = 0; i < isFollower.size(); ++i) {
        if (!isFollower[i]) continue;
        problem.partners[i] = spreadOver(partners[i], options.maxPartners, isLeader);
        problem.isFree[i] = !problem.partners[i].empty() && problem.ranges[i] > 0;
    }
    layOnTheRest(problem, shrink, !isMoved, result);
    result.before = before, result.after = after;
    return result;
}

} // namespace scene
