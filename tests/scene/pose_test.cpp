#include "scene/pose.h"

#include "tests/scene/random_poses.h"

#include <cmath>
#include <limits>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <gtest/gtest.h>

namespace scene {
namespace {

constexpr int kTrials = 500;
constexpr double kRounding = 1e-14;         ///< of a rotation's entries after a few products
constexpr double kFarRoundingMetres = 1e-7; ///< 10^7 m times a few units in the last place
constexpr double kPoseTolerance = 1e-3;     ///< as manifests of real captures need

double largestEntry(const glm::dmat3& matrix) {
    double largest = 0;
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row)
            largest = std::max(largest, std::abs(matrix[column][row]));
    return largest;
}

void expectSame(const Pose& a, const Pose& b, double metres) {
    EXPECT_LT(largestEntry(a.rotation - b.rotation), kRounding);
    EXPECT_LT(glm::length(a.translation - b.translation), metres);
}

void expectRotation(const glm::dmat3& rotation) {
    EXPECT_LT(largestEntry(glm::transpose(rotation) * rotation - glm::dmat3(1.0)), kRounding);
    EXPECT_NEAR(glm::determinant(rotation), 1.0, kRounding);
}

TEST(Pose, ProductCarriesPointsOneAfterTheOther) {
    RandomPlaces random(1);
    for (int trial = 0; trial < kTrials; ++trial) {
        const Pose cFromB = random.pose(10, kFarFromOrigin), bFromA = random.pose(10);
        const glm::dvec3 pInA = random.point(100);
        EXPECT_LT(glm::length((cFromB * bFromA) * pInA - cFromB * (bFromA * pInA)), kFarRoundingMetres);
    }
}

TEST(Pose, ProductIsAssociative) {
    RandomPlaces random(2);
    for (int trial = 0; trial < kTrials; ++trial) {
        const Pose dFromC = random.pose(10, kFarFromOrigin), cFromB = random.pose(10), bFromA = random.pose(10);
        expectSame((dFromC * cFromB) * bFromA, dFromC * (cFromB * bFromA), kFarRoundingMetres);
    }
}

TEST(Pose, InverseUndoesAlsoFarFromTheOrigin) {
    RandomPlaces random(3);
    for (int trial = 0; trial < kTrials; ++trial) {
        const Pose bFromA = random.pose(10, kFarFromOrigin);
        expectSame(inverse(bFromA) * bFromA, Pose{}, kFarRoundingMetres);
        expectSame(bFromA * inverse(bFromA), Pose{}, kFarRoundingMetres);
        expectSame(inverse(inverse(bFromA)), bFromA, kFarRoundingMetres);
    }
}

TEST(Pose, MatrixCarriesTheSamePoints) {
    RandomPlaces random(4);
    for (int trial = 0; trial < kTrials; ++trial) {
        const Pose bFromA = random.pose(10, kFarFromOrigin);
        const glm::dvec3 pInA = random.point(100);
        const glm::dvec4 pInB = toMatrix(bFromA) * glm::dvec4(pInA, 1.0);
        EXPECT_LT(glm::length(glm::dvec3(pInB) - bFromA * pInA), kFarRoundingMetres);
        EXPECT_EQ(pInB.w, 1.0);
    }
}

TEST(Pose, MatrixGivesThePoseBack) {
    RandomPlaces random(5);
    for (int trial = 0; trial < kTrials; ++trial) {
        const Pose bFromA = random.pose(10, kFarFromOrigin);
        Pose back;
        ASSERT_TRUE(poseFromMatrix(toMatrix(bFromA), kPoseTolerance, back));
        expectSame(back, bFromA, 1e-300);
    }
}

TEST(Pose, RoundedMatrixIsMadeARotationExactly) {
    RandomPlaces random(6);
    for (int trial = 0; trial < kTrials; ++trial) {
        glm::dmat4 matrix = toMatrix(random.pose(10));
        for (int column = 0; column < 3; ++column)
            for (int row = 0; row < 3; ++row)
                matrix[column][row] = std::round(matrix[column][row] * 1e4) / 1e4;
        Pose pose;
        ASSERT_TRUE(poseFromMatrix(matrix, kPoseTolerance, pose));
        expectRotation(pose.rotation);
        EXPECT_LT(largestEntry(pose.rotation - glm::dmat3(matrix)), 2e-4);
    }
}

class RefusedMatrix : public testing::Test {
  protected:
    void expectRefused(const glm::dmat4& matrix) {
        const Pose before = RandomPlaces(8).pose(10);
        Pose pose = before;
        EXPECT_FALSE(poseFromMatrix(matrix, kPoseTolerance, pose));
        EXPECT_EQ(pose.rotation, before.rotation);
        EXPECT_EQ(pose.translation, before.translation);
    }
    const glm::dmat4 good_ = toMatrix(RandomPlaces(7).pose(10, kFarFromOrigin));
};

TEST_F(RefusedMatrix, NotFiniteAnywhere) {
    for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                             -std::numeric_limits<double>::infinity()})
        for (int column = 0; column < 4; ++column)
            for (int row = 0; row < 4; ++row) {
                glm::dmat4 matrix = good_;
                matrix[column][row] = bad;
                expectRefused(matrix);
            }
}

