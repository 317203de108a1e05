// What is known of two scans, kept as bytes.

#include "scene/align/pair_record.h"

#include <gtest/gtest.h>

#include <limits>

namespace scene {
namespace {

PairResult someResult() {
    PairResult result;
    result.verdict = PairVerdict::ambiguous;
    result.best.aFromB = poseFromQuaternion({1e6 + 0.1, -2, 3.25}, 0.1, -0.2, 0.3, 0.9);
    result.best.evidence = {0.3, 0.001, 1234, 0.0071};
    result.best.matches = {{0, 3}, {70000, 2}};
    result.best.rmsMetres = 0.004;
    result.best.deviation = {std::numeric_limits<double>::infinity(), 0.01, {0, 0.6, 0.8}};
    result.best.isHeld = true;
    result.rival = result.best;
    result.rival->aFromB.translation.z = 7;
    result.rival->isHeld = false;
    result.plausible = {result.best.aFromB, result.rival->aFromB};
    result.isDecidedByGivenPose = true;
    return result;
}

void expectSame(const PairFit& a, const PairFit& b) {
    EXPECT_EQ(toMatrix(a.aFromB), toMatrix(b.aFromB));
    EXPECT_EQ(a.evidence.agreeing, b.evidence.agreeing);
    EXPECT_EQ(a.evidence.against, b.evidence.against);
    EXPECT_EQ(a.evidence.sharedCells, b.evidence.sharedCells);
    EXPECT_EQ(a.evidence.rmsMetres, b.evidence.rmsMetres);
    ASSERT_EQ(a.matches.size(), b.matches.size());
    for (std::size_t i = 0; i < a.matches.size(); ++i) {
        EXPECT_EQ(a.matches[i].a, b.matches[i].a);
        EXPECT_EQ(a.matches[i].b, b.matches[i].b);
    }
    EXPECT_EQ(a.rmsMetres, b.rmsMetres);
    EXPECT_EQ(a.deviation.metres, b.deviation.metres);
    EXPECT_EQ(a.deviation.radians, b.deviation.radians);
    EXPECT_EQ(a.deviation.loosest, b.deviation.loosest);
    EXPECT_EQ(a.isHeld, b.isHeld);
}

TEST(PairRecord, HoldsAllThatIsKnownToTheBit) {
    const PairResult result = someResult();
    const auto read = unpackPair(packPair(result));
    ASSERT_TRUE(read.has_value());
    EXPECT_EQ(read->verdict, result.verdict);
    expectSame(read->best, result.best);
    ASSERT_TRUE(read->rival.has_value());
    expectSame(*read->rival, *result.rival);
    ASSERT_EQ(read->plausible.size(), 2u);
    EXPECT_EQ(toMatrix(read->plausible[1]), toMatrix(result.plausible[1]));
    EXPECT_TRUE(read->isDecidedByGivenPose);

    const auto nothing = unpackPair(packPair({}));
    ASSERT_TRUE(nothing.has_value());
    EXPECT_EQ(nothing->verdict, PairVerdict::apart);
    EXPECT_FALSE(nothing->rival.has_value());
    EXPECT_TRUE(nothing->plausible.empty());
}

TEST(PairRecord, DamageIsNotTakenForKnowledge) {
    const std::vector<std::byte> whole = packPair(someResult());
    for (std::size_t i = 0; i < whole.size(); ++i) {
        std::vector<std::byte> damaged = whole;
        damaged[i] ^= std::byte{0x10};
        EXPECT_FALSE(unpackPair(damaged).has_value()) << i;
        EXPECT_FALSE(unpackPair(std::span(whole).first(i)).has_value()) << i;
    }
}

} // namespace
} // namespace scene
