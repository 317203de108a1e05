#include "scene/open_ways.h"

#include "scene/coverage_ray.h"
#include "tests/repetitions.h"
#include "tests/scene/random_coverage.h"

#include <array>
#include <cmath>
#include <random>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

namespace scene {
namespace {

class Places {
  public:
    explicit Places(std::uint32_t seed) : random_(seed) {}
    double within(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
    glm::dvec3 about(const Coverage& coverage, double beyond) {
        const auto along = [&] { return within(-beyond, coverage.edgeMetres + beyond); };
        const double x = along(), y = along(), z = along();
        return coverage.cornerInWorld + glm::dvec3(x, y, z);
    }

  private:
    std::mt19937 random_;
};

/// A cube of 4 m: of one of its four floors cells of a metre are seen empty here and there, the rest is unseen.
Coverage floorPlan(const std::array<const char*, 4>& rows, int floor = 0) {
    Coverage coverage{glm::dvec3(10, -20, 3), 4, std::vector<CoverageNode>(1)};
    coverage.nodes[0].unseen = ~std::uint64_t{0};
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x)
            if (rows[static_cast<std::size_t>(y)][x] == '.')
                coverage.nodes[0].unseen &= ~coverageMask(coverageBit(x, y, floor));
    return coverage;
}
glm::dvec3 inPlan(double x, double y, int floor = 0) {
    return glm::dvec3(10, -20, 3) + glm::dvec3(x, y, floor + 0.5);
}
bool mayMeetAt(const OpenWays& ways, const glm::dvec3& p) {
    return ways.mayMeet(p, p, 0);
}

TEST(OpenWays, NothingThatARayMeetsIsMissed) {
    int met = 0, missed = 0, known = 0;
    for (std::uint32_t seed = 1; seed <= static_cast<std::uint32_t>(tests::repetitions(24)); ++seed) {
        const Coverage coverage = randomCoverage(seed, 1 + static_cast<int>(seed % 5), seed % 2 == 0 ? 0.3 : 0.6);
        const OpenGrid grid(coverage);
        Places places(seed);
        for (int stand = 0; stand < 10; ++stand) {
            const glm::dvec3 eye = places.about(coverage, 0);
            OpenWays ways;
            ways.standAt(grid, std::array{eye});
            if (!ways.isKnown()) continue;
            ++known;
            for (int i = 0; i < 2000; ++i) {
                const glm::dvec3 p = places.about(coverage, 0.5), way = p - eye;
                const double far = glm::length(way);
                // Pictures look out of unseen space.
                if (firstUnseen(coverage, eye, way / far, far, i % 2 == 0 ? 0 : 1)) continue;
                mayMeetAt(ways, p) ? ++met : ++missed;
            }
        }
    }
    EXPECT_EQ(missed, 0);
    EXPECT_GT(known, 10);
    EXPECT_GT(met, 100);
}

TEST(OpenWays, HoldsWhileTheEyeMovesALittle) {
    const Coverage coverage = randomCoverage(3, 2, 0.3);
    const OpenGrid grid(coverage);
    Places places(7);
    OpenWays ways;
    int found = 0, held = 0, met = 0;
    glm::dvec3 eye = places.about(coverage, 0);
    for (int i = 0; i < 400; ++i) {
        const glm::dvec3 step(places.within(-1, 1), places.within(-1, 1), places.within(-1, 1));
        eye = glm::clamp(eye + 0.5 * grid.cellMetres() * step, coverage.cornerInWorld + 0.01,
                         coverage.cornerInWorld + coverage.edgeMetres - 0.01);
        const bool isFoundAnew = ways.standAt(grid, std::array{eye});
        if (!ways.isKnown()) continue;
        isFoundAnew ? ++found : ++held;
        for (int k = 0; k < 50; ++k) {
            const glm::dvec3 p = places.about(coverage, 0), way = p - eye;
            const double far = glm::length(way);
            if (observedAt(coverage, eye) == Observed::unseen || firstUnseen(coverage, eye, way / far, far)) continue;
            ASSERT_TRUE(mayMeetAt(ways, p)) << i;
            ++met;
        }
    }
    EXPECT_GT(held, found) << "found anew " << found << " times";
    EXPECT_GT(found, 0);
    EXPECT_GT(met, 100);
}

TEST(OpenWays, RoomsBehindWallsAreNotMet) {
    // A door in the middle of the wall; the room behind goes on round a corner, which no ray takes.
    const OpenGrid grid(floorPlan({"..#.", //
                                   "....", //
                                   "..##", //
                                   "###."}));
    OpenWays ways;
    EXPECT_TRUE(ways.standAt(grid, std::array{inPlan(0.5, 1.5)}));
    EXPECT_TRUE(mayMeetAt(ways, inPlan(0.5, 0.5)));
    EXPECT_TRUE(mayMeetAt(ways, inPlan(1.5, 2.9))) << "in the same room";
    EXPECT_TRUE(mayMeetAt(ways, inPlan(3.5, 1.5))) << "through the door";
    EXPECT_TRUE(mayMeetAt(ways, inPlan(3.9, 0.1))) << "beside the door, and beyond it: at a slant";
    EXPECT_FALSE(mayMeetAt(ways, inPlan(3.5, 3.5))) << "a room without a door";
    EXPECT_FALSE(mayMeetAt(ways, inPlan(2.5, 0.5))) << "within the wall";
    // From below the door the room above it is round the corner.
    EXPECT_TRUE(ways.standAt(grid, std::array{inPlan(3.5, 0.5)}));
    EXPECT_TRUE(mayMeetAt(ways, inPlan(0.5, 2.5)));
    EXPECT_FALSE(mayMeetAt(ways, inPlan(0.5, 0.2))) << "the way to it would turn back";
}

TEST(OpenWays, TwoEyesMeetWhatEitherDoes) {
    const OpenGrid grid(floorPlan({".##.", //
                                   ".##.", //
                                   "####", //
                                   "###."}));
    OpenWays ways;
    EXPECT_TRUE(ways.standAt(grid, std::array{inPlan(0.5, 0.5), inPlan(3.5, 0.5)}));
    EXPECT_TRUE(mayMeetAt(ways, inPlan(0.5, 1.5)));
    EXPECT_TRUE(mayMeetAt(ways, inPlan(3.5, 1.5)));
    EXPECT_FALSE(mayMeetAt(ways, inPlan(3.5, 3.5)));
}

TEST(OpenWays, WhoStandsWhereNobodyLookedMayMeetAnything) {
    const Coverage coverage = floorPlan({"..#.", "..#.", "..#.", "..#."});
    const OpenGrid grid(coverage);
    OpenWays ways;
    EXPECT_TRUE(mayMeetAt(ways, inPlan(3.5, 0.5))) << "nothing is known yet";
    ways.standAt(grid, std::array{inPlan(0.5, 0.5)});
    EXPECT_FALSE(mayMeetAt(ways, inPlan(3.5, 0.5)));
    EXPECT_FALSE(ways.standAt(grid, std::array{inPlan(2.5, 0.5)}));
    EXPECT_TRUE(mayMeetAt(ways, inPlan(3.5, 0.5)));
    EXPECT_TRUE(ways.standAt(grid, std::array{inPlan(0.5, 0.5)}));
    EXPECT_FALSE(mayMeetAt(ways, inPlan(3.5, 0.5)));
    for (const double far : {100.0, 1e12}) {
        EXPECT_FALSE(ways.standAt(grid, std::array{inPlan(-far, 0.5)}));
        EXPECT_TRUE(mayMeetAt(ways, inPlan(3.5, 0.5)));
    }
}

TEST(OpenWays, WhoStandsBesideTheUnseenMayMeetAnything) {
    Coverage coverage = floorPlan({"..#.", "..#.", "..#.", "..#."});
    // The cell at the eye's divided down to below the grid: of one of its cells the lower half is unseen.
    const int levels = 5;
    glm::dvec3 corner = coverage.cornerInWorld;
    double edge = coverage.edgeMetres;
    for (int level = 1; level < levels; ++level) {
        CoverageNode& parent = coverage.nodes.back();
        parent.children = coverageMask(coverageBit(1, 1, 0));
        parent.unseen &= ~parent.children;
        parent.firstChild = static_cast<std::uint32_t>(coverage.nodes.size());
        edge /= kCoverageBranching;
        corner += edge * glm::dvec3(1, 1, 0);
        coverage.nodes.emplace_back();
    }
    for (int bit = 0; bit < 32; ++bit)
        coverage.nodes.back().unseen |= coverageMask(bit);
    const OpenGrid grid(coverage);
    ASSERT_DOUBLE_EQ(grid.cellMetres(), edge);
    const auto isKnownAt = [&](const glm::dvec3& eye) {
        OpenWays ways;
        ways.standAt(grid, std::array{eye});
        EXPECT_EQ(mayMeetAt(ways, inPlan(3.5, 0.5)), !ways.isKnown());
        return ways.isKnown();
    };
    const glm::dvec3 middle = corner + 0.5 * edge;
    EXPECT_FALSE(isKnownAt(middle - glm::dvec3(0, 0, 0.3 * edge))) << "in what is unseen of the cell";
    EXPECT_FALSE(isKnownAt(middle + glm::dvec3(0, 0, 0.3 * edge))) << "above it";
    EXPECT_FALSE(isKnownAt(middle + glm::dvec3(0.505 * edge, 0, 0.3 * edge))) << "right beside the cell";
    EXPECT_TRUE(isKnownAt(middle + glm::dvec3(0.55 * edge, 0, 0.3 * edge))) << "a little farther";
    EXPECT_FALSE(isKnownAt(inPlan(1.9999, 0.5))) << "right before the wall";
    EXPECT_TRUE(isKnownAt(inPlan(1.99, 0.5)));
}

TEST(OpenWays, OutsideOfTheCubeIsMetWhereAWayLeavesIt) {
    // The floor itself is the cube's rim.
    const OpenGrid rim(floorPlan({"...#", "...#", "...#", "####"}));
    OpenWays ways;
    ways.standAt(rim, std::array{inPlan(0.5, 0.5)});
    EXPECT_TRUE(mayMeetAt(ways, inPlan(-3, 0.5)));
    const OpenGrid within(floorPlan({"####", "#..#", "#..#", "####"}, 1));
    ways.forget();
    ways.standAt(within, std::array{inPlan(1.5, 1.5, 1)});
    EXPECT_FALSE(mayMeetAt(ways, inPlan(-3, 0.5)));
    EXPECT_TRUE(mayMeetAt(ways, inPlan(1.1, 2.9, 1)));
}

TEST(OpenWays, ABoxIsMetIfAnythingInItIsOrNearEnoughBesideIt) {
    const Coverage coverage = randomCoverage(12, 3, 0.6);
    const OpenGrid grid(coverage);
    Places places(5);
    OpenWays ways;
    glm::dvec3 eye = places.about(coverage, 0);
    while (observedAt(coverage, eye) == Observed::unseen)
        eye = places.about(coverage, 0);
    ways.standAt(grid, std::array{eye});
    const auto middleOf = [&](int x, int y, int z) {
        return coverage.cornerInWorld + grid.cellMetres() * (glm::dvec3(x, y, z) + 0.5);
    };
    int isMet = 0, isNot = 0;
    for (int i = 0; i < 3000; ++i) {
        std::array<int, 3> low{}, size{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            size[axis] = static_cast<int>(places.within(0, 24));
            low[axis] = static_cast<int>(places.within(0, kOpenGridAcross - size[axis]));
        }
        const bool box = ways.mayMeet(middleOf(low[0], low[1], low[2]),
                                      middleOf(low[0] + size[0], low[1] + size[1], low[2] + size[2]), 0);
        bool any = false;
        for (int z = low[2]; z <= low[2] + size[2] && !any; ++z)
            for (int y = low[1]; y <= low[1] + size[1] && !any; ++y)
                for (int x = low[0]; x <= low[0] + size[0] && !any; ++x)
                    any = mayMeetAt(ways, middleOf(x, y, z));
        ASSERT_EQ(box, any) << i;
        (box ? isMet : isNot) += 1;
    }
    EXPECT_GT(isMet, 30);
    EXPECT_GT(isNot, 30);

    const OpenGrid rooms(floorPlan({"####", "#.##", "#.##", "####"}, 1));
    ways.forget();
    ways.standAt(rooms, std::array{inPlan(1.5, 1.5, 1)});
    // Half a metre behind what is met, and 1 to 1.6 from the eye.
    const glm::dvec3 least = inPlan(2.5, 1, 1), most = inPlan(2.6, 2.5, 1);
    EXPECT_FALSE(ways.mayMeet(least, most, 0.25));
    EXPECT_TRUE(ways.mayMeet(least, most, 0.55));
}

} // namespace
} // namespace scene