TEST_F(RefusedMatrix, Scaled) {
    for (const double scale : {0.0, 0.5, 0.999, 1.001, 1000.0, 1e200})
        for (int axis = 0; axis < 3; ++axis) {
            glm::dmat4 matrix = good_;
            matrix[axis] *= scale;
            expectRefused(matrix);
        }
}

TEST_F(RefusedMatrix, Mirrored) {
    for (int axis = 0; axis < 3; ++axis) {
        glm::dmat4 matrix = good_;
        matrix[axis] = -matrix[axis];
        expectRefused(matrix);
    }
    glm::dmat4 swapped = good_;
    std::swap(swapped[0], swapped[1]);
    expectRefused(swapped);
}

TEST_F(RefusedMatrix, Sheared) {
    for (int axis = 0; axis < 3; ++axis) {
        glm::dmat4 matrix = good_;
        matrix[axis] = glm::dvec4(glm::normalize(glm::dvec3(matrix[axis] + 0.01 * matrix[(axis + 1) % 3])), 0.0);
        expectRefused(matrix);
    }
}

TEST_F(RefusedMatrix, RowMajorTakenForColumnMajor) {
    expectRefused(glm::transpose(good_));
}

TEST_F(RefusedMatrix, LastRowProjective) {
    for (int column = 0; column < 4; ++column) {
        glm::dmat4 matrix = good_;
        matrix[column][3] += 0.01;
        expectRefused(matrix);
    }
}

TEST_F(RefusedMatrix, AllZero) {
    expectRefused(glm::dmat4(0.0));
}

TEST(Pose, QuaternionNeedNotBeNormalised) {
    RandomPlaces random(9);
    for (int trial = 0; trial < kTrials; ++trial) {
        const glm::dvec4 q{random.point(1), random.between(-1, 1)};
        const Pose unit = poseFromQuaternion({1, 2, 3}, q.x, q.y, q.z, q.w);
        expectRotation(unit.rotation);
        // 1e-160 squared is no longer a number above 0, 1e160 squared no longer finite.
        for (const double scale : {-1.0, 1e-6, 1e6, 1e-160, 1e160})
            expectSame(poseFromQuaternion({1, 2, 3}, scale * q.x, scale * q.y, scale * q.z, scale * q.w), unit, 1e-300);
    }
}

TEST(Pose, QuaternionGivesItsRotation) {
    // A quarter turn to the left about +Y carries forward, -Z, to -X.
    const double half = std::sqrt(0.5);
    const glm::dvec3 turned = poseFromQuaternion({}, 0, half, 0, half) * glm::dvec3(0, 0, -1);
    EXPECT_LT(glm::length(turned - glm::dvec3(-1, 0, 0)), kRounding);
}

TEST(Pose, QuaternionOfPoseGivesThePoseBack) {
    RandomPlaces random(10);
    for (int trial = 0; trial < kTrials; ++trial) {
        const Pose pose = random.pose(10);
        const glm::dvec4 q = quaternionOf(pose);
        EXPECT_GE(q.w, 0.0);
        EXPECT_NEAR(glm::length(q), 1.0, kRounding);
        expectSame(poseFromQuaternion(pose.translation, q.x, q.y, q.z, q.w), pose, 1e-300);
    }
}

TEST(Pose, QuaternionOfHalfTurns) {
    for (int axis = 0; axis < 3; ++axis) {
        glm::dvec3 q(0.0);
        q[axis] = 1.0;
        const Pose pose = poseFromQuaternion({}, q.x, q.y, q.z, 0.0);
        const glm::dvec4 back = quaternionOf(pose);
        EXPECT_NEAR(std::abs(back[axis]), 1.0, kRounding);
        EXPECT_GE(back.w, 0.0);
    }
}

} // namespace
} // namespace scene
