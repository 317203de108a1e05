// Groups of scans between which no pair is sure.

#include "scene/align/registration.h"

#include "tests/scene/align/scanned_places.h"

#include <gtest/gtest.h>

#include <optional>
#include <vector>

namespace scene {
namespace {

/// Four scans of one place: pairs 0, 1 and 2, 3 are sure, pairs 0, 2 and 1, 3 fit at several places each.
class FourScans : public testing::Test {
  protected:
    static constexpr std::size_t kScans = 4;

    void lookAt(const SyntheticScene& place, const std::vector<glm::dvec3>& from) {
        for (std::uint32_t i = 0; i < kScans; ++i) {
            truth_.push_back(setUpAt(from[i], i + 1));
            Scan scan = scanFrom(place, truth_[i], i);
            scan.worldFromScanner = {};
            views_.push_back(viewOf(scan));
        }
    }

    Pose between(std::size_t a, std::size_t b) const { return inverse(truth_[a]) * truth_[b]; }
    /// The second scan moved along an axis of the world.
    Pose moved(std::size_t a, std::size_t b, const glm::dvec3& by) const {
        Pose worldFromB = truth_[b];
        worldFromB.translation += by;
        return inverse(truth_[a]) * worldFromB;
    }

    static PairOutcome outcome(std::size_t a, std::size_t b, PairVerdict verdict, std::vector<Pose> plausible) {
        PairOutcome pair{a, b, {}};
        pair.result.verdict = verdict;
        pair.result.best.aFromB = plausible[0];
        pair.result.best.evidence.agreeing = 0.4;
        pair.result.plausible = std::move(plausible);
        return pair;
    }
    std::vector<PairOutcome> pairs(const std::vector<Pose>& of02, const std::vector<Pose>& of13) const {
        return {outcome(0, 1, PairVerdict::registered, {between(0, 1)}),
                outcome(2, 3, PairVerdict::registered, {between(2, 3)}), outcome(0, 2, PairVerdict::ambiguous, of02),
                outcome(1, 3, PairVerdict::ambiguous, of13)};
    }
    /// Where the scans stand to the first, as far as they are joined to it.
    std::vector<std::optional<Pose>> join(const std::vector<Pose>& of02, const std::vector<Pose>& of13) const {
        return joined(pairs(of02, of13));
    }
    std::vector<std::optional<Pose>> joined(std::vector<PairOutcome> known) const {
        ScanGroups groups(views_, known);
        groups.joinBySure();
        groups.joinBySeveral();
        EXPECT_EQ(groups.groupOf(0), groups.groupOf(1));
        std::vector<std::optional<Pose>> found(kScans);
        for (std::size_t i = 0; i < kScans; ++i)
            if (groups.groupOf(i) == groups.groupOf(0))
                found[i] = inverse(groups.groupFromScanner(0)) * groups.groupFromScanner(i);
        return found;
    }

    void expectAllRight(const std::vector<std::optional<Pose>>& found) const {
        for (std::size_t i = 0; i < kScans; ++i) {
            ASSERT_TRUE(found[i]) << i;
            EXPECT_LT(metresBetween(*found[i], between(0, i)), 0.003);
            EXPECT_LT(degreesBetween(*found[i], between(0, i)), 0.03);
        }
    }
    static void expectApart(const std::vector<std::optional<Pose>>& found) {
        EXPECT_TRUE(found[1]);
        EXPECT_FALSE(found[2] || found[3]);
    }

    std::vector<Pose> truth_;
    std::vector<ScanView> views_;
};

TEST_F(FourScans, AreJoinedAtTheOnePlaceThatSeveralPairsKnow) {
    lookAt(office(), {{1.4, 1.1, 1.5}, {4.4, 2.9, 1.6}, {2.5, 3.6, 1.4}, {1.9, 1.4, 1.5}});
    const glm::dvec3 right(0), left(-0.6, 0, 0), up(0, 0, 0.5);
    const std::vector<Pose> of02{moved(0, 2, left), moved(0, 2, right)}, of13{moved(1, 3, right), moved(1, 3, up)};
    expectAllRight(join(of02, of13));
    // What is told of a pair that was settled is how it stands now.
    const Registration found = joinScans(views_, pairs(of02, of13));
    EXPECT_TRUE(found.scans[3].isRegistered);
    for (const std::size_t k : {2u, 3u}) {
        EXPECT_TRUE(found.pairs[k].isUsed);
        EXPECT_TRUE(found.pairs[k].isSettled);
        EXPECT_LT(metresBetween(found.pairs[k].result.best.aFromB, between(found.pairs[k].a, found.pairs[k].b)), 0.003);
    }
    // Where both know of two, the scans of both groups tell which cannot be.
    expectAllRight(join({moved(0, 2, left), moved(0, 2, right)}, {moved(1, 3, left), moved(1, 3, right)}));

    // What somebody says of a pair is not denied by what was found of another.
    std::vector<PairOutcome> given = pairs({moved(0, 2, right)}, {moved(1, 3, left), moved(1, 3, up)});
    given[2].isGiven = true;
    given[2].result.verdict = PairVerdict::registered;
    EXPECT_TRUE(joined(given)[2]);
    given[2].isGiven = false;
    expectApart(joined(given));

    // They stay apart where pairs agree on what cannot be, or on nothing.
    expectApart(join({moved(0, 2, left), moved(0, 2, up)}, {moved(1, 3, left), moved(1, 3, up)}));
    expectApart(join({moved(0, 2, left), moved(0, 2, right)}, {moved(1, 3, up), moved(1, 3, left)}));
}

TEST_F(FourScans, StayApartWhereThePlaceRepeats) {
    BoxPlace pillars; // every three metres, farther than anybody sees
    pillars.addHall({-30, -1.3, 0}, {30, 1.3, 2.8});
    for (int i = -9; i <= 9; ++i)
        for (const double y : {-1.3, 1.0})
            pillars.add({3 * i - 0.2, y, 0}, {3 * i + 0.2, y + 0.3, 2.8});
    lookAt(pillars.build(), {{1.2, 0.1, 1.5}, {2.0, -0.2, 1.6}, {4.6, 0.0, 1.4}, {5.4, 0.2, 1.5}});
    const glm::dvec3 here(0), next(3, 0, 0);
    expectApart(join({moved(0, 2, here), moved(0, 2, next)}, {moved(1, 3, next), moved(1, 3, here)}));
}

} // namespace
} // namespace scene
