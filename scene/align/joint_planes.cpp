#include "scene/align/joint_planes.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <ceres/ceres.h>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scene {

namespace {

/// What no number of samples averages out: surfaces are not planes, and instruments have faults of their own.
constexpr double kPlaneSystematicMetres = 0.0005;
constexpr double kPlaneRobustDeviations = 3.0;
/// A direction in which a pose is known no better is not held: planes leave it open.
constexpr double kHeldMetres = 0.05, kHeldRadians = 0.02;

struct ScannerPose {
    Eigen::Quaterniond worldFromScanner;
    Eigen::Vector3d translation;
};

struct WorldPlane {
    Eigen::Vector3d normal;
    double offset = 0;
};

Eigen::Vector3d eigenVector(const glm::dvec3& v) {
    return {v.x, v.y, v.z};
}

/// The root of the samples' mean squared distance from the plane, as a vector: three for spread, one for the middle.
struct PlaneResidual {
    Eigen::Vector3d middle;
    Eigen::Matrix3d spread; ///< transposed Cholesky factor of the covariance, noise across the plane left out
    double weight;

    template <class T>
    bool operator()(const T* rotation, const T* translation, const T* normal, const T* offset, T* residual) const {
        const Eigen::Map<const Eigen::Quaternion<T>> q(rotation);
        const Eigen::Map<const Eigen::Matrix<T, 3, 1>> t(translation), n(normal);
        const Eigen::Matrix<T, 3, 1> inScanner = q.conjugate() * n;
        Eigen::Map<Eigen::Matrix<T, 3, 1>> tilts(residual);
        tilts = (spread.cast<T>() * inScanner) * T(weight);
        residual[3] = (inScanner.dot(middle.cast<T>()) + n.dot(t) - *offset) * T(weight);
        return true;
    }
};

/// Two columns, each an axis of the plane times the spread of the samples along it.
Eigen::Matrix3d spreadOf(const ScanPlane& plane) {
    Eigen::Matrix3d c;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            c(i, j) = plane.covariance[j][i];
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(c);
    Eigen::Matrix3d rows = Eigen::Matrix3d::Zero();
    for (int k = 1; k < 3; ++k)
        rows.row(k) = std::sqrt(std::max(solver.eigenvalues()[k], 0.0)) * solver.eigenvectors().col(k).transpose();
    return rows;
}

double weightOf(const ScanPlane& plane, double looseMetres) {
    // Small and rough pieces are often no planes at all: leaves, cushions, the rounded and the cluttered.
    const double deviation = plane.offsetDeviation(), area = std::max(plane.areaSquareMetres, 1e-3);
    const double systematic =
        kPlaneSystematicMetres * kPlaneSystematicMetres * (1 + 1 / area) + std::pow(plane.noiseMetres / 12, 2) / area;
    return 1 / std::sqrt(deviation * deviation + systematic + looseMetres * looseMetres);
}

WorldPlane meanOf(const SharedPlane& shared, const std::vector<const std::vector<ScanPlane>*>& planesOfScan,
                  const std::vector<Pose>& poses, double looseMetres) {
    glm::dvec3 normal(0);
    double offset = 0, sum = 0;
    for (const SharedPlane::Seen& seen : shared.seen)
        normal += poses[seen.scan].rotation * (*planesOfScan[seen.scan])[seen.plane].normal;
    normal = glm::normalize(normal);
    for (const SharedPlane::Seen& seen : shared.seen) {
        const ScanPlane& plane = (*planesOfScan[seen.scan])[seen.plane];
        const double weight = weightOf(plane, looseMetres);
        offset += weight * glm::dot(normal, poses[seen.scan] * plane.middle);
        sum += weight;
    }
    return {eigenVector(normal), offset / sum};
}

PoseDeviation deviationOf(const Eigen::Matrix<double, 6, 6>& covariance) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> turn(Eigen::Matrix3d(covariance.topLeftCorner<3, 3>())),
        move(Eigen::Matrix3d(covariance.bottomRightCorner<3, 3>()));
    const Eigen::Vector3d loosest = move.eigenvectors().col(2);
    return {std::sqrt(std::max(move.eigenvalues()[2], 0.0)),
            std::sqrt(std::max(turn.eigenvalues()[2], 0.0)),
            {loosest.x(), loosest.y(), loosest.z()}};
}

} // namespace

