#include "scene/refine/contradiction.h"

#include "tests/repetitions.h"
#include "tests/scene/known_scenes.h"

#include <array>
#include <set>

#include <gtest/gtest.h>

namespace scene {
namespace {

constexpr int kWitnesses = 9;

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

/// So many images, the first of which agree with each other.
std::vector<SkinFigures> agreeing(std::uint32_t right, std::size_t all) {
    std::vector<SkinFigures> figures(all);
    for (SkinFigures& f : figures)
        f.samples = 100;
    for (std::uint32_t i = 0; i < right; ++i)
        for (std::uint32_t other = 0; other < right; ++other)
            if (other != i) figures[i].words.push_back({other, 60, 1});
    return figures;
}

TEST(Contradiction, RightImagesHaveNone) {
    EXPECT_TRUE(findContradictions(figuresOf(imagesOfBareRoom(kWitnesses))).empty());
}

TEST(Contradiction, TheOneImageWhosePoseIsWrongIsNamedAndNoOther) {
    const std::vector<DepthImage> right = imagesOfBareRoom(kWitnesses);
    constexpr std::array<std::size_t, 3> kWrong{0, 4, 7};
    constexpr std::array<glm::dvec3, 4> kAlong{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, -1}}};
    for (std::size_t i = 0; i < std::size_t{tests::repetitions(kWrong.size() * kAlong.size())}; ++i) {
        const std::size_t wrong = kWrong[i / kAlong.size()];
        const glm::dvec3& along = kAlong[i % kAlong.size()];
        std::vector<DepthImage> images = right;
        Pose& pose = images[wrong].worldFromCamera;
        pose.translation += pose.rotation * (0.7 * along);
        const std::vector<Contradiction> found = findContradictions(figuresOf(images));
        ASSERT_EQ(found.size(), 1u) << "image " << wrong << " along " << along.x << " " << along.y << " " << along.z;
        EXPECT_EQ(found.front().image, wrong);
    }
}

TEST(Contradiction, RangeInOtherUnitsThanTheRestIsNamed) {
    std::vector<DepthImage> images = imagesOfBareRoom(kWitnesses);
    for (float& disparity : images[3].disparity.pixels())
        disparity *= 1.5f;
    const std::vector<Contradiction> found = findContradictions(figuresOf(images));
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found.front().image, 3u);
}

TEST(Contradiction, EachOfSeveralIsNamedTheWorstFirst) {
    std::vector<SkinFigures> figures = agreeing(6, 8);
    const auto say = [&](std::size_t of, std::uint32_t by, std::int64_t agrees, std::int64_t sawThrough) {
        figures[of].words.push_back({by, agrees, sawThrough});
    };
    say(0, 6, 10, 60), say(6, 1, 5, 20); // 80 of 95
    say(7, 1, 1, 9), say(2, 7, 1, 30);   // 39 of 41
    say(7, 6, 20, 0);                    // they agree with each other
    const std::vector<Contradiction> found = findContradictions(figures);
    ASSERT_EQ(found.size(), 2u);
    EXPECT_EQ(found[0].image, 7u);
    EXPECT_DOUBLE_EQ(found[0].share, 39.0 / 41);
    EXPECT_EQ(found[1].image, 6u);
    EXPECT_DOUBLE_EQ(found[1].share, 80.0 / 95);
}

TEST(Contradiction, WhomOnlyAWrongOneContradictsIsNotNamed) {
    std::vector<SkinFigures> figures = agreeing(6, 8);
    figures[6].words = {{7, 5, 95}, {0, 20, 1}}; // right: the wrong one is most of what it knows
    figures[7].words = {{1, 60, 60}};
    const std::vector<Contradiction> found = findContradictions(figures);
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found.front().image, 7u);
    EXPECT_DOUBLE_EQ(found.front().share, 155.0 / 220);
    figures[6].words = {{7, 5, 95}, {0, 3, 1}}; // without the wrong one hardly anything is said of it
    ASSERT_EQ(findContradictions(figures).size(), 1u);
    EXPECT_EQ(findContradictions(figures).front().image, 7u);
}

TEST(Contradiction, WhomSeveralWrongOnesContradictIsNotNamedForThem) {
    std::vector<SkinFigures> figures = agreeing(6, 8);
    figures[6].words = {{0, 5, 95}};
    figures[7].words = {{0, 5, 95}};
    const auto namesOf = [&] {
        std::set<std::size_t> names;
        for (const Contradiction& contradiction : findContradictions(figures))
            names.insert(contradiction.image);
        return names;
    };
    EXPECT_EQ(namesOf(), (std::set<std::size_t>{6, 7}));
    figures[7].words = {{0, 20, 80}, {1, 20, 80}};
    EXPECT_EQ(namesOf(), (std::set<std::size_t>{6, 7}));
}

TEST(Contradiction, TwoThatNobodyCanTellApartHideNoOther) {
    std::vector<SkinFigures> figures = agreeing(6, 9);
    figures[6].words = {{0, 20, 30}, {1, 20, 30}};
    figures[7].words = {{8, 10, 90}};
    const std::vector<Contradiction> found = findContradictions(figures);
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found.front().image, 6u);
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
    figures[3].words = {{0, 1, 0}}; // one sample agrees by chance
    EXPECT_TRUE(findContradictions(figures).empty());
    figures[3].words = {{0, 60, 1}}; // one of them speaks for the first
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
