#include "scene/align/normal_equations.h"

#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace scene {
namespace {

/// Of poses along a path, each compared with neighbours and with one far off; hardly held in place.
struct Equations {
    Eigen::SparseMatrix<double> matrix;
    Eigen::VectorXd right;
};
Equations equationsOf(int poses) {
    std::mt19937 random(5);
    const auto uniform = [&] { return static_cast<double>(random()) / 4294967296.0 - 0.5; };
    using Block = Eigen::Matrix<double, 6, 6>;
    std::vector<Eigen::Triplet<double>> entries;
    const auto put = [&](int a, int b, const Block& block) {
        for (int c = 0; c < 6; ++c)
            for (int r = 0; r < 6; ++r)
                entries.emplace_back(6 * a + r, 6 * b + c, block(r, c));
    };
    Equations equations{Eigen::SparseMatrix<double>(6 * poses, 6 * poses), Eigen::VectorXd(6 * poses)};
    for (int i = 0; i < poses; ++i) {
        put(i, i, 1e-3 * Block::Identity());
        for (const int j : {i + 1, i + 2, i + 7, (7 * i + 31) % poses}) {
            if (j == i || j >= poses) continue;
            Eigen::Matrix<double, 12, 6> rows;
            for (int k = 0; k < rows.size(); ++k)
                rows(k) = uniform();
            const Block square = rows.transpose() * rows;
            put(i, i, square), put(j, j, square), put(i, j, -square), put(j, i, -square);
        }
    }
    equations.matrix.setFromTriplets(entries.begin(), entries.end());
    for (int k = 0; k < equations.right.size(); ++k)
        equations.right[k] = uniform();
    return equations;
}

TEST(NormalEquations, GradientsFindWhatAFactorFinds) {
    const Equations equations = equationsOf(200);
    const Eigen::VectorXd factored = solveNormalEquations(equations.matrix, equations.right),
                          gradients = solveNormalEquations(equations.matrix, equations.right, 0);
    EXPECT_LT((equations.matrix * factored - equations.right).norm(), 1e-9 * equations.right.norm());
    EXPECT_NE(gradients, factored) << "else this compares nothing";
    EXPECT_LT((gradients - factored).norm(), 1e-4 * factored.norm());
    EXPECT_EQ(solveNormalEquations(equations.matrix, equations.right, 0), gradients) << "the same again";
}

TEST(NormalEquations, OfManyPosesTheyAreSolved) {
    const Equations equations = equationsOf(2000);
    const Eigen::VectorXd found = solveNormalEquations(equations.matrix, equations.right);
    EXPECT_LT((equations.matrix * found - equations.right).norm(), 1e-5 * equations.right.norm());
}

} // namespace
} // namespace scene
