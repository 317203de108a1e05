// Silhouettes that a depth camera puts beside those of its photographs, against images whose true range is known.

#include "scene/refine/silhouettes.h"

#include "tests/repetitions.h"
#include "tests/scene/known_scenes.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace scene {
namespace {

constexpr int kAcross = 5, kDown = 3;
constexpr std::size_t kMiddle = 7;

/// The furnished room from places 10 cm apart, that all look at its table.
std::vector<DepthImage> nearbyImages() {
    const SyntheticScene room = makeRoom();
    const Camera camera{256, 192, 210, 210, 128, 96};
    std::vector<DepthImage> images;
    for (int j = 0; j < kDown; ++j)
        for (int i = 0; i < kAcross; ++i) {
            const glm::dvec3 eye(1.2 + 0.1 * i, 1.0, 1.5 + 0.1 * j);
            images.push_back(renderTruth(room, viewFrom(eye, {2.6, 2.4, 0.6}, camera), tests::repetitions(4)));
            images.back().name = std::to_string(images.size() - 1);
        }
    return images;
}

const std::vector<DepthImage>& truth() {
    static const std::vector<DepthImage> images = nearbyImages();
    return images;
}

std::vector<std::vector<Partner>> partnersOf(const std::vector<DepthImage>& images) {
    std::vector<ImageOutline> outlines;
    for (const DepthImage& image : images)
        outlines.push_back(outlineOf(image));
    return findPartners(outlines);
}

/// What a depth camera makes of it: each thing wider by `pixels` than in the photograph (or narrower, if negative).
DepthImage widened(DepthImage image, int pixels) {
    const Image<float> disparity = image.disparity;
    const int r = std::abs(pixels);
    for (int y = 0; y < disparity.height(); ++y)
        for (int x = 0; x < disparity.width(); ++x)
            for (int j = std::max(y - r, 0); j <= std::min(y + r, disparity.height() - 1); ++j)
                for (int i = std::max(x - r, 0); i <= std::min(x + r, disparity.width() - 1); ++i) {
                    const float d = disparity(i, j);
                    float& mine = image.disparity(x, y);
                    if (!isSurface(image.flags(i, j)) || !isSurface(image.flags(x, y))) continue;
                    mine = pixels > 0 ? std::max(mine, d) : std::min(mine, d);
                }
    return image;
}

/// No two images alike, as where a camera's range and its photograph are taken at different moments.
std::vector<DepthImage> unevenlyWidened() {
    std::vector<DepthImage> images;
    for (std::size_t i = 0; i < truth().size(); ++i)
        images.push_back(widened(truth()[i], i % 3 == 0 ? 3 : i % 3 == 1 ? 2 : -2));
    return images;
}

/// Whether two disparities are of surfaces that a jump lies between.
bool areApart(float a, float b) {
    return std::abs(a - b) > 0.08f * std::max(a, b);
}

/// Samples on another surface than the true one before, those of them that are on the true one after, and those that
/// left it.
struct Changes {
    int wrong = 0, mended = 0, spoilt = 0;
};
Changes changesOf(const std::vector<DepthImage>& before, const std::vector<DepthImage>& after) {
    Changes changes;
    for (std::size_t k = 0; k < before.size(); ++k)
        for (std::size_t i = 0; i < before[k].disparity.size(); ++i) {
            if (!isSurface(truth()[k].flags.pixels()[i])) continue;
            const float should = truth()[k].disparity.pixels()[i];
            const bool wasWrong = areApart(before[k].disparity.pixels()[i], should);
            const bool isWrong = areApart(after[k].disparity.pixels()[i], should);
            changes.wrong += wasWrong, changes.mended += wasWrong && !isWrong, changes.spoilt += !wasWrong && isWrong;
        }
    return changes;
}

SilhouetteVerdict judged(const std::vector<DepthImage>& images) {
    ImageStore store(images);
    return judgeSilhouettes(store, partnersOf(images), {});
}

std::vector<DepthImage> settled(const std::vector<DepthImage>& images) {
    const auto partners = partnersOf(truth());
    ImageStore store(images);
    std::vector<DepthImage> after;
    SilhouetteFigures figures;
    for (std::size_t i = 0; i < images.size(); ++i)
        after.push_back(settleSilhouettes(store, i, partners[i], {}, figures));
    return after;
}

/// unevenlyWidened after a round.
const std::vector<DepthImage>& settledOnce() {
    static const std::vector<DepthImage> images = settled(unevenlyWidened());
    return images;
}

TEST(Silhouettes, OfExactRangeAreRight) {
    const SilhouetteVerdict verdict = judged(truth());
    EXPECT_GT(verdict.samples, 1000);
    EXPECT_TRUE(verdict.areRight({})) << verdict.doubt() << ", " << verdict.seenThroughShare();
    EXPECT_LT(verdict.seenThroughShare(), 0.01);
}

TEST(Silhouettes, OfADepthCameraAreNot) {
    const SilhouetteVerdict verdict = judged(unevenlyWidened());
    EXPECT_FALSE(verdict.areRight({})) << verdict.doubt() << ", " << verdict.seenThroughShare();
}

TEST(Silhouettes, GoWhereThePhotographsHaveThem) {
    const std::vector<DepthImage> before = unevenlyWidened();
    const std::vector<DepthImage>& once = settledOnce();
    const std::vector<DepthImage> twice = settled(once);
    const Changes first = changesOf(before, once), both = changesOf(before, twice);
    std::printf("samples on the wrong surface: %d; a round mends %d and spoils %d, two %d and %d\n", first.wrong,
                first.mended, first.spoilt, both.mended, both.spoilt);
    // What has too little colour or parallax to tell stays where it was.
    EXPECT_GT(first.mended, 0.25 * first.wrong);
    EXPECT_LT(first.spoilt, 0.2 * first.mended);
    EXPECT_GT(both.mended, first.mended);
    EXPECT_LT(both.spoilt, 0.3 * both.mended);
}

TEST(Silhouettes, SaysWhatWasMovedAndTouchesNothingElse) {
    std::vector<DepthImage> images = unevenlyWidened();
    const DepthImage before = images[kMiddle];
    const auto partners = partnersOf(truth());
    ImageStore store(std::move(images));
    SilhouetteFigures figures;
    const DepthImage after = settleSilhouettes(store, kMiddle, partners[kMiddle], {}, figures);
    std::int64_t moved = 0;
    for (std::size_t i = 0; i < before.disparity.size(); ++i) {
        const bool isMoved = after.disparity.pixels()[i] != before.disparity.pixels()[i];
        const int mark = isMoved ? kInterpolated : 0;
        ASSERT_EQ(after.flags.pixels()[i], before.flags.pixels()[i] | mark) << "pixel " << i;
        moved += isMoved;
    }
    EXPECT_EQ(moved, figures.moved);
    EXPECT_GT(moved, 100);
    EXPECT_GT(figures.contested, moved);
    EXPECT_EQ(after.colour, before.colour);
}

TEST(Silhouettes, WhatHasNoRangeBecomesAGuessOnTheSideOfItsColours) {
    std::vector<DepthImage> images = truth();
    DepthImage& image = images[kMiddle];
    // Range is missing along all jumps, as where near and far hide the projector's light from the camera.
    const DepthImage wide = widened(image, 2), narrow = widened(image, -2);
    int missing = 0;
    for (std::size_t i = 0; i < image.disparity.size(); ++i) {
        if (wide.disparity.pixels()[i] - narrow.disparity.pixels()[i] <= 0.08f * wide.disparity.pixels()[i]) continue;
        image.disparity.pixels()[i] = 0, image.flags.pixels()[i] = kNoSurface;
        ++missing;
    }
    const DepthImage holed = image;
    const auto partners = partnersOf(truth());
    ImageStore store(std::move(images));
    SilhouetteFigures figures;
    const DepthImage after = settleSilhouettes(store, kMiddle, partners[kMiddle], {}, figures);
    int guessed = 0, right = 0;
    for (std::size_t i = 0; i < after.disparity.size(); ++i) {
        if (holed.flags.pixels()[i] != kNoSurface) continue;
        if (after.disparity.pixels()[i] <= 0) continue;
        ASSERT_TRUE(isGuess(after.flags.pixels()[i])) << "never a surface";
        ++guessed;
        right += !areApart(after.disparity.pixels()[i], truth()[kMiddle].disparity.pixels()[i]);
    }
    std::printf("%d of %d without range guessed, %d on the right surface\n", guessed, missing, right);
    EXPECT_GT(guessed, missing / 3);
    EXPECT_GT(right, 0.8 * guessed);
}

TEST(Silhouettes, StayWhereNobodyCanSay) {
    std::vector<DepthImage> images{widened(truth()[0], 3)};
    const DepthImage before = images[0];
    ImageStore store(std::move(images));
    SilhouetteFigures figures;
    const DepthImage after = settleSilhouettes(store, 0, {}, {}, figures);
    EXPECT_EQ(after.flags, before.flags);
    EXPECT_TRUE(std::ranges::equal(after.disparity.pixels(), before.disparity.pixels()));
    EXPECT_FALSE(figures.areChanged());
    EXPECT_TRUE(judgeSilhouettes(store, {{}}, {}).areRight({}));
}

TEST(Silhouettes, AreTheSameOnAnyNumberOfThreads) {
    const std::vector<DepthImage> images = unevenlyWidened();
    const std::vector<DepthImage>& many = settledOnce();
    const SilhouetteVerdict byMany = judged(images);
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    const std::vector<DepthImage> alone = settled(images);
    for (std::size_t i = 0; i < images.size(); ++i) {
        EXPECT_TRUE(std::ranges::equal(many[i].disparity.pixels(), alone[i].disparity.pixels())) << "image " << i;
        EXPECT_EQ(many[i].flags, alone[i].flags) << "image " << i;
    }
    const SilhouetteVerdict byOne = judged(images);
    EXPECT_EQ(byMany.forOwn, byOne.forOwn);
    EXPECT_EQ(byMany.forOther, byOne.forOther);
    EXPECT_EQ(byMany.seenThrough, byOne.seenThrough);
}

} // namespace
} // namespace scene
