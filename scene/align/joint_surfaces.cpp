#include "scene/align/joint_surfaces.h"

#include "scene/median.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include <Eigen/Dense>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <tbb/parallel_for.h>

namespace scene {

namespace {

constexpr double kSurfacesFacing = 0.975; ///< cosine between two surfaces that may be one
constexpr double kSettledMetres = 1e-6, kSettledRadians = 1e-6;
constexpr double kWorthMetres = 4.0; ///< from there on cells count less: they are wide, and noise rises
/// Neighbouring cells share their faults (window, surface, instrument): deviations are this many times those of
/// independent ones. Set by the errors that tests/bench/registration_study.cpp finds.
constexpr double kDependence = 6.0;
/// A direction in which a pose is known no better is not held.
constexpr double kHeldSurfaceMetres = 0.02, kHeldSurfaceRadians = 0.01;

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// What one pair says of the motion of its first scan against its second; that of the second is the opposite.
struct Said {
    Matrix6 squares = Matrix6::Zero();
    Vector6 right = Vector6::Zero();
    double weighted = 0, weights = 0;
    std::vector<float> distances;
};

void compare(const Panorama& from, const Panorama& to, const Pose& worldFromFrom, const Pose& worldFromTo,
             double widest, double scale, double sign, int stride, Said& said) {
    const Pose toFromFrom = inverse(worldFromTo) * worldFromFrom;
    stride *= from.finerThanCoarse();
    for (int y = 0; y < from.height(); y += stride) {
        const double rowWeight = from.weightOf(y);
        for (int x = 0; x < from.width(); x += stride) {
            const PanoramaCell& cell = from.cells(x, y);
            if (cell.samples == 0 || cell.normal == glm::vec3(0)) continue;
            const glm::dvec3 p = toFromFrom * glm::dvec3(cell.point);
            const PanoramaCell* seen = to.find(p);
            if (!seen || seen->samples == 0 || seen->normal == glm::vec3(0)) continue;
            const glm::dvec3 normal(seen->normal), other = toFromFrom.rotation * glm::dvec3(cell.normal);
            if (glm::dot(normal, other) < kSurfacesFacing) continue;
            // Along the mean of both normals: neither scan's noise leans on the other.
            const glm::dvec3 both = glm::normalize(normal + other);
            const double distance = glm::dot(both, p - glm::dvec3(seen->point));
            if (std::abs(distance) > widest) continue;
            said.distances.push_back(static_cast<float>(std::abs(distance)));
            const double range = std::max(glm::length(glm::dvec3(cell.point)), glm::length(p));
            const double weight =
                rowWeight / (1 + std::pow(range / kWorthMetres, 2)) / (1 + std::pow(distance / scale, 2));
            const glm::dvec3 n = worldFromTo.rotation * both, q = worldFromTo * p, arm = glm::cross(q, n);
            Vector6 row;
            row << arm.x, arm.y, arm.z, n.x, n.y, n.z;
            row *= sign;
            said.squares += weight * row * row.transpose();
            said.right -= weight * distance * row;
            said.weighted += weight * distance * distance;
            said.weights += weight;
        }
    }
}

Pose moved(const Pose& pose, const Vector6& motion) {
    const glm::dvec3 turn(motion[0], motion[1], motion[2]);
    const double angle = glm::length(turn), half = angle / 2;
    const glm::dvec3 v = angle > 0 ? turn / angle * std::sin(half) : glm::dvec3(0);
    const Pose by = poseFromQuaternion({motion[3], motion[4], motion[5]}, v.x, v.y, v.z, std::cos(half));
    return by * pose;
}

/// Deviations of a pose about its own scanner.
PoseDeviation deviationOf(const Matrix6& covariance, const glm::dvec3& at) {
    // The place of the scanner moves by turn x at + move.
    Matrix6 about = Matrix6::Identity();
    about(3, 1) = at.z, about(3, 2) = -at.y;
    about(4, 0) = -at.z, about(4, 2) = at.x;
    about(5, 0) = at.y, about(5, 1) = -at.x;
    const Matrix6 own = about * covariance * about.transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> turn(Eigen::Matrix3d(own.topLeftCorner<3, 3>())),
        move(Eigen::Matrix3d(own.bottomRightCorner<3, 3>()));
    const Eigen::Vector3d loosest = move.eigenvectors().col(2);
    return {std::sqrt(std::max(move.eigenvalues()[2], 0.0)),
            std::sqrt(std::max(turn.eigenvalues()[2], 0.0)),
            {loosest.x(), loosest.y(), loosest.z()}};
}

} // namespace

JointResult layOnSurfaces(const std::vector<const Panorama*>& panoramas,
                          const std::vector<std::pair<std::size_t, std::size_t>>& pairs,
                          std::vector<Pose> worldFromScanners, std::size_t fixed, const SurfaceOptions& options) {
    assert(panoramas.size() == worldFromScanners.size() && fixed < panoramas.size());
    // About the fixed scanner, however far the world's origin is.
    const Pose worldFromFixed = worldFromScanners[fixed];
    std::vector<Pose> poses;
    for (const Pose& pose : worldFromScanners)
        poses.push_back(inverse(worldFromFixed) * pose);

    const auto count = static_cast<Eigen::Index>(panoramas.size());
    std::vector<double> scales(pairs.size(), options.widestMetres / 2);
    Eigen::MatrixXd squares;
    double weighted = 0, weights = 0;
    for (int pass = 0; pass < options.passes; ++pass) {
        const double widest = std::max(options.widestMetres * std::pow(0.6, pass), 3 * options.narrowestMetres);
        std::vector<Said> said(pairs.size());
        tbb::parallel_for(std::size_t{0}, pairs.size(), [&](std::size_t k) {
            const auto [i, j] = pairs[k];
            compare(*panoramas[i], *panoramas[j], poses[i], poses[j], widest, scales[k], 1, options.stride, said[k]);
            compare(*panoramas[j], *panoramas[i], poses[j], poses[i], widest, scales[k], -1, options.stride, said[k]);
            // Twice the deviation that the median tells of.
            scales[k] = std::clamp(3.0 * medianOf(said[k].distances), options.narrowestMetres / 5, widest);
        });
        squares = Eigen::MatrixXd::Zero(6 * count, 6 * count);
        Eigen::VectorXd right = Eigen::VectorXd::Zero(6 * count);
        weighted = weights = 0;
        for (std::size_t k = 0; k < pairs.size(); ++k) {
            const auto i = static_cast<Eigen::Index>(6 * pairs[k].first),
                       j = static_cast<Eigen::Index>(6 * pairs[k].second);
            squares.block<6, 6>(i, i) += said[k].squares, squares.block<6, 6>(j, j) += said[k].squares;
            squares.block<6, 6>(i, j) -= said[k].squares, squares.block<6, 6>(j, i) -= said[k].squares;
            right.segment<6>(i) += said[k].right, right.segment<6>(j) -= said[k].right;
            weighted += said[k].weighted, weights += said[k].weights;
        }
        const auto f = static_cast<Eigen::Index>(6 * fixed);
        squares.middleRows(f, 6).setZero(), squares.middleCols(f, 6).setZero();
        squares.block<6, 6>(f, f).setIdentity();
        right.segment<6>(f).setZero();
        squares.diagonal().array() += 1e-9 * std::max(squares.diagonal().maxCoeff(), 1.0);
        const Eigen::VectorXd motion = squares.ldlt().solve(right);
        double move = 0, turn = 0;
        for (std::size_t i = 0; i < poses.size(); ++i) {
            const Vector6 mine = motion.segment<6>(static_cast<Eigen::Index>(6 * i));
            if (i != fixed) poses[i] = moved(poses[i], mine);
            turn = std::max(turn, mine.head<3>().norm()), move = std::max(move, mine.tail<3>().norm());
        }
        if (widest <= 3 * options.narrowestMetres && move < kSettledMetres && turn < kSettledRadians) break;
    }

    JointResult result;
    result.deviations.resize(poses.size());
    result.isHeld = weights > 0;
    result.rmsMetres = weights > 0 ? std::sqrt(weighted / weights) : 0;
    const Eigen::MatrixXd covariance = squares.ldlt().solve(Eigen::MatrixXd::Identity(6 * count, 6 * count)) *
                                       std::pow(kDependence * std::max(result.rmsMetres, 1e-5) / options.stride, 2);
    for (std::size_t i = 0; i < poses.size(); ++i) {
        const auto at = static_cast<Eigen::Index>(6 * i);
        if (i != fixed) {
            result.deviations[i] = deviationOf(covariance.block<6, 6>(at, at), poses[i].translation);
            const PoseDeviation& d = result.deviations[i];
            if (!(d.metres < kHeldSurfaceMetres && d.radians < kHeldSurfaceRadians)) result.isHeld = false;
            result.deviations[i].loosest = worldFromFixed.rotation * d.loosest;
        }
        result.worldFromScanners.push_back(worldFromFixed * poses[i]);
    }
    result.worldFromScanners[fixed] = worldFromFixed;
    return result;
}

} // namespace scene
