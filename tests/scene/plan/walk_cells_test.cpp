// Which positions are drawn with what share: by the rule asked of every cell, for positions that lie in every way,
// along paths that cross whatever there is to cross.

#include "scene/plan/simplex.h"
#include "scene/plan/walk_cells.h"
#include "tests/repetitions.h"
#include "tests/scene/random_poses.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include <glm/geometric.hpp>

namespace scene {
namespace {

using Positions = std::vector<glm::dvec3>;

Positions scattered(int count, unsigned seed, double extent = 4) {
    RandomPlaces places(seed);
    Positions positions;
    for (int i = 0; i < count; ++i)
        positions.push_back(places.point(extent));
    return positions;
}

struct Lying {
    std::string name;
    Positions positions;
    int dimension = 3;
};

/// Every way in which positions may lie, and how many dimensions their cells then have.
std::vector<Lying> allWays() {
    RandomPlaces places(5);
    Positions line, plane, tripod, sphere, equal(20, glm::dvec3(1, 2, 3)), twice = scattered(20, 9);
    // Whole numbers, so that they lie so exactly.
    for (int i = 0; i < 50; ++i)
        line.push_back(glm::dvec3(1, 2, -1) * static_cast<double>(places.integerBetween(-1000, 1000)));
    for (int i = 0; i < 50; ++i)
        plane.push_back(glm::dvec3(1, 0, 2) * static_cast<double>(places.integerBetween(-9, 9)) +
                        glm::dvec3(0, 1, -1) * static_cast<double>(places.integerBetween(-9, 9)));
    for (int i = 0; i < 12; ++i)
        tripod.push_back({places.between(-8, 8), places.between(-8, 8), 1.6});
    // (3, 4, 0), (0, 0, 5) and such: all exactly at distance 5 times 13 from the middle; and others, nearly.
    for (const double a : {-1.0, 1.0})
        for (const double b : {-1.0, 1.0})
            for (const auto& [p, q, r] : {std::array{3.0, 4.0, 0.0},
                                          {4.0, 3.0, 0.0},
                                          {0.0, 3.0, 4.0},
                                          {0.0, 4.0, 3.0},
                                          {3.0, 0.0, 4.0},
                                          {4.0, 0.0, 3.0},
                                          {5.0, 0.0, 0.0},
                                          {0.0, 5.0, 0.0}})
                sphere.push_back({a * p, b * q, a * b * r});
    while (sphere.size() < 50)
        sphere.push_back(5.0 * glm::normalize(places.point(1)));
    for (int i = 0; i < 20; ++i)
        twice.push_back(twice[static_cast<std::size_t>(i)]);
    Positions far = scattered(30, 11);
    for (glm::dvec3& p : far)
        p += glm::dvec3(1e6, -1e6, 1e6);
    Positions grid;
    for (int x = 0; x < 4; ++x)
        for (int y = 0; y < 4; ++y)
            for (int z = 0; z < 3; ++z)
                grid.push_back({x, y, z});
    Positions uneven = scattered(20, 13, 0.05);
    for (const glm::dvec3& p : scattered(20, 14, 40))
        uneven.push_back(p);
    return {{"one", {{1, 2, 3}}, 0},
            {"two", {{0, 0, 0}, {1, 2, 3}}, 1},
            {"three", {{0, 0, 0}, {1, 2, 3}, {4, 0, 0}}, 2},
            {"three in a line", {{0, 0, 0}, {1, 2, 3}, {2, 4, 6}}, 1},
            {"four", {{0, 0, 0}, {3, 0, 0}, {0, 3, 0}, {0, 0, 3}}, 3},
            {"fifty in a line", line, 1},
            {"fifty in a plane", plane, 2},
            {"tripods", tripod, 2},
            {"fifty on a sphere", sphere, 3},
            {"all equal", equal, 0},
            {"each twice", twice, 3},
            {"a million metres away", far, 3},
            {"a grid", grid, 3},
            {"a cluster in the wide", uneven, 3},
            {"fifty anywhere", scattered(50, 7), 3}};
}

/// The greatest distance of a place that matters from the first position.
double extentOf(const Positions& positions) {
    double extent = 1;
    for (const glm::dvec3& p : positions)
        extent = std::max(extent, glm::length(p - positions[0]));
    return extent;
}

std::array<glm::dvec3, 4> cornersOf(const WalkCells& cells, const WalkCell& cell) {
    std::array<glm::dvec3, 4> corners{};
    for (std::size_t i = 0; i < 4; ++i)
        corners[i] = cells.corners()[cell.corners[i]];
    return corners;
}

/// The rule, asked of every cell; by place in corners().
std::vector<double> sharesByRule(const WalkCells& cells, const glm::dvec3& p) {
    const auto count = static_cast<std::size_t>(cells.dimension() + 1);
    const auto nearestIn = [&](const WalkCell& cell, const glm::dvec3& to) {
        const auto corners = cornersOf(cells, cell);
        return nearestInSimplex(std::span(corners).first(count), to);
    };
    glm::dvec3 at = p;
    double least = std::numeric_limits<double>::infinity();
    for (const WalkCell& cell : cells.cells()) {
        const glm::dvec3 place = nearestIn(cell, p);
        if (glm::length(place - p) < least) least = glm::length(place - p), at = place;
    }
    double reach = std::numeric_limits<double>::infinity();
    for (const glm::dvec3& a : cells.corners()) {
        double spacing = std::numeric_limits<double>::infinity();
        for (const glm::dvec3& b : cells.corners())
            if (a != b) spacing = std::min(spacing, glm::length(a - b));
        reach = std::min(reach, kReachShare * (spacing + glm::length(a - at)));
    }
    std::vector<double> shares(cells.corners().size(), 0.0);
    for (const WalkCell& cell : cells.cells()) {
        const double share = cells.dimension() == 0 ? 1 : 1 - glm::length(nearestIn(cell, at) - at) / reach;
        for (std::size_t i = 0; i < count; ++i)
            shares[cell.corners[i]] = std::max(shares[cell.corners[i]], share);
    }
    return shares;
}

std::vector<double> sharesByPosition(const WalkCells& cells, std::size_t positions, const glm::dvec3& p,
                                     std::uint32_t& cell) {
    std::vector<PositionShare> found;
    cells.sharesAt(p, cell, found);
    std::vector<double> shares(positions, 0.0);
    for (const PositionShare& share : found)
        shares[share.position] = static_cast<double>(share.share);
    return shares;
}

TEST(WalkCells, AreWhatTheRuleSaysHoweverPositionsLie) {
    for (const Lying& way : allWays()) {
        SCOPED_TRACE(way.name);
        const WalkCells cells(way.positions);
        ASSERT_EQ(cells.dimension(), way.dimension);
        const double extent = extentOf(way.positions);
        RandomPlaces places(3);
        std::uint32_t cell = 0;
        for (int i = 0; i < 200; ++i) {
            const glm::dvec3 p = way.positions[0] + places.point(i % 2 == 0 ? extent : 3 * extent);
            const std::vector<double> shares = sharesByPosition(cells, way.positions.size(), p, cell);
            const std::vector<double> expected = sharesByRule(cells, p);
            for (std::size_t k = 0; k < way.positions.size(); ++k) {
                const auto corner = std::find(cells.corners().begin(), cells.corners().end(), way.positions[k]);
                ASSERT_NE(corner, cells.corners().end());
                EXPECT_NEAR(shares[k], expected[static_cast<std::size_t>(corner - cells.corners().begin())], 1e-5);
            }
            EXPECT_GE(std::count(shares.begin(), shares.end(), 1.0), way.dimension + 1) << "the walker's own cell";
        }
    }
}

TEST(WalkCells, PositionsThatAreNearlyFlatHaveFlatCells) {
    for (const double uneven : {5e-7, 0.02}) {
        RandomPlaces places(17);
        Positions tripods, line;
        for (int x = 0; x < 4; ++x)
            for (int y = 0; y < 4; ++y)
                tripods.push_back({3 * x + places.between(-0.8, 0.8), 3 * y + places.between(-0.8, 0.8),
                                   1.6 + places.between(-uneven, uneven)});
        for (int i = 0; i < 10; ++i)
            line.push_back({2.0 * i, places.between(-uneven, uneven), 1.6 + places.between(-uneven, uneven)});
        const WalkCells cells(tripods), along(line);
        EXPECT_EQ(cells.dimension(), 2) << uneven;
        EXPECT_EQ(along.dimension(), 1) << uneven;
        for (const glm::dvec3& corner : cells.corners())
            EXPECT_EQ(std::count(tripods.begin(), tripods.end(), corner), 1) << "shown where they are";
        std::uint32_t cell = 0;
        double whole = 0;
        constexpr int kPlaces = 500;
        for (int i = 0; i < kPlaces; ++i) {
            const glm::dvec3 p(places.between(1, 8), places.between(1, 8), places.between(1, 2.2));
            const std::vector<double> shares = sharesByPosition(cells, tripods.size(), p, cell);
            whole += static_cast<double>(std::count(shares.begin(), shares.end(), 1.0));
            for (std::size_t k = 0; k < shares.size(); ++k)
                if (shares[k] > 0) {
                    EXPECT_LE(glm::length(tripods[k] - p), 9) << "at the other end of the place";
                }
        }
        EXPECT_LE(whole / kPlaces, 3.01);
        for (std::size_t i = 0; i < tripods.size(); ++i)
            EXPECT_NEAR(sharesByPosition(cells, tripods.size(), tripods[i], cell)[i], 1.0, 1e-6);
    }
    // What is a storey higher is not flat.
    EXPECT_EQ(WalkCells(Positions{{0, 0, 0}, {3, 0, 0}, {0, 3, 0}, {3, 3, 0.6}}).dimension(), 3);
}

TEST(WalkCells, AtAPositionItsImagesAreWhole) {
    for (const Lying& way : allWays()) {
        SCOPED_TRACE(way.name);
        const WalkCells cells(way.positions);
        std::uint32_t cell = 0;
        for (std::size_t i = 0; i < way.positions.size(); ++i)
            EXPECT_NEAR(sharesByPosition(cells, way.positions.size(), way.positions[i], cell)[i], 1.0, 1e-6);
    }
}

TEST(WalkCells, FewPositionsAreDrawnHoweverManyThereAre) {
    const Positions positions = scattered(2000, 21);
    const WalkCells cells(positions);
    RandomPlaces places(22);
    std::vector<PositionShare> shares;
    std::uint32_t cell = 0;
    double drawn = 0;
    constexpr int kPlaces = 2000;
    for (int i = 0; i < kPlaces; ++i) {
        cells.sharesAt(places.point(4), cell, shares);
        for (const PositionShare& share : shares)
            drawn += static_cast<double>(share.share);
    }
    // Four, and what comes in and goes out of neighbouring cells.
    EXPECT_LE(drawn / kPlaces, 8);
    EXPECT_GE(drawn / kPlaces, 4);
}

TEST(WalkCells, LocateFindsTheCellThatHoldsThePlaceFromAnywhere) {
    const Positions positions = scattered(300, 31);
    const WalkCells cells(positions);
    RandomPlaces places(32);
    for (int i = 0; i < tests::repetitions(2000); ++i) {
        const glm::dvec3 p = places.point(3);
        const auto from =
            static_cast<std::uint32_t>(places.integerBetween(0, static_cast<int>(cells.cells().size()) - 1));
        const auto corners = cornersOf(cells, cells.cells()[cells.locate(p, from)]);
        const auto nearestOfAll = [&] {
            double least = std::numeric_limits<double>::infinity();
            for (const WalkCell& cell : cells.cells())
                least = std::min(least, glm::length(nearestInSimplex(cornersOf(cells, cell), p) - p));
            return least;
        };
        EXPECT_LE(glm::length(nearestInSimplex(corners, p) - p), nearestOfAll() + 1e-9);
    }
}

/// A place to go through: a corner, or on an edge or a face of some cell.
glm::dvec3 somethingToCross(const WalkCells& cells, int kind, RandomPlaces& places) {
    const WalkCell& cell =
        cells.cells()[static_cast<std::size_t>(places.integerBetween(0, static_cast<int>(cells.cells().size()) - 1))];
    const auto corners = cornersOf(cells, cell);
    glm::dvec3 p = corners[0];
    for (int i = 1; i <= std::min(kind, cells.dimension()); ++i)
        p += places.between(0, 1.0 / kind) * (corners[static_cast<std::size_t>(i)] - corners[0]);
    return p;
}

TEST(WalkCells, SharesNeverJumpAlongAnyPath) {
    constexpr double kStepMetres = 0.001;
    constexpr int kPaths = tests::repetitions(1000), kStepsEachWay = 60;
    const std::vector<Lying> ways = allWays();
    std::vector<WalkCells> all;
    for (const Lying& way : ways)
        all.emplace_back(way.positions);
    RandomPlaces places(41);
    double worst = 0;
    for (int path = 0; path < kPaths; ++path) {
        const std::size_t way = static_cast<std::size_t>(path) % ways.size();
        SCOPED_TRACE(ways[way].name);
        const WalkCells& cells = all[way];
        const glm::dvec3 through = somethingToCross(cells, path / static_cast<int>(ways.size()) % 4, places);
        const glm::dvec3 step = kStepMetres * glm::normalize(places.point(1));
        std::uint32_t cell = 0;
        std::vector<double> before;
        for (int i = -kStepsEachWay; i <= kStepsEachWay; ++i) {
            const glm::dvec3 p = through + static_cast<double>(i) * step;
            const std::vector<double> shares = sharesByPosition(cells, ways[way].positions.size(), p, cell);
            if (!before.empty() && cells.dimension() > 0) {
                // As the head of the file bounds it; where positions stand a millimetre apart, a step crosses cells.
                const double bound = kShareSlope * kStepMetres * kReachShare / cells.reachAt(p);
                for (std::size_t k = 0; k < shares.size(); ++k) {
                    const double change = std::abs(shares[k] - before[k]);
                    EXPECT_LE(change, 1.05 * bound + 1e-6) << "step " << i;
                    worst = std::max(worst, change / bound);
                }
            }
            before = shares;
        }
    }
    EXPECT_GT(worst, 0.3) << "nothing was crossed";
}

TEST(WalkCells, ThePapersRuleJumpsWhereAPathCrossesAnEdgeAndThisOneDoesNot) {
    // Six cells about one edge from (0, 0, -1) to (0, 0, 1): right across it lies a cell that shares the edge alone.
    Positions positions{{0, 0, -1}, {0, 0, 1}};
    for (int i = 0; i < 6; ++i)
        positions.push_back({std::cos(i * 1.0471975511965976), std::sin(i * 1.0471975511965976), 0.01 * i});
    const WalkCells cells(positions);
    const glm::dvec3 before{0.001, 0.0005, 0.02}, after = glm::dvec3(0, 0, 0.04) - before;
    const std::uint32_t cell = cells.locate(before), beyond = cells.locate(after);
    // A corner of the cell beyond that neither the cell nor a neighbour of it has.
    std::uint32_t unknown = WalkCell::kNoCell;
    for (const std::uint32_t corner : cells.cells()[beyond].corners) {
        bool isKnown = false;
        const WalkCell& own = cells.cells()[cell];
        for (std::size_t i = 0; i < 4; ++i) {
            isKnown = isKnown || own.corners[i] == corner;
            if (own.neighbours[i] == WalkCell::kNoCell) continue;
            const WalkCell& next = cells.cells()[own.neighbours[i]];
            isKnown = isKnown || std::count(std::begin(next.corners), std::end(next.corners), corner) > 0;
        }
        if (!isKnown) unknown = corner;
    }
    ASSERT_NE(unknown, WalkCell::kNoCell) << "the paper, which draws a cell's corners and those of its neighbours, "
                                             "draws nothing of it before the edge, and all of it right after";
    std::uint32_t from = 0;
    std::vector<PositionShare> shares;
    cells.sharesAt(before, from, shares);
    const auto found = std::find_if(shares.begin(), shares.end(), [&](const PositionShare& share) {
        return positions[share.position] == cells.corners()[unknown];
    });
    ASSERT_NE(found, shares.end());
    EXPECT_GE(found->share, 0.98f);
}

} // namespace
} // namespace scene
