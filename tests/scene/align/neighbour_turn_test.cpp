// Two photographs from one place: how one is turned against the other is found to a small part of a pixel, whatever
// their exposures, and nothing is found where they show nothing in common.

#include "scene/align/joint_turns.h"
#include "scene/align/neighbour_turn.h"
#include "scene/srgb.h"
#include "scene/synthetic_random.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <gtest/gtest.h>

namespace scene {
namespace {

/// Something with detail of many sizes in every direction, in [0, 1].
double albedoTowards(const glm::dvec3& direction, double contrast) {
    double value = 0.5;
    SeededSequence chance(9);
    for (double frequency = 8; frequency < 400; frequency *= 1.6)
        for (int i = 0; i < 4; ++i) {
            const glm::dvec3 axis = glm::normalize(glm::dvec3(chance.normal(), chance.normal(), chance.normal()));
            value += 0.045 * contrast * std::sin(frequency * glm::dot(axis, direction) + 6.28 * chance.unit());
        }
    return value;
}

/// 240 x 180 pixels, 60 degrees across, of what `albedo` says of each direction.
template <class Albedo>
SmallPhotograph photographOf(const Albedo& albedo, const glm::dmat3& worldFromCamera, double stops,
                             std::uint64_t seed) {
    SmallPhotograph taken;
    taken.camera = {240, 180, 207.8, 207.8, 120, 90};
    taken.picture = Image<Rgb8>(240, 180);
    SeededSequence chance(seed);
    for (int y = 0; y < 180; ++y)
        for (int x = 0; x < 240; ++x) {
            const glm::dvec3 ray = rayThrough(taken.camera, x + 0.5, y + 0.5);
            const double light = 0.3 * std::exp2(stops) * albedo(glm::normalize(worldFromCamera * ray));
            const double code = 255 * srgbFromLinear(std::clamp(light, 0.0, 1.0)) + chance.normal();
            const auto byte = static_cast<std::uint8_t>(std::clamp(std::lround(code), 0L, 255L));
            taken.picture(x, y) = {byte, byte, byte};
        }
    return taken;
}

SmallPhotograph photograph(const glm::dmat3& worldFromCamera, double stops, std::uint64_t seed, double contrast = 1) {
    return photographOf([&](const glm::dvec3& direction) { return albedoTowards(direction, contrast); },
                        worldFromCamera, stops, seed);
}

const glm::dmat3 kBFromA = matrixOf(Turn(0.02, 0.45, -0.03));

TEST(NeighbourTurn, IsFoundToAPartOfAPixelWhateverTheExposure) {
    const glm::dmat3 worldFromB = matrixOf(Turn(0.3, -0.2, 0.5));
    const GreyLevels a = greyLevels(photograph(worldFromB * kBFromA, 0.6, 1)),
                     b = greyLevels(photograph(worldFromB, -0.6, 2));
    const Turn off(0.008, -0.012, 0.01); // two to three pixels
    const auto found = layOnNeighbour(a, b, glm::transpose(matrixOf(off)) * kBFromA, Turn::Zero());
    ASSERT_TRUE(found);
    const double error = turnOf(matrixOf(found->turn) * glm::transpose(matrixOf(off))).norm();
    EXPECT_LT(error, 0.03 / b.camera.fx) << "a thirtieth of a pixel; " << error / kDegree << " degrees";
    EXPECT_LT(error, 4 * std::sqrt(found->covariance.trace()));
    EXPECT_LT(std::sqrt(found->covariance.trace()), 0.1 / b.camera.fx);
    EXPECT_GT(found->correlation, 0.9);
    EXPECT_GT(found->agreeing, 0.95);
    EXPECT_EQ(found->parts, kParts);
}

TEST(NeighbourTurn, WhatHasNothingInCommonDoesNotLieOnEachOther) {
    const glm::dmat3 worldFromB = matrixOf(Turn(0.3, -0.2, 0.5)), elsewhere = matrixOf(Turn(-1.3, 0.8, 0.1));
    const GreyLevels b = greyLevels(photograph(worldFromB, 0, 2));
    if (const auto found = layOnNeighbour(greyLevels(photograph(elsewhere, 0, 1)), b, kBFromA, Turn::Zero())) {
        EXPECT_LT(found->correlation, 0.4);
        EXPECT_LT(found->agreeing, 0.6);
    }
    // Noise alone.
    const GreyLevels blank = greyLevels(photograph(worldFromB, 0, 2, 0));
    if (const auto found =
            layOnNeighbour(greyLevels(photograph(worldFromB * kBFromA, 0, 1, 0)), blank, kBFromA, Turn::Zero())) {
        EXPECT_LT(found->correlation, 0.4);
        EXPECT_LT(found->agreeing, 0.6);
    }
    // Back to back.
    EXPECT_FALSE(layOnNeighbour(b, b, matrixOf(Turn(0, std::numbers::pi, 0)), Turn::Zero()));
}

/// Stripes about an axis of b: a turn about it changes nothing but the noise.
const glm::dmat3 kWorldFromStriped = matrixOf(Turn(0.3, -0.2, 0.5));
const glm::dvec3 kStripeAxis = glm::normalize(glm::dvec3(0.1, 1, 0.05));

SmallPhotograph stripes(const glm::dmat3& worldFromCamera, double stops, std::uint64_t seed) {
    const auto albedo = [](const glm::dvec3& direction) {
        double value = 0.5;
        for (double frequency = 20; frequency < 200; frequency *= 1.6)
            value += 0.08 * std::sin(frequency * glm::dot(kWorldFromStriped * kStripeAxis, direction) + frequency);
        return value;
    };
    return photographOf(albedo, worldFromCamera, stops, seed);
}

TEST(NeighbourTurn, AlongEdgesThatAllRunOneWayNothingIsKnown) {
    const GreyLevels a = greyLevels(stripes(kWorldFromStriped * kBFromA, 0.3, 1)),
                     b = greyLevels(stripes(kWorldFromStriped, 0, 2));
    const Turn about(kStripeAxis.x, kStripeAxis.y, kStripeAxis.z);
    const Turn off = 0.004 * about + Turn(0.005, 0, -0.004);
    const auto found = layOnNeighbour(a, b, glm::transpose(matrixOf(off)) * kBFromA, Turn::Zero());
    ASSERT_TRUE(found);
    EXPECT_GT(found->correlation, 0.9);
    const Turn error = turnOf(matrixOf(found->turn) * glm::transpose(matrixOf(off)));
    EXPECT_LT((error - about * about.dot(error)).norm(), 0.1 / b.camera.fx) << "across the stripes it is known";
    EXPECT_GT(std::sqrt(about.dot(found->covariance * about)), 0.5 * kDegree)
        << "and along them it says that it is not";
}

/// What the scan said of a photograph, exactly.
ColourFit foundByScan() {
    ColourFit fit;
    fit.isFound = fit.isSure = true;
    fit.parts = kParts, fit.agreeing = 1, fit.score = 5, fit.rivalShare = 0.2, fit.deviationRadians = 3e-4;
    fit.covariance = glm::dmat3(3e-8);
    return fit;
}

TEST(JoinTurns, APairThatLeavesAnAxisOpenPlacesNobody) {
    const auto joined = [](bool isSecondFound) {
        std::vector<PhotographOnScan> photographs;
        for (const glm::dmat3& rotation : {kWorldFromStriped * kBFromA, kWorldFromStriped}) {
            Pose pose;
            pose.rotation = rotation;
            photographs.push_back({stripes(rotation, 0, 1 + photographs.size()), pose});
        }
        std::vector<ColourFit> fits{foundByScan(), isSecondFound ? foundByScan() : ColourFit{}};
        joinTurns(photographs, fits);
        return fits;
    };
    for (const ColourFit& fit : joined(true)) {
        EXPECT_TRUE(fit.isSure) << fit.why;
        EXPECT_EQ(fit.neighbours, 1) << "they are laid on each other as far as that goes";
        EXPECT_LT(fit.deviationRadians, 3e-4);
    }
    const std::vector<ColourFit> alone = joined(false);
    EXPECT_TRUE(alone[0].isSure);
    EXPECT_FALSE(alone[1].isSure);
    EXPECT_EQ(alone[1].neighbours, 0);
}

TEST(JoinTurns, OfTwoThatContradictEachOtherNeitherIsBelieved) {
    const glm::dmat3 scannerFromB = matrixOf(Turn(0.3, -0.2, 0.5));
    const auto joined = [&](double offRadians) {
        std::vector<PhotographOnScan> photographs;
        for (const glm::dmat3& rotation : {scannerFromB * kBFromA, scannerFromB}) {
            Pose pose;
            pose.rotation = rotation;
            photographs.push_back({photograph(rotation, 0, 1 + photographs.size()), pose});
        }
        photographs[1].scannerFromGiven.rotation = scannerFromB * matrixOf(Turn(0, offRadians, 0));
        std::vector<ColourFit> fits{foundByScan(), foundByScan()};
        joinTurns(photographs, fits);
        return fits;
    };
    for (const ColourFit& fit : joined(0)) {
        EXPECT_TRUE(fit.isSure) << fit.why;
        EXPECT_EQ(fit.neighbours, 1);
    }
    for (const ColourFit& fit : joined(0.012)) {
        EXPECT_FALSE(fit.isSure);
        EXPECT_FALSE(fit.why.empty());
    }
}

TEST(SmallPhotograph, KeepsItsFieldOfView) {
    SmallPhotograph large;
    large.camera = {3000, 2000, 2500, 2500, 1500, 1000};
    large.picture = Image<Rgb8>(3000, 2000, {10, 20, 30});
    const SmallPhotograph small = smallPhotograph(large.picture, large.camera);
    EXPECT_EQ(small.camera.width, 1200);
    EXPECT_EQ(small.camera.height, 800);
    EXPECT_DOUBLE_EQ(small.camera.fx, 1000);
    EXPECT_EQ(small.picture(1199, 799), (Rgb8{10, 20, 30}));
    EXPECT_EQ(smallPhotograph(small.picture, small.camera).picture, small.picture);
}

} // namespace
} // namespace scene
