// Which images a walker is drawn: when there are cells to walk by, what they say, and what is fetched ahead.

#include "app/overlays.h"
#include "app/selection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <set>
#include <string>

namespace app {
namespace {

scene::Scene sceneOf(std::span<const glm::dvec3> positions, int imagesEach, bool isWhole = true) {
    scene::Scene scene;
    scene.hasWholeImages = isWhole;
    for (const glm::dvec3& position : positions)
        for (int i = 0; i < imagesEach; ++i) {
            scene::SceneImage image;
            image.name = std::to_string(scene.images.size());
            image.worldFromCamera.translation = position;
            scene.images.push_back(image);
        }
    return scene;
}

/// Corners of squares of 2 m along a street.
std::vector<glm::dvec3> alongAStreet() {
    std::vector<glm::dvec3> positions;
    for (int i = 0; i < 10; ++i) {
        positions.push_back({2.0 * i, 1.6, 0});
        positions.push_back({2.0 * i + 0.1, 1.6, -2});
    }
    return positions;
}

std::array<scene::View, 2> eyesAt(const glm::dvec3& head) {
    std::array<scene::View, 2> eyes;
    eyes[0].worldFromEye.translation = head - glm::dvec3(0.03, 0, 0);
    eyes[1].worldFromEye.translation = head + glm::dvec3(0.03, 0, 0);
    return eyes;
}

std::set<std::size_t> drawn(std::span<const float> shares) {
    std::set<std::size_t> images;
    for (std::size_t i = 0; i < shares.size(); ++i)
        if (shares[i] > 0) images.insert(i);
    return images;
}

TEST(Selection, ThereAreCellsWhereWholeImagesWereTakenAllRound) {
    EXPECT_TRUE(Selection(sceneOf(alongAStreet(), 6)).hasCells());
    EXPECT_TRUE(Selection(sceneOf(std::array{glm::dvec3(1, 2, 3)}, 6)).hasCells());
    EXPECT_FALSE(Selection(sceneOf(alongAStreet(), 6, false)).hasCells()) << "a surface may stand in one image alone";
    EXPECT_FALSE(Selection(sceneOf(alongAStreet(), 1)).hasCells()) << "photographs";
    EXPECT_FALSE(Selection(sceneOf({}, 0)).hasCells());
    scene::Scene mixed = sceneOf(alongAStreet(), 6);
    mixed.images.push_back(mixed.images.back());
    mixed.images.back().worldFromCamera.translation.z -= 1;
    EXPECT_FALSE(Selection(mixed).hasCells()) << "about a lone photograph a cell would show too little";
}

TEST(Selection, ImagesFromOnePlaceAreOnePosition) {
    const auto positions = alongAStreet();
    const ReferencePositions found = referencePositionsOf(sceneOf(positions, 6).images);
    EXPECT_EQ(found.places, positions);
    for (std::size_t i = 0; i < found.positionOf.size(); ++i)
        EXPECT_EQ(found.positionOf[i], i / 6);
}

TEST(Selection, PhotographsBesideAScannerBelongToItsPosition) {
    scene::Scene scene = sceneOf(alongAStreet(), 6);
    const std::size_t scans = scene.images.size();
    const auto photograph = [&](const glm::dvec3& place) {
        scene.images.push_back(scene.images.back());
        scene.images.back().worldFromCamera.translation = place;
    };
    photograph(alongAStreet()[3] + glm::dvec3(0, 0.2, 0.1));
    photograph(alongAStreet()[3] + glm::dvec3(0.02, 0.2, 0.1));
    const ReferencePositions found = referencePositionsOf(scene.images);
    EXPECT_EQ(found.places, alongAStreet());
    EXPECT_EQ(found.positionOf[scans], 3u);
    EXPECT_EQ(found.positionOf[scans + 1], 3u);
    EXPECT_TRUE(Selection(scene).hasCells());
    photograph(alongAStreet()[3] + glm::dvec3(0, 0, 1));
    EXPECT_FALSE(Selection(scene).hasCells()) << "from a place of its own";
}

TEST(Selection, OnlyImagesAboutTheWalkerAreDrawnAndBothEyesHaveTheSame) {
    Selection selection(sceneOf(alongAStreet(), 6));
    const render::ImageShares shares = selection.choose(eyesAt({9.0, 1.7, -1.1}), {});
    ASSERT_EQ(shares.now.size(), 120u);
    const std::set<std::size_t> images = drawn(shares.now);
    EXPECT_GE(images.size(), 18u) << "three corners, six images each";
    EXPECT_LE(images.size(), 36u);
    for (const std::size_t image : images)
        EXPECT_LE(std::abs(2.0 * static_cast<double>(image / 12) - 9.0), 3.1) << "of position " << image / 6;
    EXPECT_TRUE(std::equal(shares.now.begin(), shares.now.end(), shares.soon.begin())) << "nobody walks";
}

TEST(Selection, WhatTheWayLeadsToIsFetchedBeforeItIsDrawn) {
    Selection selection(sceneOf(alongAStreet(), 6));
    std::set<std::size_t> fetched;
    for (int frame = 0; frame < 900; ++frame) {
        const double seconds = frame / 90.0;
        const render::ImageShares shares = selection.choose(eyesAt({1.0 + 1.4 * seconds, 1.7, -1.1}), {}, seconds);
        const std::set<std::size_t> now = drawn(shares.now), soon = drawn(shares.soon);
        EXPECT_TRUE(std::includes(soon.begin(), soon.end(), now.begin(), now.end()));
        if (frame >= 60) { // the first ones nobody could foresee
            EXPECT_TRUE(std::includes(fetched.begin(), fetched.end(), now.begin(), now.end())) << "frame " << frame;
        }
        fetched.insert(soon.begin(), soon.end());
        if (frame < 600) {
            EXPECT_LT(fetched.size(), 120u) << "all of it is no foresight";
        }
    }
    // Who is put somewhere else does not walk there.
    const render::ImageShares there = selection.choose(eyesAt({1.0, 1.7, -1.1}), {}, 900 / 90.0);
    EXPECT_EQ(drawn(there.now), drawn(there.soon));
}

TEST(Selection, AKnobTurnsItOff) {
    Selection selection(sceneOf(alongAStreet(), 6));
    render::Quality quality;
    quality.walksByCells = false;
    const render::ImageShares shares = selection.choose(eyesAt({9.0, 1.7, -1.1}), quality);
    EXPECT_TRUE(shares.now.empty());
    EXPECT_TRUE(shares.soon.empty());
}

TEST(Overlays, CellsAreEdgesBetweenPositionsAndTheWalkersOwnIsMarked) {
    Selection selection(sceneOf(alongAStreet(), 6));
    const glm::dvec3 head(9.0, 1.7, -1.1);
    selection.choose(eyesAt(head), {});
    render::Overlay overlay;
    addCells(overlay, {}, selection, head, 7);
    std::size_t own = 0, others = 0;
    for (const render::Segment& segment : overlay.segments) {
        if (segment.colour == kAllowedColour) ++own;
        const bool isEdge = segment.a.y == segment.b.y && segment.a.y < 1.5;
        if (isEdge && segment.colour == kGridColour) ++others;
        if (isEdge) {
            EXPECT_NEAR(segment.a.y, 1.6 - kFlatCellsLowerMetres, 1e-9) << "positions lie in a plane";
        }
    }
    EXPECT_EQ(own, 3u) << "of a triangle";
    EXPECT_EQ(others, 4u) << "seven were asked for";
    EXPECT_TRUE(std::any_of(overlay.labels.begin(), overlay.labels.end(),
                            [](const render::Label& label) { return label.text.find("100 %") != std::string::npos; }));
    render::Overlay none;
    addCells(none, {}, Selection(sceneOf({}, 0)), head);
    EXPECT_TRUE(none.empty());
}

} // namespace
} // namespace app