JointResult adjustJointly(const std::vector<const std::vector<ScanPlane>*>& planesOfScan,
                          const std::vector<SharedPlane>& shared, std::vector<Pose> worldFromScanners,
                          std::size_t fixed, double looseMetres) {
    assert(planesOfScan.size() == worldFromScanners.size() && fixed < worldFromScanners.size());
    std::vector<ScannerPose> poses;
    for (const Pose& pose : worldFromScanners) {
        const glm::dvec4 q = quaternionOf(pose);
        poses.push_back({Eigen::Quaterniond(q.w, q.x, q.y, q.z), eigenVector(pose.translation)});
    }
    std::vector<WorldPlane> planes;
    for (const SharedPlane& plane : shared)
        planes.push_back(meanOf(plane, planesOfScan, worldFromScanners, looseMetres));

    ceres::Problem problem;
    for (ScannerPose& pose : poses) {
        problem.AddParameterBlock(pose.worldFromScanner.coeffs().data(), 4, new ceres::EigenQuaternionManifold);
        problem.AddParameterBlock(pose.translation.data(), 3);
    }
    problem.SetParameterBlockConstant(poses[fixed].worldFromScanner.coeffs().data());
    problem.SetParameterBlockConstant(poses[fixed].translation.data());
    for (std::size_t k = 0; k < shared.size(); ++k) {
        problem.AddParameterBlock(planes[k].normal.data(), 3, new ceres::SphereManifold<3>);
        for (const SharedPlane::Seen& seen : shared[k].seen) {
            const ScanPlane& plane = (*planesOfScan[seen.scan])[seen.plane];
            auto* residual =
                new PlaneResidual{eigenVector(plane.middle), spreadOf(plane), weightOf(plane, looseMetres)};
            problem.AddResidualBlock(new ceres::AutoDiffCostFunction<PlaneResidual, 4, 4, 3, 3, 1>(residual),
                                     new ceres::CauchyLoss(kPlaneRobustDeviations),
                                     poses[seen.scan].worldFromScanner.coeffs().data(),
                                     poses[seen.scan].translation.data(), planes[k].normal.data(), &planes[k].offset);
        }
    }
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_SCHUR; // planes know nothing of each other
    options.max_num_iterations = looseMetres > 0 ? 8 : 50;
    options.function_tolerance = looseMetres > 0 ? 1e-5 : 1e-10;
    options.num_threads = 1; // the same bytes everywhere
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);

    JointResult result;
    result.deviations.resize(poses.size());
    double squares = 0, count = 0;
    for (std::size_t k = 0; k < shared.size(); ++k)
        for (const SharedPlane::Seen& seen : shared[k].seen) {
            const ScanPlane& plane = (*planesOfScan[seen.scan])[seen.plane];
            const ScannerPose& pose = poses[seen.scan];
            const Eigen::Vector3d middle = pose.worldFromScanner * eigenVector(plane.middle) + pose.translation;
            const double off = planes[k].normal.dot(middle) - planes[k].offset;
            const Eigen::Vector3d tilts = spreadOf(plane) * (pose.worldFromScanner.conjugate() * planes[k].normal);
            squares += off * off + tilts.squaredNorm();
            count += 1;
        }
    result.rmsMetres = count > 0 ? std::sqrt(squares / count) : 0;

    // Each pose is judged by its own planes as if they were known: what leaves it loose is geometry, and that shows.
    result.isHeld = true;
    std::vector<Eigen::Matrix<double, 6, 6>> information(poses.size(), Eigen::Matrix<double, 6, 6>::Zero());
    for (std::size_t k = 0; k < shared.size(); ++k)
        for (const SharedPlane::Seen& seen : shared[k].seen) {
            const ScanPlane& plane = (*planesOfScan[seen.scan])[seen.plane];
            const ScannerPose& pose = poses[seen.scan];
            const Eigen::Vector3d arm = pose.worldFromScanner * eigenVector(plane.middle);
            const double weight = weightOf(plane, looseMetres);
            Eigen::Matrix<double, 6, 1> row;
            row << arm.cross(planes[k].normal), planes[k].normal;
            information[seen.scan] += 0.5 * weight * weight * row * row.transpose();
            const Eigen::Matrix3d axes = spreadOf(plane) * pose.worldFromScanner.conjugate().toRotationMatrix();
            for (int axis = 1; axis < 3; ++axis) {
                row << Eigen::Vector3d(axes.row(axis).transpose()).cross(planes[k].normal), Eigen::Vector3d::Zero();
                information[seen.scan] += 0.5 * weight * weight * row * row.transpose();
            }
        }
    for (std::size_t i = 0; i < poses.size(); ++i) {
        if (i == fixed) continue;
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> solver(information[i]);
        const Eigen::Matrix<double, 6, 1> variances = solver.eigenvalues().cwiseMax(1e-9).cwiseInverse();
        result.deviations[i] =
            deviationOf(solver.eigenvectors() * variances.asDiagonal() * solver.eigenvectors().transpose());
        if (result.deviations[i].metres > kHeldMetres || result.deviations[i].radians > kHeldRadians)
            result.isHeld = false;
    }
    for (const ScannerPose& pose : poses) {
        const Eigen::Quaterniond q = pose.worldFromScanner.normalized();
        result.worldFromScanners.push_back(poseFromQuaternion(
            {pose.translation.x(), pose.translation.y(), pose.translation.z()}, q.x(), q.y(), q.z(), q.w()));
    }
    result.worldFromScanners[fixed] = worldFromScanners[fixed];
    return result;
}

} // namespace scene
