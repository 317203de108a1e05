#include "render/draw_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

namespace render {
namespace {

/// So many of each reach (plain, small, any), mixed, of one piece.
DrawList listOf(Warp warp, std::array<std::uint32_t, 3> counts) {
    DrawList list;
    for (std::uint32_t left = 1; left > 0;) {
        left = 0;
        for (std::uint32_t reach = 0; reach < 3; ++reach) {
            if (counts[reach] == 0) continue;
            DrawList::Chosen chosen{.tile = static_cast<std::uint32_t>(list.chosen.size()), .items = 1, .warp = warp};
            chosen.reach = static_cast<Reach>(reach);
            list.chosen.push_back(chosen);
            left += --counts[reach];
        }
    }
    list.counts = {static_cast<std::uint32_t>(list.chosen.size())};
    list.firstOfPiece = {0};
    orderDraws(0, 0, list);
    return list;
}

TEST(DrawOrder, FewPlainOrSmallTilesGoWithWhatNeedsMore) {
    struct Case {
        std::array<std::uint32_t, 3> counts, inRuns; ///< plain, small, any
    };
    constexpr std::array kCases{
        Case{{20, 580, 0}, {0, 600, 0}}, Case{{40, 560, 0}, {40, 560, 0}}, Case{{20, 0, 50}, {0, 0, 70}},
        Case{{20, 5, 50}, {0, 0, 75}}, // by way of the small ones
        Case{{40, 5, 50}, {40, 0, 55}},  Case{{20, 20, 1}, {0, 40, 1}},    Case{{20, 5, 0}, {0, 25, 0}},
        Case{{5, 0, 0}, {5, 0, 0}},      Case{{0, 5, 0}, {0, 5, 0}},
    };
    for (const Case& of : kCases) {
        const DrawList list = listOf(Warp::mesh, of.counts);
        std::array<std::uint32_t, 3> inRuns{};
        for (const DrawRun& run : list.runs)
            inRuns.at(static_cast<std::size_t>(run.reach)) += run.count;
        EXPECT_EQ(inRuns, of.inRuns);
        EXPECT_EQ(list.runs.size(), 3 - std::count(of.inRuns.begin(), of.inRuns.end(), 0u));
        std::vector<int> drawn(list.chosen.size(), 0);
        for (const DrawRun& run : list.runs)
            for (std::uint32_t i = run.first; i < run.first + run.count; ++i) {
                const DrawList::Chosen& chosen = list.chosen[list.order[i]];
                ++drawn[chosen.tile];
                EXPECT_LE(chosen.reach, run.reach) << "nothing is drawn by what does too little";
            }
        EXPECT_EQ(std::count(drawn.begin(), drawn.end(), 1), static_cast<std::ptrdiff_t>(drawn.size()));
    }
}

TEST(DrawOrder, PlainSplatsStayAmongThemselves) {
    const DrawList list = listOf(Warp::splats, {5, 0, 50});
    ASSERT_EQ(list.runs.size(), 2u);
    EXPECT_EQ(list.runs[0].count, 5u);
}

TEST(DrawOrder, TilesComeFromTopToBottomAndThenAsTheyWereChosen) {
    DrawList list;
    for (std::uint32_t i = 0; i < 9000; ++i) { // of three pieces; in parts
        DrawList::Chosen chosen{.tile = i, .items = 1, .warp = Warp::points, .reach = Reach::plain};
        chosen.band = bandOf(static_cast<double>(i * 7919 % 1000) - 100.0);
        list.chosen.push_back(chosen);
    }
    list.counts = {4000, 0, 5000}, list.firstOfPiece = {0, 4000, 4000};
    orderDraws(640 * 480, kNeverLook, list);
    ASSERT_EQ(list.runs.size(), 1u);
    ASSERT_EQ(list.order.size(), list.chosen.size());
    EXPECT_TRUE(std::ranges::is_sorted(list.order, {},
                                       [&](std::uint32_t place) { return std::pair(list.chosen[place].band, place); }));
    EXPECT_EQ(list.chosen[list.order.front()].band, 0u);
    EXPECT_EQ(list.chosen[list.order.back()].band, 899u / kBandRows);
    // Where there is no picture to speak of, as they were chosen.
    orderDraws(0, kNeverLook, list);
    EXPECT_TRUE(std::ranges::is_sorted(list.order));
}

} // namespace
} // namespace render
