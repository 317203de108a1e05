#include "scene/align/normal_equations.h"

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCholesky>

namespace scene {

namespace {

/// Steps are taken again until they are small: what is left of one is left to the next.
constexpr double kResidual = 1e-6;
constexpr int kMostIterations = 1000;

using Gradients = Eigen::ConjugateGradient<Eigen::SparseMatrix<double>, Eigen::Lower | Eigen::Upper,
                                           Eigen::IncompleteCholesky<double>>;

} // namespace

Eigen::VectorXd solveNormalEquations(const Eigen::SparseMatrix<double>& matrix, const Eigen::VectorXd& right,
                                     int mostFactored) {
    if (matrix.rows() <= mostFactored) return Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(matrix).solve(right);
    Gradients gradients;
    gradients.setTolerance(kResidual);
    gradients.setMaxIterations(kMostIterations);
    gradients.compute(matrix);
    return gradients.solve(right);
}

} // namespace scene
