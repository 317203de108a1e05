// The front of a trade, means over pictures, and the sweep.

#include "app/measure_scene.h"
#include "app/measure_table.h"
#include "scene/errors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>

namespace app {
namespace {

TEST(ParetoFront, IsWhatNothingBeats) {
    const std::vector<Trade> trades{{10, 30}, {20, 32}, {15, 29}, {20, 31}, {40, 32}, {5, 20}, {10, 30}};
    EXPECT_EQ(paretoFront(trades), (std::vector<bool>{true, true, false, false, false, true, true}));
    EXPECT_TRUE(paretoFront({}).empty());
}

TEST(ParetoFront, IsNeverEmptyAndOrdersBothWays) {
    std::mt19937 random(5);
    for (int round = 0; round < 50; ++round) {
        std::vector<Trade> trades(1 + random() % 30);
        for (Trade& trade : trades)
            trade = {static_cast<double>(random() % 20), static_cast<double>(random() % 20)};
        const std::vector<bool> isOnFront = paretoFront(trades);
        std::vector<Trade> front;
        for (std::size_t i = 0; i < trades.size(); ++i)
            if (isOnFront[i]) front.push_back(trades[i]);
        ASSERT_FALSE(front.empty());
        std::sort(front.begin(), front.end(), [](Trade a, Trade b) { return a.milliseconds < b.milliseconds; });
        for (std::size_t i = 1; i < front.size(); ++i)
            EXPECT_EQ(front[i].milliseconds > front[i - 1].milliseconds, front[i].decibels > front[i - 1].decibels)
                << "who is slower must be better";
    }
}

TEST(MeasureTable, MeansLeaveOutWhatIsNotKnown) {
    std::vector<MeasuredPicture> pictures(2);
    pictures[0].error.psnrCovered = 30, pictures[1].error.psnrCovered = 32;
    pictures[0].error.wronglySolidShare = 0.1;
    pictures[1].error.wronglySolidShare = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(meanOf(pictures).psnrCovered, 31);
    EXPECT_EQ(meanOf(pictures).wronglySolidShare, 0.1);
    EXPECT_TRUE(std::isnan(meanOf(std::span(pictures).last(1)).wronglySolidShare));
}

TEST(MeasureTable, SaysWhatARungCostsAndSaves) {
    std::vector<MeasuredSetting> settings(3);
    settings[0].name = "alone", settings[1].name = "as asked", settings[2].name = "half";
    const double ms[] = {7, 20, 10}, db[] = {20, 31, 30};
    for (std::size_t i = 0; i < 3; ++i) {
        settings[i].medianMilliseconds = ms[i];
        settings[i].pictures.resize(1);
        settings[i].pictures[0].error.psnrCovered = db[i];
    }
    const std::string table = tableOf(settings, 1);
    EXPECT_NE(table.find("| alone | 7.0 |"), std::string::npos) << table;
    EXPECT_NE(table.find("| half | 10.0 | 30.00 | 10.0 | 1.00 | 0.10 |"), std::string::npos) << table;
    EXPECT_EQ(tableOf(settings, 3).find("governor"), std::string::npos);
    settings[0].name = "a|b";
    EXPECT_NE(tableOf(settings, 1).find("| a\\|b | 7.0 |"), std::string::npos) << "no column of its own";
}

TEST(Sweep, TurnsOneKnobAtATimeAndRepeatsNothing) {
    const render::Quality start = presets().front().quality;
    const std::vector<Preset> all = sweepFrom(start, {});
    std::set<std::string> seen;
    for (const Preset& setting : all) {
        EXPECT_TRUE(seen.insert(toJson(setting.quality).dump()).second) << setting.name << " is there twice";
        bool isPreset = false;
        for (const Preset& preset : presets())
            isPreset |= preset.name == setting.name;
        if (isPreset) continue;
        int turned = 0;
        for (const Knob& knob : knobs())
            turned += knob.get(setting.quality) != knob.get(start) ? 1 : 0;
        EXPECT_EQ(turned, 1) << setting.name;
    }
    EXPECT_LT(sweepFrom(start, {"warp"}).size(), all.size());
    EXPECT_THROW(sweepFrom(start, {"colour"}), scene::Failure);
}

} // namespace
} // namespace app
