// Positions by lines of sight: in places of which it is known where they must stand, and against the article's search
// in a furnished room.

#include "tests/scene/plan/known_sites.h"

#include "scene/plan/sight_search.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdio>

#include <glm/geometric.hpp>
#include <tbb/global_control.h>

namespace scene {
namespace {

/// An empty corridor along x, 2 m wide and 3 m high; a wall may stand across it at x = 0.
struct Corridor {
    double halfLength = 4;
    bool isDivided = false;

    SightLines lines() const {
        const auto cast = [this](const glm::dvec3& from, const glm::dvec3& direction) -> std::optional<SightEnd> {
            const glm::dvec3 low(-halfLength, -1, 0), high(halfLength, 1, 3);
            double t = std::numeric_limits<double>::infinity();
            glm::dvec3 normal(0);
            for (int axis = 0; axis < 3; ++axis) {
                if (direction[axis] == 0) continue;
                const double wall = direction[axis] > 0 ? high[axis] : low[axis];
                const double there = (wall - from[axis]) / direction[axis];
                if (there < t) t = there, normal = glm::dvec3(axis == 0, axis == 1, axis == 2);
            }
            const double toMiddle = -from.x / direction.x;
            if (isDivided && toMiddle > 0 && toMiddle < t) t = toMiddle, normal = {1, 0, 0};
            return SightEnd{from + t * direction, normal};
        };
        const auto isBlocked = [this](const glm::dvec3& from, const glm::dvec3& to) {
            return isDivided && from.x * to.x < -1e-9;
        };
        return {cast, isBlocked};
    }

    std::vector<glm::dvec3> places() const {
        std::vector<glm::dvec3> places;
        for (double x = -halfLength + 0.25; x < halfLength; x += 0.5)
            for (const double y : {-0.5, 0.0, 0.5})
                places.emplace_back(x, y, 1.6);
        return places;
    }
};

TEST(SightSearch, OnePositionStandsOnEachSideOfAWall) {
    const Corridor corridor{4, true};
    SightSearchOptions options;
    options.mostStretch = 100;
    options.count = 1;
    const SightSearchResult one = searchBySight(corridor.places(), corridor.lines(), options);
    EXPECT_NEAR(one.unknownShare, 0.5, 0.02) << "half of the walkers stand beyond the wall";
    options.count = 2;
    const SightSearchResult two = searchBySight(corridor.places(), corridor.lines(), options);
    ASSERT_EQ(two.positions.size(), 2u);
    EXPECT_LT(two.positions[0].x * two.positions[1].x, 0);
    EXPECT_LT(two.unknownShare, 0.01);
}

TEST(SightSearch, WhatWasSeenTooThinlyIsNotKnown) {
    const Corridor corridor{20, false};
    SightSearchOptions options;
    options.count = 1;
    options.mostStretch = 1e6;
    EXPECT_EQ(searchBySight(corridor.places(), corridor.lines(), options).unknownShare, 0) << "nothing stands between";
    options.mostStretch = 2;
    const SightSearchResult one = searchBySight(corridor.places(), corridor.lines(), options);
    EXPECT_GT(one.unknownShare, 0.5);
    options.count = 5;
    const SightSearchResult five = searchBySight(corridor.places(), corridor.lines(), options);
    EXPECT_LT(five.unknownShare, 0.5 * one.unknownShare);
    double farthest = 0;
    for (const glm::dvec3& p : five.positions)
        farthest = std::max(farthest, std::abs(p.x));
    EXPECT_GT(farthest, 10) << "they spread over the corridor";
}

TEST(SightSearch, EndsWhereNoMoreIsToBeGained) {
    const Corridor corridor{4, true};
    SightSearchOptions options;
    options.mostStretch = 100;
    options.count = 20;
    options.leastGain = 0.01;
    EXPECT_EQ(searchBySight(corridor.places(), corridor.lines(), options).positions.size(), 2u);
}

TEST(SightSearch, TakesAllPlacesWhereThereAreNoMore) {
    const Corridor corridor{4, true};
    const std::vector<glm::dvec3> places{{-2, 0, 1.6}, {2, 0, 1.6}, {3, 0.5, 1.6}};
    for (const int count : {1, 2, 3}) {
        SightSearchOptions options;
        options.count = count;
        options.mostStretch = 100;
        const SightSearchResult found =
            searchBySight(std::span(places).first(static_cast<std::size_t>(count)), corridor.lines(), options);
        ASSERT_EQ(found.positions.size(), static_cast<std::size_t>(count));
        EXPECT_TRUE(std::is_permutation(found.positions.begin(), found.positions.end(), places.begin()));
        EXPECT_LT(found.unknownShare, 0.01) << "each walker stands at a position";
    }
}

TEST(SightSearch, TheSameOnOneThreadAndOnAll) {
    const KnownSite site = furnishedRoom();
    SightSearchOptions options;
    options.count = 5;
    options.walkers = 40;
    const SightSearchResult all = searchBySight(site.places, site.lines(), options);
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    const SightSearchResult alone = searchBySight(site.places, site.lines(), options);
    EXPECT_EQ(all.positions, alone.positions);
    EXPECT_EQ(all.unknownShare, alone.unknownShare);
}

TEST(SightSearch, KnowsMoreThanTheArticlesSearchWithoutLookingAtPictures) {
    const KnownSite site = furnishedRoom();
    // From six on less than 0.6 % is unknown, which is pixels along silhouettes: what the article's search looks at.
    for (const int count : {2, 4}) {
        SightSearchOptions options;
        options.count = count;
        const SightSearchResult bySight = searchBySight(site.places, site.lines(), options);
        const double share = unknownShareOf(bySight.positions, site.tests, site.capture());
        PositionSearchOptions article;
        article.count = count;
        article.search = CellSearch::genetic;
        const double genetic = searchPositions(site.places, site.tests, site.capture(), article).back().unknownShare;
        std::printf("%d positions: by sight %.4f (its own measure %.4f, %lld trials), genetic %.4f\n", count, share,
                    bySight.unknownShare, static_cast<long long>(bySight.trials), genetic);
        EXPECT_LE(share, 0.75 * genetic);
    }
}

} // namespace
} // namespace scene
