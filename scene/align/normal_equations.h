#pragma once
// The step of many poses at once: normal equations of which each block of six unknowns, a pose, meets those of the
// images that it is compared with.

#include <Eigen/SparseCore>

namespace scene {

/// From so many unknowns on a factor would be nearly dense, since images are compared with others far along the path:
/// of 800 photographs one factor took seconds. Then steps are found by conjugate gradients, preconditioned by an
/// incomplete factor (Lin and More, "Incomplete Cholesky factorizations with limited memory", 1999); in one thread, so
/// that they are always the same.
inline constexpr int kMostFactoredUnknowns = 1536;

/// x of matrix x = right; matrix: symmetric and positive definite, both halves there.
Eigen::VectorXd solveNormalEquations(const Eigen::SparseMatrix<double>& matrix, const Eigen::VectorXd& right,
                                     int mostFactored = kMostFactoredUnknowns);

} // namespace scene
