// Next scans against places of known geometry: what a proposal is said to reveal is held against what a simulated scan
// from there does reveal.

#include "scene/plan/next_scan.h"

#include "scene/image_store.h"
#include "scene/overlap.h"
#include "scene/project/cube_faces.h"
#include "scene/refine/cover.h"
#include "scene/refine/skins.h"
#include "scene/synthetic.h"
#include "scene/synthetic_model.h"

#include <cmath>
#include <cstdio>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

namespace scene {
namespace {

constexpr int kColumns = 600, kRows = 250;

/// World +Z up; walk's floor at z = 0.
Pose walkFromUpright() {
    return {glm::dmat3(1, 0, 0, 0, 0, -1, 0, 1, 0), glm::dvec3(0)};
}

Coverage scanFrom(const SyntheticScene& place, const std::vector<glm::dvec3>& stood) {
    std::vector<DepthImage> images;
    for (std::size_t i = 0; i < stood.size(); ++i) {
        Scan scan = simulateScan(place, {glm::dmat3(1), stood[i]}, kColumns, kRows);
        scan.name = "scan" + std::to_string(i);
        for (DepthImage& face : projectToCubeFaces(scan).faces)
            images.push_back(std::move(face));
    }
    ImageStore store(images);
    std::vector<ImageOutline> outlines;
    for (const DepthImage& image : images)
        outlines.push_back(outlineOf(image));
    const auto partners = findPartners(outlines);
    tbb::parallel_for(std::size_t{0}, images.size(), [&](std::size_t i) {
        SkinFigures figures;
        images[i].flags = markSkins(store, i, partners[i], {}, figures);
    });
    ImageStore marked(images);
    CoverFigures figures;
    return cover(marked, {}, figures);
}

/// What a plan foretold of its first proposals, and what simulated scans from there did.
struct Outcome {
    NextScanPlan plan;
    std::vector<double> revealed; ///< cubic metres, within the plan's bounds
    double ratio() const { return plan.scans.at(0).revealsCubicMetres / revealed.at(0); }
};

Outcome scanAsPlanned(const SyntheticScene& place, std::vector<glm::dvec3> stood, int count) {
    NextScanOptions options;
    options.count = count;
    Outcome outcome{planNextScans(scanFrom(place, stood), walkFromUpright(), stood, options), {}};
    double before = outcome.plan.unseenCubicMetres;
    for (const NextScan& scan : outcome.plan.scans) {
        stood.push_back(scan.positionInWorld);
        const double after = unseenWithin(scanFrom(place, stood), outcome.plan.bounds);
        outcome.revealed.push_back(before - after);
        before = after;
        std::printf("%s: %.1f m3 unseen; at %.2f %.2f %.2f: foretold %.2f m3 (%.1f %%), true %.2f\n",
                    place.model().name.c_str(), outcome.plan.unseenCubicMetres, scan.positionInWorld.x,
                    scan.positionInWorld.y, scan.positionInWorld.z, scan.revealsCubicMetres, 100 * scan.revealsShare,
                    outcome.revealed.back());
    }
    return outcome;
}

/// Rooms of boxes, turned and moved, so that no wall lies along the world's axes.
class Place {
  public:
    Place(const char* name, double yawRadians, const glm::dvec3& at) : worldFromPlace_(standing(at, yawRadians)) {
        model_.name = name;
        model_.lightSpacing = 2;
        material_ = addMaterial(model_, {});
    }
    Place& box(const glm::dvec3& low, const glm::dvec3& high) {
        addBox(model_, worldFromPlace_, low, high, material_);
        return *this;
    }
    /// Walls, floor and ceiling about that much ground.
    Place& shell(double x, double y, double height) {
        box({-1, -1, -1}, {x + 1, y + 1, 0}).box({-1, -1, height}, {x + 1, y + 1, height + 1});
        box({-1, -1, 0}, {0, y + 1, height}).box({x, -1, 0}, {x + 1, y + 1, height});
        return box({0, -1, 0}, {x, 0, height}).box({0, y, 0}, {x, y + 1, height});
    }
    glm::dvec3 at(double x, double y, double z) const { return worldFromPlace_ * glm::dvec3(x, y, z); }
    glm::dvec3 back(const glm::dvec3& pInWorld) const { return inverse(worldFromPlace_) * pInWorld; }
    SyntheticScene build() { return SyntheticScene(std::move(model_)); }

