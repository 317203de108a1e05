#include "scene/open_ways.h"

#include "scene/coverage_ray.h"
#include "tests/repetitions.h"
#include "tests/scene/random_coverage.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <iterator>
#include <random>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>
#include <gtest/gtest.h>

namespace scene {
namespace {

/// Of the edge of the cube: one layer, two, three.
constexpr std::array<double, 3> kFineEnough{1, 1.0 / 512, 0};

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
        const OpenGrid grid(coverage, kFineEnough[seed % 3] * coverage.edgeMetres);
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

/// As far as a walk of 400 steps goes, of half a cell of the finest layer each.
void walkAbout(int layers) {
    const Coverage coverage = randomCoverage(3, 2, 0.3);
    const OpenGrid grid(coverage, layers == 1 ? 1 : 0);
    EXPECT_EQ(grid.layers(), layers);
    Places places(7);
    OpenWays ways;
    int found = 0, held = 0, met = 0;
    glm::dvec3 eye = places.about(coverage, 0);
    for (int i = 0; i < 400; ++i) {
        const glm::dvec3 step(places.within(-1, 1), places.within(-1, 1), places.within(-1, 1));
        eye = glm::clamp(eye + 0.5 * grid.finestMetres() * step, coverage.cornerInWorld + 0.01,
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

TEST(OpenWays, HoldsWhileTheEyeMovesALittle) {
    walkAbout(1);
}
TEST(OpenWays, HoldsWhileTheEyeMovesALittleInFinerLayers) {
    walkAbout(3);
}

TEST(OpenWays, RoomsBehindWallsAreNotMet) {
    // A door in the middle of the wall; the room behind goes on round a corner, which no ray takes.
    const Coverage gridPlan = floorPlan({"..#.", //
                                         "....", //
                                         "..##", //
                                         "###."});
    const OpenGrid grid(gridPlan);
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

/// A box that was seen empty, metres.
struct SeenBox {
    glm::dvec3 least, most;
};

/// A cube of a large site, in which nothing but these was observed.
class Site {
  public:
    explicit Site(const std::vector<SeenBox>& seen) {
        coverage.cornerInWorld = glm::dvec3(-31, -29, -33), coverage.edgeMetres = 70;
        coverage.nodes.resize(1);
        divide(0, coverage.cornerInWorld, coverage.edgeMetres / kCoverageBranching, 1, seen);
    }
    Coverage coverage;

  private:
    static constexpr int kLevels = 6; // cells of 17 mm
    static bool overlaps(const SeenBox& box, const glm::dvec3& low, const glm::dvec3& high) {
        return glm::all(glm::lessThan(box.least, high)) && glm::all(glm::greaterThan(box.most, low));
    }
    static std::vector<SeenBox> overlapping(const std::vector<SeenBox>& seen, const glm::dvec3& low, double edge) {
        std::vector<SeenBox> some;
        std::copy_if(seen.begin(), seen.end(), std::back_inserter(some),
                     [&](const SeenBox& box) { return overlaps(box, low, low + edge); });
        return some;
    }
    /// seen: those that overlap the node.
    void divide(std::size_t index, const glm::dvec3& corner, double cell, int level, const std::vector<SeenBox>& seen) {
        CoverageNode node;
        const auto cornerOf = [&](int bit) { return corner + cell * glm::dvec3(bit % 4, bit / 4 % 4, bit / 16); };
        for (int bit = 0; bit < 64; ++bit) {
            const glm::dvec3 low = cornerOf(bit), high = low + cell;
            const bool isWithin = std::any_of(seen.begin(), seen.end(), [&](const SeenBox& box) {
                return glm::all(glm::lessThanEqual(box.least, low)) && glm::all(glm::greaterThanEqual(box.most, high));
            });
            const bool isOutside =
                std::none_of(seen.begin(), seen.end(), [&](const SeenBox& box) { return overlaps(box, low, high); });
            if (isOutside)
                node.unseen |= coverageMask(bit);
            else if (!isWithin && level < kLevels)
                node.children |= coverageMask(bit);
        }
        node.firstChild = static_cast<std::uint32_t>(coverage.nodes.size());
        coverage.nodes[index] = node;
        coverage.nodes.resize(coverage.nodes.size() + static_cast<std::size_t>(std::popcount(node.children)));
        for (int bit = 0; bit < 64; ++bit)
            if ((node.children & coverageMask(bit)) != 0)
                divide(node.firstChild + childRank(node.children, bit), cornerOf(bit), cell / kCoverageBranching,
                       level + 1, overlapping(seen, cornerOf(bit), cell));
    }
};

// Walls are thinner than the cells of 27 cm of the whole site.
TEST(OpenWays, ThinWallsAboutTheEyeHide) {
    const Site site({{{0, 0, 0}, {5, 4, 2.5}},    // where the eye is
                     {{5.12, 0, 0}, {9, 4, 2.5}}, // behind a wall
                     {{0, 4.12, 0}, {5, 9, 2.5}}, // behind a wall with a door, 0.9 m wide
                     {{3, 4, 0}, {3.9, 4.12, 2.1}},
                     {{0, 0, 2.7}, {5, 4, 5}},       // a floor above
                     {{-20, -20, 0}, {-15, 9, 2.5}}, // and elsewhere
                     {{10, 20, 0}, {30, 30, 2.5}}});
    const OpenGrid grid(site.coverage), wide(site.coverage, site.coverage.edgeMetres);
    ASSERT_EQ(grid.layers(), 3);
    ASSERT_EQ(wide.layers(), 1);
    Places places(11);
    std::array<int, 2> hidden{};
    int met = 0;
    for (int stand = 0; stand < tests::repetitions(12); ++stand) {
        const glm::dvec3 eye(places.within(0.5, 4.5), places.within(0.5, 3.5), places.within(1, 2));
        OpenWays ways, widely;
        ASSERT_TRUE(ways.standAt(grid, std::array{eye}));
        ASSERT_TRUE(widely.standAt(wide, std::array{eye}));
        for (int i = 0; i < 3000; ++i) {
            // Every second one in these rooms or right beside them.
            const double low = i % 2 == 0 ? -1 : -21, high = i % 2 == 0 ? 10 : 31;
            const glm::dvec3 p(places.within(low, high), places.within(low, high), places.within(-1, 6)), way = p - eye;
            const double far = glm::length(way);
            if (!firstUnseen(site.coverage, eye, way / far, far)) {
                EXPECT_TRUE(mayMeetAt(ways, p) && mayMeetAt(widely, p)) << i;
                ++met;
            }
            hidden[0] += mayMeetAt(ways, p) ? 0 : 1, hidden[1] += mayMeetAt(widely, p) ? 0 : 1;
        }
        const auto mayMeetBox = [](const OpenWays& w, const SeenBox& box) {
            return w.mayMeet(box.least, box.most, 0.01);
        };
        const SeenBox behindWall{{5.12, 0, 0}, {9, 4, 2.5}}, above{{0, 0, 2.7}, {5, 4, 5}},
            throughDoor{{0, 4.2, 0}, {5, 9, 2.5}}, own{{0, 0, 0}, {5, 4, 2.5}};
        EXPECT_FALSE(mayMeetBox(ways, behindWall));
        EXPECT_FALSE(mayMeetBox(ways, above));
        EXPECT_TRUE(mayMeetBox(ways, throughDoor));
        EXPECT_TRUE(mayMeetBox(ways, own));
        EXPECT_TRUE(mayMeetBox(widely, behindWall)) << "else this tests nothing";
        EXPECT_FALSE(mayMeetBox(ways, {{-20, -20, 0}, {-15, 9, 2.5}})) << "beyond the finer layers";
    }
    EXPECT_GT(met, tests::repetitions(600));
    EXPECT_GT(hidden[0], hidden[1]);
}

TEST(OpenWays, WaysGoOnBeyondTheFinerLayers) {
    // A passage from the eye's room to one far off, and one beside it that nothing leads to.
    const Site site({{{0, 0, 0}, {4, 4, 2.5}},
                     {{4, 1, 0}, {25, 3, 2.5}},
                     {{25, -8, 0}, {35, 12, 2.5}},
                     {{12, 5, 0}, {20, 12, 2.5}}});
    const OpenGrid grid(site.coverage);
    OpenWays ways;
    // Along the passage: through the finest layer, which begins anew, and in the rooms at its ends.
    int met = 0;
    Places places(4);
    for (double x = 1; x < 30; x += 0.45 * 64 / tests::repetitions(64)) {
        const glm::dvec3 eye(x, 2 + 0.3 * std::sin(x), 1.5);
        ways.standAt(grid, std::array{eye, eye + glm::dvec3(0, 0.06, 0)});
        ASSERT_TRUE(ways.isKnown());
        EXPECT_TRUE(ways.mayMeet({34, 1, 1}, {35, 3, 2}, 0)) << x;
        EXPECT_TRUE(ways.mayMeet({0, 1, 1}, {1, 3, 2}, 0)) << x;
        EXPECT_TRUE(x > 24 || !ways.mayMeet({12, 5.2, 0}, {20, 12, 2.5}, 0)) << x;
        for (int i = 0; i < 500; ++i) {
            const glm::dvec3 p(places.within(0, 35), places.within(-8, 12), places.within(0, 2.5)), way = p - eye;
            const double far = glm::length(way);
            if (firstUnseen(site.coverage, eye, way / far, far)) continue;
            EXPECT_TRUE(mayMeetAt(ways, p)) << x << " " << i;
            ++met;
        }
    }
    EXPECT_GT(met, tests::repetitions(1000));
    // Eyes too far apart for the finest layer, or for any but the widest.
    for (const double apart : {3.0, 17.0}) {
        ways.standAt(grid, std::array{glm::dvec3(5, 2, 1.5), glm::dvec3(5 + apart, 2, 1.5)});
        ASSERT_TRUE(ways.isKnown());
        EXPECT_TRUE(ways.mayMeet({34, 1, 1}, {35, 3, 2}, 0)) << apart;
        EXPECT_FALSE(ways.mayMeet({12, 6, 0}, {20, 12, 2.5}, 0)) << apart;
    }
    ways.standAt(grid, std::array{glm::dvec3(5, 2, 1.5)});
    EXPECT_FALSE(ways.mayMeet({12, 5.2, 0}, {20, 12, 2.5}, 0)) << "and finely again";
}

TEST(OpenWays, TwoEyesMeetWhatEitherDoes) {
    const Coverage gridPlan = floorPlan({".##.", //
                                         ".##.", //
                                         "####", //
                                         "###."});
    const OpenGrid grid(gridPlan);
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
    const Coverage rimPlan = floorPlan({"...#", "...#", "...#", "####"});
    const OpenGrid rim(rimPlan);
    OpenWays ways;
    ways.standAt(rim, std::array{inPlan(0.5, 0.5)});
    EXPECT_TRUE(mayMeetAt(ways, inPlan(-3, 0.5)));
    const Coverage withinPlan = floorPlan({"####", "#..#", "#..#", "####"}, 1);
    const OpenGrid within(withinPlan);
    ways.forget();
    ways.standAt(within, std::array{inPlan(1.5, 1.5, 1)});
    EXPECT_FALSE(mayMeetAt(ways, inPlan(-3, 0.5)));
    EXPECT_TRUE(mayMeetAt(ways, inPlan(1.1, 2.9, 1)));
}

TEST(OpenWays, ABoxIsMetIfAnythingInItIsOrNearEnoughBesideIt) {
    const Coverage coverage = randomCoverage(12, 3, 0.6);
    const OpenGrid grid(coverage, coverage.edgeMetres); // one layer
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
            low[axis] = static_cast<int>(places.within(0, kOpenCellsAcross - size[axis]));
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

    const Coverage roomsPlan = floorPlan({"####", "#.##", "#.##", "####"}, 1);
    const OpenGrid rooms(roomsPlan);
    ways.forget();
    ways.standAt(rooms, std::array{inPlan(1.5, 1.5, 1)});
    // Half a metre behind what is met, and 1 to 1.6 from the eye.
    const glm::dvec3 least = inPlan(2.5, 1, 1), most = inPlan(2.6, 2.5, 1);
    EXPECT_FALSE(ways.mayMeet(least, most, 0.25));
    EXPECT_TRUE(ways.mayMeet(least, most, 0.55));
}

} // namespace
} // namespace scene
