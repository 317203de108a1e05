// Turns of photographs that agree are made better by each other; one that does not is found out, or all that may be it.

#include "scene/align/turn_network.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace scene {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

const Eigen::Matrix3d kSquare = Eigen::Matrix3d::Identity() * (kDegree * kDegree);

OwnTurn own(std::size_t photograph, double deviationDegrees, bool isSure = true) {
    return {photograph, kSquare * (deviationDegrees * deviationDegrees), isSure};
}

/// Photographs that look the same way; b is where a is, but for a turn.
PairTurn pair(std::size_t a, std::size_t b, const Turn& turn, double deviationDegrees = 0.01, bool isPlain = true) {
    return {a, b, Eigen::Matrix3d::Identity(), turn, kSquare * (deviationDegrees * deviationDegrees), isPlain};
}

TEST(TurnNetwork, WhatAgreesIsKnownBetterTogether) {
    TurnNetwork network(3, {own(0, 0.1), own(1, 0.1), own(2, 0.1)},
                        {pair(0, 1, Turn::Zero()), pair(1, 2, Turn::Zero())});
    network.solve();
    EXPECT_THAT(network.contradicted, IsEmpty());
    for (const Eigen::Matrix3d& covariance : network.covariances)
        EXPECT_NEAR(std::sqrt(covariance(0, 0)), 0.1 * kDegree / std::sqrt(3.0), 0.002 * kDegree);
}

TEST(TurnNetwork, OneThatIsOffIsFoundAmongMany) {
    const Turn off(0, kDegree, 0);
    // The third stands a degree from where the scan has it, as both of its neighbours know.
    TurnNetwork network(5, {own(0, 0.02), own(1, 0.02), own(2, 0.02), own(3, 0.02), own(4, 0.02)},
                        {pair(0, 1, Turn::Zero()), pair(1, 2, -off), pair(2, 3, off), pair(3, 4, Turn::Zero())});
    network.solve();
    EXPECT_THAT(network.contradicted, ElementsAre(2u));
    EXPECT_EQ(network.pairs().size(), 4u);
    EXPECT_LT((network.turns[2] - off).norm(), 0.01 * kDegree);
    EXPECT_LT(network.turns[1].norm(), 0.01 * kDegree);
    EXPECT_FALSE(network.isDisputed(2));
    EXPECT_EQ(network.anchorsOf(2), 4);
    EXPECT_EQ(network.joinedTo(2), 5);
}

TEST(TurnNetwork, APairThatLeavesAnAxisOpenPlacesNobody) {
    PairTurn open = pair(0, 1, Turn::Zero());
    open.covariance(0, 0) = kDegree * kDegree;
    open.isWhole = false;
    TurnNetwork network(2, {own(0, 0.02)}, {open});
    network.solve();
    EXPECT_FALSE(network.isBelieved[1]) << "however plain it is about the other two";
    EXPECT_GT(std::sqrt(network.covariances[1](0, 0)), 0.9 * kDegree);
    EXPECT_LT(std::sqrt(network.covariances[1](1, 1)), 0.03 * kDegree);
}

TEST(TurnNetwork, AWrongPairIsFoundInARing) {
    TurnNetwork network(4, {own(0, 0.05), own(1, 0.05), own(2, 0.05), own(3, 0.05)},
                        {pair(0, 1, Turn::Zero()), pair(1, 2, Turn(kDegree, 0, 0)), pair(2, 3, Turn::Zero()),
                         pair(0, 3, Turn::Zero())});
    network.solve();
    EXPECT_THAT(network.contradicted, IsEmpty());
    EXPECT_EQ(network.pairs().size(), 3u);
    EXPECT_EQ(network.neighboursOf(1), 1);
    for (const Turn& turn : network.turns)
        EXPECT_LT(turn.norm(), 1e-9);
}

TEST(TurnNetwork, WhereNothingTellsWhichIsWrongNoneIsBelieved) {
    const Turn off(0, 0, kDegree);
    TurnNetwork network(4, {own(0, 0.02), own(1, 0.02), own(3, 0.02)},
                        {pair(0, 1, Turn::Zero()), pair(1, 2, Turn::Zero()), pair(2, 3, off)});
    network.solve();
    // The last, what joins it to the first two, and nothing else: those have each other.
    EXPECT_THAT(network.contradicted, ElementsAre(3u));
    EXPECT_EQ(network.pairs().size(), 1u);
    EXPECT_TRUE(network.isAnchored[0] && network.isAnchored[1]);
    EXPECT_FALSE(network.isAnchored[2] || network.isAnchored[3]);
    EXPECT_THAT(network.isBelieved, ElementsAre(true, true, false, false));
}

TEST(TurnNetwork, AnExactPairIsNoSurerThanTheOwnTurnsThatItContradicts) {
    TurnNetwork network(2, {own(0, 0.1), own(1, 0.1)}, {pair(0, 1, Turn(0, 2 * kDegree, 0), 0.002)});
    network.solve();
    EXPECT_THAT(network.contradicted, testing::UnorderedElementsAre(0u, 1u));
    EXPECT_THAT(network.pairs(), IsEmpty());
}

TEST(TurnNetwork, OneThatIsPlacedNeedsAPlainNeighbourOrTwoThatAreBelieved) {
    const auto believed = [](bool isPlain, bool hasThird) {
        // 1 stands by 0, whom the scan placed, and 2 by 1 alone: that one says nothing of 1.
        std::vector<PairTurn> pairs{pair(0, 1, Turn::Zero(), 0.01, isPlain), pair(1, 2, Turn::Zero(), 0.01, true)};
        std::vector<OwnTurn> owns{own(0, 0.02)};
        if (hasThird) owns.push_back(own(3, 0.02)), pairs.push_back(pair(1, 3, Turn::Zero(), 0.01, false));
        TurnNetwork network(4, owns, pairs);
        network.solve();
        return network.isBelieved;
    };
    EXPECT_THAT(believed(true, false), ElementsAre(true, true, true, false));
    EXPECT_THAT(believed(false, false), ElementsAre(true, false, false, false));
    EXPECT_THAT(believed(false, true), ElementsAre(true, true, true, true));
}

TEST(TurnNetwork, WhatTheScanSaysUnsurelyGivesWay) {
    const Turn off(0, 0, kDegree);
    TurnNetwork network(3, {own(0, 0.02), own(1, 0.02), own(2, 0.02, false)},
                        {pair(0, 1, Turn::Zero()), pair(1, 2, -off)});
    network.solve();
    EXPECT_THAT(network.contradicted, ElementsAre(2u));
    EXPECT_EQ(network.pairs().size(), 2u);
    EXPECT_LT((network.turns[2] - off).norm(), 0.01 * kDegree);
}

} // namespace
} // namespace scene