  private:
    SyntheticModel model_;
    Pose worldFromPlace_;
    int material_ = 0;
};

/// 8 x 6 x 2.8 m; a wall from the long side hides a corner, 2.8 x 3.4 m, from a scan at (2, 4).
Place hiddenCorner() {
    Place place("hidden corner", 0.6, {500, -300, 0});
    place.shell(8, 6, 2.8).box({5.0, 2.6, 0}, {5.2, 6, 2.8});
    return place;
}

/// 9 x 7 x 3 m; a pillar 1.6 m square keeps a scan at (2, 3.5) from seeing what is behind it.
Place roomWithPillar() {
    Place place("pillar", 0.25, {-20, 40, 0});
    place.shell(9, 7, 3).box({3.7, 2.7, 0}, {5.3, 4.3, 3});
    return place;
}

/// Two corridors 2 m wide that meet at a right angle; the second goes round the corner.
Place bend() {
    Place place("bend", -0.35, {0, 0, 0});
    place.shell(10, 8, 2.6).box({0, 2, 0}, {8, 8, 2.6});
    return place;
}

bool sees(const SyntheticScene& place, const glm::dvec3& from, const glm::dvec3& to) {
    const auto hit = castRay(place, from, to - from);
    return !hit || hit->distanceMetres > glm::distance(from, to) - 1e-6;
}

/// Of the points of a part of a place that are hidden from one place, the share that another sees.
double shareSeenOf(const SyntheticScene& truth, const Place& place, const glm::dvec3& low, const glm::dvec3& high,
                   const glm::dvec3& hiddenFrom, const glm::dvec3& seenFrom) {
    int hidden = 0, seen = 0;
    for (int i = 0; i < 1000; ++i) {
        const glm::dvec3 share((i % 10 + 0.5) / 10, (i / 10 % 10 + 0.5) / 10, (i / 100 + 0.5) / 10);
        const glm::dvec3 p = low + share * (high - low), inWorld = place.at(p.x, p.y, p.z);
        if (sees(truth, hiddenFrom, inWorld)) continue;
        ++hidden;
        seen += sees(truth, seenFrom, inWorld) ? 1 : 0;
    }
    EXPECT_GT(hidden, 500) << "the part is not hidden";
    return seen / static_cast<double>(hidden);
}

TEST(NextScan, TheFirstProposalSeesIntoAHiddenCorner) {
    Place place = hiddenCorner();
    const SyntheticScene truth = place.build();
    const glm::dvec3 stood = place.at(2, 4, 1.5);
    const Outcome outcome = scanAsPlanned(truth, {stood}, 1);
    ASSERT_EQ(outcome.plan.scans.size(), 1u);
    const NextScan& first = outcome.plan.scans[0];
    EXPECT_GT(shareSeenOf(truth, place, {5.3, 3, 0.1}, {7.9, 5.9, 2.7}, stood, first.positionInWorld), 0.8);
    EXPECT_NEAR(first.positionInWalk.y, 1.5, 0.01);
    EXPECT_NEAR(outcome.ratio(), 1, 0.2) << "foretold against true";
}

TEST(NextScan, TheFirstProposalSeesBehindAPillar) {
    Place place = roomWithPillar();
    const SyntheticScene truth = place.build();
    const glm::dvec3 stood = place.at(2, 3.5, 1.5);
    const Outcome outcome = scanAsPlanned(truth, {stood}, 1);
    ASSERT_EQ(outcome.plan.scans.size(), 1u);
    EXPECT_GT(shareSeenOf(truth, place, {5.4, 2.8, 0.1}, {8.9, 4.2, 2.9}, stood, outcome.plan.scans[0].positionInWorld),
              0.5);
    EXPECT_NEAR(outcome.ratio(), 1, 0.2) << "foretold against true";
}

TEST(NextScan, TheFirstProposalSeesRoundABend) {
    // All but a sliver of the second corridor lies beyond the box about what was seen: no volume is foretold of it.
    Place place = bend();
    const SyntheticScene truth = place.build();
    const std::vector<glm::dvec3> stood{place.at(1.5, 1, 1.5)};
    const NextScanPlan plan = planNextScans(scanFrom(truth, stood), walkFromUpright(), stood, {});
    ASSERT_FALSE(plan.scans.empty());
    EXPECT_GT(shareSeenOf(truth, place, {8.1, 2.5, 0.1}, {9.9, 7.9, 2.5}, stood[0], plan.scans[0].positionInWorld),
              0.8);
}

TEST(NextScan, AFurnishedRoomIsForetoldRoughly) {
    const SyntheticScene room = makeRoom();
    const Outcome outcome = scanAsPlanned(room, {scanPositions(room).at(0).translation}, 1);
    ASSERT_EQ(outcome.plan.scans.size(), 1u);
    EXPECT_GT(outcome.ratio(), 0.5);
    EXPECT_LT(outcome.ratio(), 2);
}

TEST(NextScan, SeveralDoNotRevealTheSameTwice) {
    Place place = hiddenCorner();
    const SyntheticScene truth = place.build();
    const std::vector<glm::dvec3> stood{place.at(2, 4, 1.5)};
    NextScanOptions options;
    options.count = 8;
    options.leastShare = options.leastShareOfBox = 0;
    const NextScanPlan plan = planNextScans(scanFrom(truth, stood), walkFromUpright(), stood, options);
    ASSERT_EQ(plan.scans.size(), 8u);
    double sum = 0;
    for (const NextScan& scan : plan.scans)
        sum += scan.revealsShare;
    EXPECT_LT(sum, 1.05);
    EXPECT_LT(plan.scans[1].revealsCubicMetres, 0.15 * plan.scans[0].revealsCubicMetres)
        << "one scan sees nearly all of the corner";
}

TEST(NextScan, NothingIsProposedWhereNothingIsLeft) {
    Place place("plain", 0.2, {0, 0, 0});
    const SyntheticScene truth = place.shell(6, 5, 2.6).build();
    const std::vector<glm::dvec3> stood{place.at(2, 2, 1.5), place.at(4, 3, 1.6)};
    const NextScanPlan plan = planNextScans(scanFrom(truth, stood), walkFromUpright(), stood, {});
    EXPECT_GT(plan.candidates, 50u);
    EXPECT_TRUE(plan.scans.empty());
    EXPECT_LT(plan.unseenCubicMetres, 0.02 * plan.bounds.cubicMetres());
}

TEST(NextScan, TheSameOnAnyNumberOfThreads) {
    Place place = hiddenCorner();
    const SyntheticScene truth = place.build();
    const std::vector<glm::dvec3> stood{place.at(2, 4, 1.5)};
    const Coverage coverage = scanFrom(truth, stood);
    NextScanOptions options;
    options.mostCandidates = 60;
    const auto planOn = [&](std::size_t threads) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        return planNextScans(coverage, walkFromUpright(), stood, options);
    };
    const NextScanPlan one = planOn(1), many = planOn(16);
    EXPECT_EQ(one.unseenCubicMetres, many.unseenCubicMetres);
    EXPECT_EQ(one.candidates, many.candidates);
    EXPECT_LE(one.candidates, 60u);
    ASSERT_EQ(one.scans.size(), many.scans.size());
    for (std::size_t i = 0; i < one.scans.size(); ++i) {
        EXPECT_EQ(one.scans[i].positionInWorld, many.scans[i].positionInWorld);
        EXPECT_EQ(one.scans[i].revealsCubicMetres, many.scans[i].revealsCubicMetres);
    }
}

Coverage cubeOf(Observed kind) {
    Coverage coverage{{-2, -2, -1}, 4, std::vector<CoverageNode>(1)};
    (kind == Observed::unseen ? coverage.nodes[0].unseen : coverage.nodes[0].surface) =
        kind == Observed::empty ? 0 : ~std::uint64_t{0};
    return coverage;
}

TEST(NextScan, PlacesThatAreNone) {
    for (const Observed kind : {Observed::unseen, Observed::surface, Observed::empty}) {
        const NextScanPlan plan = planNextScans(cubeOf(kind), walkFromUpright(), {}, {});
        EXPECT_EQ(plan.candidates, 0u);
        EXPECT_TRUE(plan.scans.empty());
        EXPECT_EQ(plan.bounds.isEmpty(), kind != Observed::empty);
    }
    EXPECT_TRUE(planNextScans({}, walkFromUpright(), {}, {}).scans.empty());
}

TEST(NextScan, NoTripodStandsOnABedAndOneMayStandOnAPavement) {
    Place bedroom("bedroom", 0.3, {20, 10, 0});
    const glm::dvec3 bedFrom(2.5, 1, 0), bedTo(4.1, 3, 0.42);
    const SyntheticScene truth = bedroom.shell(8, 6, 2.6).box(bedFrom, bedTo).box({5.5, 3.5, 0}, {8, 6, 0.15}).build();
    const std::vector<glm::dvec3> stood{bedroom.at(4.6, 4, 1.6), bedroom.at(1, 2, 1.6), bedroom.at(3.3, 0.5, 1.6)};
    const Coverage coverage = scanFrom(truth, stood);
    const UprightBounds bounds = findUprightBounds(coverage, walkFromUpright());
    int onBed = 0, onPavement = 0, besideBed = 0;
    const auto count = [&](const NextScanOptions& options) {
        onBed = onPavement = besideBed = 0;
        for (const glm::dvec3& world : findStandingPlaces(coverage, walkFromUpright(), bounds, options)) {
            const glm::dvec3 p = bedroom.back(world);
            const bool overBed = p.x > bedFrom.x && p.x < bedTo.x && p.y > bedFrom.y && p.y < bedTo.y;
            onBed += overBed, onPavement += p.x > 5.5 && p.y > 3.5;
            besideBed += !overBed && p.x > bedFrom.x - 1 && p.x < bedTo.x + 1 && p.y < bedTo.y + 1;
        }
    };
    count({});
    EXPECT_EQ(onBed, 0);
    EXPECT_GT(onPavement, 0);
    EXPECT_GT(besideBed, 0);
    NextScanOptions unasked;
    unasked.mostRaisedMetres = unasked.floorToleranceMetres;
    count(unasked);
    EXPECT_GT(onBed, 0) << "or the bed was never a place";
}

TEST(NextScan, NoMoreThanThereArePlaces) {
    // A floor over the lowest quarter, seen-empty space over it but for one unseen column.
    Coverage coverage{{-2, -2, -1}, 4, std::vector<CoverageNode>(1)};
    coverage.nodes[0].surface = 0xffff;
    for (int z = 1; z < 4; ++z)
        coverage.nodes[0].unseen |= coverageMask(coverageBit(3, 3, z));
    NextScanOptions options;
    options.count = 1000;
    options.leastShare = options.leastShareOfBox = 0;
    const NextScanPlan plan = planNextScans(coverage, walkFromUpright(), std::vector<glm::dvec3>{{0, 0, 1.5}}, options);
    EXPECT_GT(plan.candidates, 0u);
    EXPECT_EQ(plan.scans.size(), plan.candidates);
    EXPECT_NEAR(plan.unseenCubicMetres, 3, 0.2);
    options.count = 0;
    EXPECT_TRUE(planNextScans(coverage, walkFromUpright(), {}, options).scans.empty());
    options.tripodMetres = 2.9; // among the highest cells
    EXPECT_GT(planNextScans(coverage, walkFromUpright(), {}, options).candidates, 0u);
    coverage.nodes[0].surface = 0; // no floor any more
    EXPECT_EQ(planNextScans(coverage, walkFromUpright(), {}, options).candidates, 0u);
}

TEST(UprightBounds, LieAlongTheWalls) {
    Place place("plain", 0.5, {100, 50, 0});
    const SyntheticScene truth = place.shell(7, 4, 2.5).build();
    const UprightBounds bounds = findUprightBounds(scanFrom(truth, {place.at(3, 2, 1.5)}), walkFromUpright());
    EXPECT_NEAR(std::max(bounds.size.x, bounds.size.z), 7, 0.15);
    EXPECT_NEAR(std::min(bounds.size.x, bounds.size.z), 4, 0.15);
    EXPECT_NEAR(bounds.size.y, 2.5, 0.15);
    EXPECT_TRUE(bounds.holds(place.at(0.2, 0.2, 0.2)));
    EXPECT_FALSE(bounds.holds(place.at(-0.2, 2, 1)));
}

} // namespace
} // namespace scene
