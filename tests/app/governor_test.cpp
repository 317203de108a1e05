// The governor under simulated loads.

#include "app/governed_quality.h"
#include "app/governor.h"
#include "app/quality_file.h"
#include "tests/repetitions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

namespace app {
namespace {

const std::vector<double> kCosts{1, 0.85, 0.7, 0.6, 0.5, 0.3, 0.2};

/// A device that takes load(frame) times the true cost of the rung, told `lag` frames later.
struct Device {
    std::function<double(int)> load;
    std::vector<double> costs = kCosts;
    int lag = 2;
};

struct Ride {
    std::vector<int> rungs;   ///< of each frame
    std::vector<double> took; ///< milliseconds of each
    Governor governor;
};

GovernorOptions tenMilliseconds() {
    GovernorOptions options;
    options.budgetMilliseconds = 10;
    return options;
}

Ride ride(const Device& device, int frames, Governor governor = Governor(kCosts, tenMilliseconds())) {
    Ride ride{{}, {}, std::move(governor)};
    for (int frame = 0; frame < frames; ++frame) {
        const int known = frame - device.lag;
        if (known >= 0)
            ride.governor.tell(static_cast<std::uint64_t>(known), ride.took[static_cast<std::size_t>(known)]);
        const int rung = ride.governor.rungFor(static_cast<std::uint64_t>(frame));
        ride.rungs.push_back(rung);
        ride.took.push_back(device.load(frame) * device.costs[static_cast<std::size_t>(rung)]);
    }
    return ride;
}

int lateFrames(const Ride& ride, double budget, int from = 0) {
    return static_cast<int>(
        std::count_if(ride.took.begin() + from, ride.took.end(), [&](double ms) { return ms > budget; }));
}

TEST(Governor, LeavesAloneWhatHoldsTheRate) {
    const Ride calm = ride({.load = [](int) { return 8.9; }}, 2000);
    EXPECT_TRUE(calm.governor.changes().empty());
    EXPECT_EQ(calm.governor.frames()[0], 2000u);
}

TEST(Governor, FallsAsFarAsIsNeededWithinAFewFrames) {
    for (const double load : {10.0, 12.0, 15.0, 20.0, 40.0}) {
        const Ride fall = ride({.load = [&](int frame) { return frame < 100 ? 5 : load; }}, 130);
        EXPECT_EQ(fall.rungs[99], 0);
        // Two frames pass until it is told, three must be late, two more were begun meanwhile.
        EXPECT_LE(lateFrames(fall, 10, 0), 7) << load;
        EXPECT_LE(fall.took.back(), 10 * 0.9) << load;
        EXPECT_EQ(fall.governor.changes().size(), 1u) << load << ": the costs are known, so one change must do";
        // No farther than needed.
        EXPECT_GT(load * kCosts[static_cast<std::size_t>(fall.rungs.back() - 1)], 10 * 0.9) << load;
    }
}

TEST(Governor, NeverGoesBelowTheFloorNorAboveWhatWasAsked) {
    const Ride hopeless = ride({.load = [](int) { return 1000.0; }}, 500);
    EXPECT_EQ(hopeless.rungs.back(), static_cast<int>(kCosts.size()) - 1);
    const Ride idle = ride({.load = [](int frame) { return frame < 100 ? 1000.0 : 0.0; }}, 1000);
    EXPECT_EQ(idle.rungs.back(), 0) << "quality comes back when there is room";
    for (const int rung : idle.rungs)
        ASSERT_TRUE(rung >= 0 && rung < static_cast<int>(kCosts.size()));
}

TEST(Governor, SingleLateFramesAreForgiven) {
    const Ride spikes = ride({.load = [](int frame) { return frame % 7 < 2 ? 50.0 : 7.0; }}, 2000);
    EXPECT_TRUE(spikes.governor.changes().empty()) << "two of seven are not three of five";
}

TEST(Governor, OneLateFrameInFiftyIsTooMany) {
    // Everything else is in time by far, and three of five are never late.
    const auto seldom = [](int every, double late) {
        return [=](int frame) { return frame % every == every - 1 ? late : 7.0; };
    };
    const int minute = 6000;
    const Ride fiftieth = ride({.load = seldom(50, 12)}, 10 * minute);
    EXPECT_LT(lateFrames(fiftieth, 10), 0.005 * 10 * minute);
    EXPECT_EQ(fiftieth.rungs.back(), 2) << "12 ms * 0.7 leaves a tenth, 12 ms * 0.85 does not";

    const Ride hundredAndFiftieth = ride({.load = seldom(150, 14)}, minute);
    EXPECT_TRUE(hundredAndFiftieth.governor.changes().empty()) << "less than one in a hundred is forgiven";
    const Ride stalls = ride({.load = seldom(50, 21)}, minute);
    EXPECT_TRUE(stalls.governor.changes().empty()) << "no rung mends what the machine does meanwhile";
    // Where no rung is in time, and where seldom comes to an end.
    const Ride twice = ride({.load = seldom(50, 19.9), .costs = {1, 0.99, 0.98, 0.97, 0.96, 0.95, 0.94}}, minute);
    EXPECT_EQ(*std::max_element(twice.rungs.begin(), twice.rungs.end()), static_cast<int>(kCosts.size()) - 1);
    const Ride ending =
        ride({.load = [&](int frame) { return frame < minute ? seldom(50, 14)(frame) : 7.0; }}, 3 * minute);
    EXPECT_EQ(ending.rungs.back(), 0);
}

TEST(Governor, DoesNotSwingBetweenTwoRungs) {
    // On every load, noise of 10 % included, and even where the real costs are not those it was told.
    for (const double wrong : {0.7, 1.0, 1.4})
        for (double load = 4; load < 45; load *= 1.11) {
            std::mt19937 random(static_cast<unsigned>(100 * load));
            std::uniform_real_distribution<double> noise(0.95, 1.05);
            Device device{.load = [&](int) { return load * noise(random); }};
            for (double& cost : device.costs)
                cost = std::pow(cost, wrong);
            const int frames = 100 * 60 * tests::repetitions(3);
            const Ride steady = ride(device, frames);
            EXPECT_LT(steady.governor.changes().size(), 16u + 2 * frames / 1920)
                << load << ", costs to the power " << wrong;
            // Late are the first, and a few after each climb that failed.
            EXPECT_LT(lateFrames(steady, 10), 0.01 * frames + (load * device.costs.back() > 9 ? frames : 0))
                << load << ", costs to the power " << wrong;
        }
}

TEST(Governor, FollowsALoadThatComesAndGoes) {
    // Somebody walks up to a wall and away again, slowly.
    const Ride walk = ride({.load = [](int frame) { return 9 + 6 * std::sin(frame / 300.0); }}, 20000);
    EXPECT_LT(lateFrames(walk, 10), 0.02 * 20000);
    EXPECT_GT(walk.governor.frames()[0], 20000 / 4u) << "quality must come back each time";
}

/// Where samples are what takes time, fewer pixels save nothing until coarser samples come with them.
const std::vector<double> kSamplesCount{1, 1.1, 1.05, 1.05, 0.5, 0.3, 0.2};

TEST(Governor, FallsTwiceAsFarWhereAFallDidNotHelp) {
    const Ride heavy = ride({.load = [](int) { return 10.5; }, .costs = kSamplesCount}, 100);
    // One rung by the guess, then two, then four; four frames each until that is known.
    EXPECT_EQ(lateFrames(heavy, 10), 3 * 4);
    EXPECT_LE(heavy.took.back(), 10 * 0.9);
}

TEST(Governor, RemembersForAWhileWhatAClimbCostInVain) {
    std::mt19937 random(12);
    std::uniform_real_distribution<double> noise(0.95, 1.05);
    const int minutes = 3, frames = minutes * 6000;
    Ride calm = ride({.load = [&](int) { return 12 * noise(random); }, .costs = kSamplesCount}, frames);
    EXPECT_LT(calm.governor.frames()[3], 40u) << "it takes 12.6 ms there and not 7.2, as was guessed";
    EXPECT_GT(calm.governor.frames()[4], frames * 0.95) << "the best rung that holds the rate";
    EXPECT_LT(lateFrames(calm, 10), 0.005 * frames);
    // Then it is pixels that take time, as was guessed.
    const Ride after = ride({.load = [](int) { return 10.2; }}, frames, std::move(calm.governor));
    EXPECT_EQ(after.rungs.back(), 2) << "10.2 ms * 0.7 leaves room, 10.2 ms * 0.85 does not";
}

TEST(Governor, CountsTheFramesThatTookMoreThanTheBudget) {
    const Ride walk = ride({.load = [](int frame) { return frame % 150 == 149 ? 10.1 : 8.0; }, .lag = 1}, 1001);
    EXPECT_EQ(walk.governor.overBudget(), 6u);
}

TEST(Governor, DoesNotListenToFramesOfBeforeTheChange) {
    Governor governor(kCosts, tenMilliseconds());
    for (std::uint64_t frame = 0; frame < 3; ++frame) {
        governor.rungFor(frame);
        governor.tell(frame, 11);
    }
    ASSERT_EQ(governor.rungFor(3), 1 + 1) << "11 ms * 0.85 is not below 9";
    for (std::uint64_t frame = 0; frame < 3; ++frame)
        governor.tell(frame, 1000);
    EXPECT_EQ(governor.rungFor(4), 2);
    // Nor to what cannot be.
    for (int i = 0; i < 9; ++i) {
        governor.tell(99, 1000);
        governor.tell(4, std::nan(""));
        governor.tell(4, -1);
    }
    EXPECT_EQ(governor.rungFor(5), 2);
}

TEST(Governor, ANewCountOfFramesStartsAfresh) {
    Governor governor(kCosts, tenMilliseconds());
    for (std::uint64_t frame = 500; frame < 502; ++frame) {
        governor.rungFor(frame);
        governor.tell(frame, 20);
    }
    EXPECT_EQ(governor.rungFor(0), 0) << "two late frames of another renderer say nothing of this one";
    governor.tell(0, 20);
    EXPECT_EQ(governor.rungFor(1), 0);
    governor.tell(1, 20);
    governor.rungFor(2);
    governor.tell(2, 20);
    EXPECT_GT(governor.rungFor(3), 0) << "but three of its own do";
}

TEST(Ladder, EachRungIsCheaperAndNoneIsBelowTheFloor) {
    for (const Preset& preset : presets())
        for (const double scale : {0.1, 0.3, 1.0, 2.0, 4.0}) {
            render::Quality base = preset.quality;
            base.resolutionScale = scale;
            const std::vector<Rung> ladder = ladderOf(base);
            ASSERT_FALSE(ladder.empty());
            EXPECT_EQ(toJson(ladder[0].quality), toJson(base));
            for (std::size_t i = 1; i < ladder.size(); ++i) {
                EXPECT_LT(ladder[i].cost, ladder[i - 1].cost) << preset.name << " " << ladder[i].name;
                EXPECT_NE(toJson(ladder[i].quality), toJson(ladder[i - 1].quality));
                EXPECT_NO_THROW(qualityOf(toJson(ladder[i].quality), "here")) << "a rung must be a setting";
            }
            EXPECT_GE(ladder.size(), scale >= 1 ? 5u : 1u) << preset.name;
        }
}

TEST(Ladder, HalfTheResolutionIsFollowedByCoarserSamplesIfAnyMayStandForOthers) {
    render::Quality base = presets().back().quality;
    const auto coarserOf = [](const std::vector<Rung>& ladder) {
        std::vector<std::size_t> coarser;
        for (std::size_t i = 0; i < ladder.size(); ++i)
            if (ladder[i].quality.samplePixels != ladder[0].quality.samplePixels) coarser.push_back(i);
        return coarser;
    };
    base.samplePixels = 1;
    const std::vector<Rung> ladder = ladderOf(base);
    const std::vector<std::size_t> coarser = coarserOf(ladder);
    ASSERT_EQ(coarser.size(), 1u);
    const Rung &before = ladder[coarser[0] - 1], &rung = ladder[coarser[0]];
    EXPECT_GT(rung.quality.samplePixels, base.samplePixels);
    EXPECT_EQ(rung.quality.resolutionScale, 0.5 * base.resolutionScale);
    EXPECT_EQ(before.quality.resolutionScale, rung.quality.resolutionScale);
    for (const double none : {0.0, kMostSamplePixels}) {
        base.samplePixels = none;
        EXPECT_TRUE(coarserOf(ladderOf(base)).empty()) << none;
    }
}

TEST(Ladder, IsReportedWithEveryChange) {
    const std::vector<Rung> ladder = ladderOf(presets().back().quality);
    std::vector<double> costs;
    for (const Rung& rung : ladder)
        costs.push_back(rung.cost);
    const Ride fall = ride({.load = [](int) { return 12.0; }, .costs = costs}, 50, Governor(costs, tenMilliseconds()));
    const nlohmann::json report = toJson(fall.governor, ladder, 100);
    ASSERT_FALSE(report.at("changes").empty());
    EXPECT_EQ(report["changes"][0]["from"], "as asked");
    EXPECT_EQ(report["changes"][0]["load_ms"], 12.0);
    std::uint64_t frames = 0;
    for (const auto& rung : report.at("rungs"))
        frames += rung.at("frames").get<std::uint64_t>();
    EXPECT_EQ(frames, 50u);
}

TEST(Ladder, WarmsUpEachWarpAndFewerPixelsOnce) {
    GovernedQuality governed(90);
    EXPECT_TRUE(governed.ways().empty()) << "nothing is asked for yet";
    governed.next(readQuality("best"), 0);
    const std::vector<render::Quality> ways = governed.ways();
    ASSERT_EQ(ways.size(), 4u);
    EXPECT_TRUE(ways[0].isBlended);
    EXPECT_EQ(ways[1].warp, render::Warp::mesh);
    EXPECT_EQ(ways[2].warp, render::Warp::points);
    EXPECT_EQ(ways[3].warp, render::Warp::points);
    EXPECT_LT(ways[3].resolutionScale, ways[2].resolutionScale);
    governed.next(readQuality("balanced"), 1);
    EXPECT_EQ(governed.ways().size(), 2u);
}

TEST(Ladder, WhatIsBlendedGivesThatUpBeforeAnyPixels) {
    const std::vector<Rung> ladder = ladderOf(readQuality("best"));
    ASSERT_TRUE(ladder[0].quality.isBlended);
    EXPECT_EQ(ladder[1].name, "confidence");
    EXPECT_EQ(ladder[1].quality.resolutionScale, ladder[0].quality.resolutionScale);
    EXPECT_FALSE(ladder[1].quality.isBlended);
    for (const Rung& rung : ladder)
        EXPECT_NE(rung.quality.warp, render::Warp::adaptive) << "no faster: " << rung.name;
}

TEST(Ladder, EveryWarpThatHasANameLeadsDownToPoints) {
    for (const std::string& name : knobs()[0].names) {
        render::Quality asked;
        ASSERT_TRUE(knobs()[0].set(asked, name));
        EXPECT_EQ(knobs()[0].get(asked), name);
        const std::vector<Rung> ladder = ladderOf(asked);
        EXPECT_EQ(ladder.front().name, "as asked");
        EXPECT_EQ(ladder.front().quality.warp, asked.warp) << name;
        EXPECT_EQ(ladder.back().quality.warp, render::Warp::points) << name;
        EXPECT_FALSE(ladder.back().quality.isBlended) << name;
    }
}

} // namespace
} // namespace app
