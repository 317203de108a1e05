#include "scene/refine/contradiction.h"

#include "tests/scene/known_scenes.h"

#include <gtest/gtest.h>

namespace scene {
namespace {

constexpr int kImages = 9;

/// What skins find of images that all know of each other.
std::vector<SkinFigures> figuresOf(const std::vector<DepthImage>& images) {
    ImageStore store(images);
    std::vector<ImageOutline> outlines;
    for (const DepthImage& image : images)
        outlines.push_back(outlineOf(image));
    const std::vector<std::vector<Partner>> partners = findPartners(outlines);
    std::vector<SkinFigures> figures(images.size());
    for (std::size_t i = 0; i < images.size(); ++i)
        markSkins(store, i, partners[i], {}, figures[i]);
    return figures;
}

TEST(Contradiction, RightImagesHaveNone) {
    EXPECT_TRUE(findContradictions(figuresOf(imagesOfBareRoom(kImages))).empty());
}

TEST(Contradiction, TheOneImageWhosePoseIsWrongIsNamedAndNoOther) {
    const std::vector<DepthImage> right = imagesOfBareRoom(kImages);
    for (const std::size_t wrong : {std::size_t{0}, std::size_t{4}, std::size_t{7}})
        for (const glm::dvec3 along : {glm::dvec3{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, -1}}) {
            std::vector<DepthImage> images = right;
            Pose& pose = images[wrong].worldFromCamera;
            pose.translation += pose.rotation * (0.7 * along);
            const std::vector<Contradiction> found = findContradictions(figuresOf(images));
            ASSERT_EQ(found.size(), 1u) << "image " << wrong << " along " << along.x << " " << along.y << " "
                                        << along.z;
            EXPECT_EQ(found.front().image, wrong);
        }
}

TEST(Contradiction, RangeInOtherUnitsThanTheRestIsNamed) {
    std::vector<DepthImage> images = imagesOfBareRoom(kImages);
    for (float& disparity : images[3].disparity.pixels())
        disparity *= 1.5f;
    const std::vector<Contradiction> found = findContradictions(figuresOf(images));
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found.front().image, 3u);
}

TEST(Contradiction, EachOfSeveralIsNamedTheWorstFirst) {
    std::vector<SkinFigures> figures(8);
    for (std::uint32_t i = 0; i < figures.size(); ++i) {
        figures[i].samples = 100;
        for (std::uint32_t other = 0; other < 6 && i < 6; ++other)
            if (other != i) figures[i].words.push_back({other, 60, 1});
    }
    const auto say = [&](std::size_t of, std::uint32_t by, std::int64_t agrees, std::int64_t sawThrough) {
        figures[of].words.push_back({by, agrees, sawThrough});
    };
    say(0, 6, 10, 60), say(6, 1, 5, 20); // with the last pair 80 of 115
    say(7, 1, 1, 9), say(2, 7, 1, 30);   // with it 39 of 61, without image 6 39 of 41
    say(7, 6, 20, 0);
    const std::vector<Contradiction> found = findContradictions(figures);
    ASSERT_EQ(found.size(), 2u);
    EXPECT_EQ(found[0].image, 6u);
    EXPECT_DOUBLE_EQ(found[0].share, 80.0 / 115);
    EXPECT_EQ(found[1].image, 7u);
    EXPECT_DOUBLE_EQ(found[1].share, 39.0 / 41);
}

TEST(Contradiction, FewWordsAreNoEvidence) {
    std::vector<SkinFigures> figures(3);
    for (SkinFigures& f : figures)
        f.samples = 1000;
    figures[0].words = {{1, 900, 5}, {2, 1, 30}};
    EXPECT_TRUE(findContradictions(figures).empty());
    figures[0].words = {{1, 900, 5}, {2, 1, 60}};
    ASSERT_EQ(findContradictions(figures).size(), 1u);
    EXPECT_EQ(findContradictions(figures).front().image, 2u);
}

TEST(Contradiction, OfTwoNobodyKnowsWhichIsWrong) {
    std::vector<SkinFigures> figures(4);
    for (SkinFigures& f : figures)
        f.samples = 100;
    figures[0].words = {{1, 10, 80}};
    figures[1].words = {{0, 5, 90}};
    EXPECT_TRUE(findContradictions(figures).empty());
    figures[2].words = {{3, 90, 1}}; // two more, which neither of them sees
    EXPECT_TRUE(findContradictions(figures).empty());
    figures[3].words = {{0, 60, 1}}; // one of which speaks for the first
    ASSERT_EQ(findContradictions(figures).size(), 1u);
    EXPECT_EQ(findContradictions(figures).front().image, 1u);
}

TEST(Contradiction, WhatSpeaksAgainstAllAlikeNamesNone) {
    std::vector<SkinFigures> figures(6);
    for (std::size_t i = 0; i < figures.size(); ++i) {
        figures[i].samples = 100;
        for (std::uint32_t other = 0; other < figures.size(); ++other)
            if (other != i) figures[i].words.push_back({other, 60, 20 + static_cast<std::int64_t>(i)});
    }
    EXPECT_TRUE(findContradictions(figures).empty());
}

} // namespace
} // namespace scene
