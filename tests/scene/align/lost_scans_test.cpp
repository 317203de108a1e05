// Which scans nobody knows the place of.

#include "scene/align/lost_scans.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace scene {
namespace {

using testing::ElementsAre;

/// A scan of so many cells, given where; found: registered to the group of the scan of that number, there.
struct Known {
    Pose given;
    std::optional<std::size_t> group;
    Pose found{};
    int cells = 100;
};

Pose at(double x) {
    Pose pose;
    pose.translation.x = x;
    return pose;
}

std::vector<std::size_t> lostOf(const std::vector<Known>& scans) {
    std::vector<ScanView> views(scans.size());
    std::vector<FoundPlace> found;
    for (std::size_t i = 0; i < scans.size(); ++i) {
        views[i].givenWorldFromScanner = scans[i].given;
        views[i].panorama.cells = Image<PanoramaCell>(scans[i].cells + 1, 1);
        for (int x = 0; x < scans[i].cells; ++x)
            views[i].panorama.cells(x, 0).samples = 1;
        found.push_back({scans[i].group.has_value(), scans[i].group.value_or(i), scans[i].found});
    }
    const std::vector<bool> isLost = findLost(views, arePosesSaid(views), found);
    std::vector<std::size_t> lost;
    for (std::size_t i = 0; i < isLost.size(); ++i)
        if (isLost[i]) lost.push_back(i);
    return lost;
}

const Pose kOrigin{};

TEST(LostScans, NoneIsWhereAllWereSaidToStandSomewhere) {
    EXPECT_THAT(lostOf({}), ElementsAre());
    EXPECT_THAT(lostOf({{kOrigin, {}}}), ElementsAre());
    EXPECT_THAT(lostOf({{kOrigin, {}}, {at(3), {}}, {at(9), {}}}), ElementsAre()) << "one at the origin may be meant";
}

TEST(LostScans, OfThoseWithoutPoseTheLargestGroupStays) {
    EXPECT_THAT(lostOf({{kOrigin, {}}, {kOrigin, 1, kOrigin}, {kOrigin, 1, at(4)}}), ElementsAre(0));
    EXPECT_THAT(lostOf({{kOrigin, {}, {}, 0}, {kOrigin, {}}, {kOrigin, {}}}), ElementsAre(0, 2))
        << "where nothing is registered, the first that shows anything";
    Pose turned; // by its compass
    turned.rotation = glm::dmat3(0, 1, 0, -1, 0, 0, 0, 0, 1);
    EXPECT_THAT(lostOf({{kOrigin, 0, kOrigin}, {turned, 0, at(3)}, {turned, {}}}), ElementsAre(2));
}

TEST(LostScans, WhatWasSaidStaysUnlessItIsLess) {
    EXPECT_THAT(lostOf({{at(1), 0, at(1)}, {at(5), 0, at(5)}, {kOrigin, {}}, {kOrigin, {}}}), ElementsAre(2, 3))
        << "those with poses do not speak for those without";
    EXPECT_THAT(lostOf({{at(1), 0, at(1)}, {kOrigin, 0, at(5)}, {kOrigin, {}}}), ElementsAre(2));
    EXPECT_THAT(lostOf({{at(500), {}}, {kOrigin, 1, kOrigin}, {kOrigin, 1, at(3)}, {kOrigin, 1, at(6)}}),
                ElementsAre(0));
}

TEST(LostScans, NoneIsWhereTheOriginIsThatOfTheSite) {
    EXPECT_THAT(lostOf({{kOrigin, 0, kOrigin}, {kOrigin, 0, at(0.01)}, {kOrigin, 0, at(0.02)}, {kOrigin, {}}}),
                ElementsAre());
    EXPECT_THAT(lostOf({{kOrigin, 0, kOrigin}, {kOrigin, 0, kOrigin}, {kOrigin, {}}}), ElementsAre(2))
        << "two of one tripod prove nothing";
    EXPECT_THAT(lostOf({{kOrigin, 0, kOrigin}, {kOrigin, 0, kOrigin}, {kOrigin, 2, kOrigin}, {kOrigin, 2, kOrigin}}),
                ElementsAre(2, 3))
        << "nor two each of two";
    EXPECT_THAT(
        lostOf(
            {{kOrigin, 0, kOrigin}, {kOrigin, 0, kOrigin}, {kOrigin, 0, kOrigin}, {kOrigin, 0, at(9)}, {kOrigin, {}}}),
        ElementsAre())
        << "most";
}

} // namespace
} // namespace scene
