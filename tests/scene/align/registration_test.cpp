// Scans of known places registered from nothing: exactly, or not at all, and never wrongly.

#include "scene/align/mirrored.h"
#include "scene/align/registration.h"

#include "tests/scene/align/scanned_places.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace scene {
namespace {

using testing::HasSubstr;

ScanView viewFrom(const SyntheticScene& place, const Pose& worldFromScanner, std::uint32_t seed,
                  const Pose& given = {}) {
    Scan scan = scanFrom(place, worldFromScanner, seed);
    scan.worldFromScanner = given;
    return viewOf(scan);
}

/// Of a against b, where both stand where they do.
void expectRight(const Pose& aFromB, const Pose& worldFromA, const Pose& worldFromB) {
    const Pose truth = inverse(worldFromA) * worldFromB;
    EXPECT_LT(degreesBetween(aFromB, truth), 0.02);
    EXPECT_LT(metresBetween(aFromB, truth), 0.002);
}

TEST(Registration, ARoomFromUnknownPosesToAFiftiethOfADegreeAndTwoMillimetres) {
    const SyntheticScene place = office();
    for (std::uint32_t seed = 1; seed <= 2; ++seed) {
        const std::vector<Pose> truth{setUpAt({1.4, 1.1, 1.5}, seed), setUpAt({4.4, 2.9, 1.6}, seed + 10),
                                      setUpAt({2.5, 3.6, 1.4}, seed + 20)};
        std::vector<ScanView> views;
        for (std::uint32_t i = 0; i < 3; ++i)
            views.push_back(viewFrom(place, truth[i], 10 * seed + i));
        const Registration found = registerScans(views);
        ASSERT_EQ(found.pairs.size(), 3u);
        for (std::size_t i = 0; i < 3; ++i) {
            ASSERT_TRUE(found.scans[i].isRegistered) << found.scans[i].why;
            EXPECT_EQ(found.scans[i].group, 0u);
            expectRight(inverse(found.scans[0].worldFromScanner) * found.scans[i].worldFromScanner, truth[0], truth[i]);
            EXPECT_LT(found.scans[i].deviation.metres, 0.003);
        }
        for (const PairOutcome& pair : found.pairs) {
            EXPECT_GT(pair.result.best.evidence.agreeing, 0.4);
            EXPECT_LT(pair.result.best.evidence.againstShare(), 0.002);
        }
        EXPECT_LT(found.rmsMetres, 0.012);
    }
}

TEST(Registration, IsTheSameOnOneThreadAndFarFromTheOrigin) {
    const SyntheticScene place = office();
    std::vector<ScanView> views{viewFrom(place, setUpAt({1.4, 1.1, 1.5}, 1), 1),
                                viewFrom(place, setUpAt({4.4, 2.9, 1.6}, 2), 2)};
    const Registration many = registerScans(views);
    {
        const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
        const Registration single = registerScans(views);
        EXPECT_EQ(toMatrix(single.scans[1].worldFromScanner), toMatrix(many.scans[1].worldFromScanner));
    }
    views[0].givenWorldFromScanner.translation = {4e6, 5e5, 100};
    views[1].givenWorldFromScanner.translation = {4e6, 5e5, 100};
    const Registration far = registerScans(views);
    const auto relative = [](const Registration& r) {
        return inverse(r.scans[0].worldFromScanner) * r.scans[1].worldFromScanner;
    };
    EXPECT_LT(metresBetween(relative(far), relative(many)), 1e-6);
}

/// A square hall that looks the same from four sides, but for one chest.
SyntheticScene squareHall() {
    BoxPlace place;
    place.addHall({-3, -3, 0}, {3, 3, 2.8});
    for (const double x : {-2.2, 2.2})
        for (const double y : {-2.2, 2.2})
            place.add({x - 0.2, y - 0.2, 0}, {x + 0.2, y + 0.2, 2.8});
    return place.add({2.2, -0.5, 0}, {3, 0.5, 0.9}).build();
}

TEST(Registration, FreeSpaceTellsTheRightOneOfFourPosesThatNearlyFit) {
    const SyntheticScene place = squareHall();
    const Pose a = setUpAt({0.6, 0.3, 1.5}, 3), b = setUpAt({-0.9, -0.7, 1.6}, 4);
    const PairResult result = registerPair(viewFrom(place, a, 1), viewFrom(place, b, 2), std::nullopt);
    EXPECT_EQ(result.verdict, PairVerdict::registered);
    expectRight(result.best.aFromB, a, b);
    ASSERT_TRUE(result.rival.has_value()) << "the others were looked at";
    EXPECT_GT(result.rival->evidence.agreeing, 0.5) << "and most of them fits";
    EXPECT_GT(result.rival->evidence.againstShare(), 0.005);
}

/// Pillars and nothing else, as far as a scanner reaches.
SyntheticScene endlessPillars() {
    BoxPlace place;
    place.addHall({-30, -1.3, 0}, {30, 1.3, 2.8});
    for (int i = -9; i <= 9; ++i)
        for (const double y : {-1.3, 1.0})
            place.add({3 * i - 0.2, y, 0}, {3 * i + 0.2, y + 0.3, 2.8});
    return place.build();
}

ScanView pillarsFrom(const SyntheticScene& place, const Pose& worldFromScanner, std::uint32_t seed) {
    Scan scan = scanFrom(place, worldFromScanner, seed, 9);
    scan.worldFromScanner = {};
    return viewOf(scan);
}

TEST(Registration, WhatRepeatsIsAmbiguousUnlessSomebodySaysWhere) {
    const SyntheticScene place = endlessPillars();
    const Pose a = setUpAt({1.2, 0.1, 1.5}, 5), b = setUpAt({5.0, -0.2, 1.6}, 6);
    std::vector<ScanView> views{pillarsFrom(place, a, 1), pillarsFrom(place, b, 2)};
    const Registration unknown = registerScans(views);
    EXPECT_EQ(unknown.pairs[0].result.verdict, PairVerdict::ambiguous);
    EXPECT_GE(unknown.pairs[0].result.plausible.size(), 2u);
    EXPECT_FALSE(unknown.scans[1].isRegistered);
    EXPECT_THAT(unknown.scans[1].why, HasSubstr("fits 'scan1' in"));
    EXPECT_EQ(toMatrix(unknown.scans[1].worldFromScanner), toMatrix(views[1].givenWorldFromScanner));

    views[0].givenWorldFromScanner = a;
    views[1].givenWorldFromScanner = b;
    views[1].givenWorldFromScanner.translation += glm::dvec3(0.3, -0.1, 0.05);
    const Registration rough = registerScans(views);
    ASSERT_TRUE(rough.scans[1].isRegistered) << rough.scans[1].why;
    const Pose found = inverse(rough.scans[0].worldFromScanner) * rough.scans[1].worldFromScanner;
    EXPECT_LT(metresBetween(found, inverse(a) * b), 0.01);
}

TEST(Registration, APairThatNotMoreAgreeWithThanDenyJoinsNothing) {
    const SyntheticScene place = office();
    const std::vector<Pose> truth{setUpAt({1.4, 1.1, 1.5}, 1), setUpAt({4.4, 2.9, 1.6}, 2),
                                  setUpAt({2.5, 3.6, 1.4}, 3)};
    std::vector<ScanView> views;
    for (std::uint32_t i = 0; i < 3; ++i)
        views.push_back(viewFrom(place, truth[i], i));
    const auto outcome = [&](std::size_t a, std::size_t b) {
        return PairOutcome{a, b, registerPair(views[a], views[b], std::nullopt)};
    };
    const PairOutcome first = outcome(0, 1), second = outcome(0, 2);
    PairOutcome third = outcome(1, 2);
    ASSERT_EQ(second.result.verdict, PairVerdict::registered);
    const Pose right = third.result.best.aFromB;
    Pose turned = right, shifted = right;
    turned.rotation = turned.rotation * setUpAt({}, 9).rotation;
    shifted.translation += glm::dvec3(0.4, 0, 0);

    // The two that repeat know of other places alone: nobody knows whether they or the surer pair is wrong.
    third.result.verdict = PairVerdict::ambiguous;
    third.result.plausible = {turned, shifted};
    // What is left joins two; the third scan stands where it was said to stand.
    const auto expectOneLeft = [](const Registration& found) {
        const std::size_t left = found.scans[1].isRegistered ? 2 : 1;
        EXPECT_TRUE(found.scans[0].isRegistered && found.scans[3 - left].isRegistered);
        EXPECT_FALSE(found.scans[left].isRegistered);
        EXPECT_TRUE(found.pairs[left - 1].isRefused);
        EXPECT_FALSE(found.scans[left].why.empty());
    };
    expectOneLeft(joinScans(views, {first, second, third}));

    third.result.plausible.push_back(right);
    const Registration confirmed = joinScans(views, {first, second, third});
    EXPECT_TRUE(confirmed.scans[2].isRegistered) << confirmed.scans[2].why;

    // Nor of two that are each sure and differ.
    third.result.verdict = PairVerdict::registered;
    third.result.plausible = {shifted};
    third.result.best.aFromB = shifted;
    const Registration torn = joinScans(views, {first, second, third});
    EXPECT_EQ(std::count_if(torn.scans.begin(), torn.scans.end(), [](const auto& scan) { return scan.isRegistered; }),
              2);
}

TEST(Registration, ScansOfDifferentPlacesStayWhereTheyWereSaidToBe) {
    BoxPlace other;
    other.addHall({0, 0, 0}, {9, 3.4, 3.6}).add({2, 0, 0}, {3, 1, 1.5}).add({6, 2.4, 0}, {9, 3.4, 2});
    const SyntheticScene here = office(), there = other.build();
    const Pose given = setUpAt({20, 5, 1}, 9);
    const std::vector<ScanView> views{viewFrom(here, setUpAt({1.4, 1.1, 1.5}, 1), 1),
                                      viewFrom(there, setUpAt({4.4, 1.9, 1.6}, 2), 2, given)};
    const Registration found = registerScans(views);
    EXPECT_NE(found.pairs[0].result.verdict, PairVerdict::registered);
    EXPECT_FALSE(found.scans[0].isRegistered);
    EXPECT_FALSE(found.scans[1].isRegistered);
    EXPECT_EQ(toMatrix(found.scans[1].worldFromScanner), toMatrix(given));
    EXPECT_THAT(found.scans[1].why, HasSubstr("'scan2' stands where it was said to stand"));
}

TEST(Registration, AScanInAMirrorIsNamed) {
    const SyntheticScene place = office();
    const ScanView a = viewFrom(place, setUpAt({1.4, 1.1, 1.5}, 1), 1),
                   b = viewFrom(place, setUpAt({4.4, 2.9, 1.6}, 2), 2);
    const ScanView turnedRound = mirrored(b);
    EXPECT_EQ(mirrored(turnedRound).panorama.cells(5, 100).point, b.panorama.cells(5, 100).point);
    const Registration found = registerScans({a, turnedRound});
    EXPECT_FALSE(found.scans[1].isRegistered);
    EXPECT_THAT(found.scans[1].why, HasSubstr("one axis of the one or of the other is turned round"));
}

TEST(Registration, MillimetresAreNoticed) {
    const SyntheticScene place = office();
    Scan scan = scanFrom(place, setUpAt({4.4, 2.9, 1.6}, 2), 2);
    for (glm::vec3& p : scan.pointsInScanner)
        p *= 1000.0f;
    const Registration found = registerScans({viewFrom(place, setUpAt({1.4, 1.1, 1.5}, 1), 1), viewOf(scan)});
    ASSERT_FALSE(found.remarks.empty());
    EXPECT_THAT(found.remarks[0], HasSubstr("One of the scans 'scan1' and 'scan2' is in other units"));
    EXPECT_FALSE(found.scans[1].isRegistered);
}

TEST(Registration, OnePlaneOrNoPointLeavesAScanFree) {
    const SyntheticScene floor = BoxPlace().add({-20, -20, -1}, {20, 20, 0}).build();
    Scan empty;
    empty.name = "empty";
    const Registration found = registerScans(
        {viewFrom(floor, setUpAt({0, 0, 1.5}, 1), 1), viewFrom(floor, setUpAt({2, 1, 1.5}, 2), 2), viewOf(empty)});
    EXPECT_THAT(found.scans[0].why, HasSubstr("all its planes face one way"));
    EXPECT_THAT(found.scans[1].why, HasSubstr("all its planes face one way"));
    EXPECT_THAT(found.scans[2].why, HasSubstr("no plane was found in it"));
}

TEST(Registration, TwoScansFromOnePlaceAreSaidToBe) {
    const SyntheticScene place = office();
    const Registration found = registerScans(
        {viewFrom(place, setUpAt({1.4, 1.1, 1.5}, 1), 1), viewFrom(place, setUpAt({1.4, 1.1, 1.5}, 2), 2)});
    ASSERT_TRUE(found.scans[1].isRegistered) << found.scans[1].why;
    ASSERT_EQ(found.remarks.size(), 1u);
    EXPECT_THAT(found.remarks[0], HasSubstr("from the same place"));
}

std::vector<std::size_t> whoIsLost(const Registration& found) {
    std::vector<std::size_t> lost;
    for (std::size_t i = 0; i < found.scans.size(); ++i)
        if (found.scans[i].isLost) lost.push_back(i);
    return lost;
}

TEST(Registration, GroupsThatNothingJoinsAreSaidToBe) {
    const SyntheticScene place = office();
    std::vector<ScanView> views{viewFrom(place, setUpAt({1.4, 1.1, 1.5}, 1), 1),
                                viewFrom(place, setUpAt({4.4, 2.9, 1.6}, 2), 2)};
    const PairResult pair = registerPair(views[0], views[1], std::nullopt);
    ASSERT_EQ(pair.verdict, PairVerdict::registered);
    for (const std::size_t i : {0, 1}) { // the same rooms elsewhere, of which nobody knows where
        views.push_back(views[i]);
        views.back().name = "other" + std::to_string(i);
    }
    const Registration apart = joinScans(views, {{0, 1, pair}, {2, 3, pair}});
    ASSERT_EQ(apart.remarks.size(), 3u);
    EXPECT_THAT(apart.remarks[0], HasSubstr("2 groups that nothing joins: 'scan1', 'scan2'; and 'other0', 'other1'"));
    EXPECT_THAT(apart.remarks[1], HasSubstr("Nothing says where scans 'other0', 'other1' stand to the others"));
    EXPECT_THAT(apart.remarks[2], HasSubstr("can be built by themselves"));
    EXPECT_EQ(whoIsLost(apart), (std::vector<std::size_t>{2, 3}));

    // Of each group somebody says where one of its scans stands.
    views[1].givenWorldFromScanner = setUpAt({20, 5, 1}, 9);
    views[3].givenWorldFromScanner = setUpAt({40, 5, 1}, 8);
    const Registration said = joinScans(views, {{0, 1, pair}, {2, 3, pair}});
    EXPECT_TRUE(whoIsLost(said).empty());
    ASSERT_EQ(said.remarks.size(), 1u);
    EXPECT_THAT(said.remarks[0], HasSubstr("as their files say"));
    EXPECT_EQ(toMatrix(said.scans[1].worldFromScanner), toMatrix(views[1].givenWorldFromScanner)) << "the one that is";
    EXPECT_EQ(said.scans[0].group, 1u);
    views[3].givenWorldFromScanner = {};
    EXPECT_EQ(whoIsLost(joinScans(views, {{0, 1, pair}, {2, 3, pair}})), (std::vector<std::size_t>{2, 3}));

    // Of a pair that somebody knows nothing is asked.
    int asked = 0;
    const FindPair findPair = [&](std::size_t, std::size_t, const std::optional<Pose>&) {
        ++asked;
        return PairResult{};
    };
    const Registration known = registerScans({views[0], views[1]}, {}, findPair, {{1, 0, {}}});
    EXPECT_EQ(asked, 0);
    EXPECT_EQ(known.pairs.size(), 1u);

    const Registration one = joinScans({views[0], views[1]}, {{0, 1, pair}});
    EXPECT_TRUE(one.remarks.empty());
}

TEST(Registration, WhatNobodySaysWhereItStandsIsLost) {
    const SyntheticScene place = office();
    const Pose a = setUpAt({1.4, 1.1, 1.5}, 1), b = setUpAt({4.4, 2.9, 1.6}, 2);
    Scan nothing;
    nothing.name = "nothing";
    const Registration found = registerScans({viewFrom(place, a, 1), viewOf(nothing), viewFrom(place, b, 2)});
    EXPECT_TRUE(found.scans[2].isRegistered) << found.scans[2].why;
    EXPECT_EQ(whoIsLost(found), (std::vector<std::size_t>{1}));
    EXPECT_THAT(found.scans[1].why,
                HasSubstr("'nothing' is left out, since nothing says where it stands to the others: no plane"));
    EXPECT_THAT(found.remarks.back(), HasSubstr("--register given draws all"));
}

TEST(Registration, AScanWithoutPoseIsNotTakenToStandAtTheOrigin) {
    const SyntheticScene place = office();
    // Two files have no pose, one has: what it says must not pull the others towards where they never stood.
    const std::vector<ScanView> views{viewFrom(place, setUpAt({1.4, 1.1, 1.5}, 1), 1),
                                      viewFrom(place, setUpAt({1.9, 1.4, 1.5}, 2), 2),
                                      viewFrom(place, setUpAt({4.4, 2.9, 1.6}, 3), 3, setUpAt({20, 5, 1}, 9))};
    const Registration found = registerScans(views);
    for (const PairOutcome& pair : found.pairs)
        EXPECT_FALSE(pair.result.isDecidedByGivenPose);
    EXPECT_TRUE(found.scans[1].isRegistered) << found.scans[1].why;
}

TEST(Registration, OneScanAloneOrNoneIsNoTrouble) {
    EXPECT_TRUE(registerScans({}).scans.empty());
    const Registration found = registerScans({viewFrom(office(), setUpAt({1.4, 1.1, 1.5}, 1), 1)});
    EXPECT_THAT(found.scans.at(0).why, HasSubstr("it was compared with no other"));
}

} // namespace
} // namespace scene
