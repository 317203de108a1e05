#include "scene/refine/fusion.h"
#include "scene/synthetic_model.h"
#include "scene/synthetic_random.h"

#include "tests/scene/known_scenes.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace scene {
namespace {

constexpr double kSigma = 0.004; ///< relative noise of disparity
constexpr double kColourSigma = 6;

void addNoise(DepthImage& image, unsigned seed) {
    SeededSequence random(seed);
    for (int y = 0; y < image.camera.height; ++y)
        for (int x = 0; x < image.camera.width; ++x) {
            image.disparity(x, y) *= static_cast<float>(1 + kSigma * random.normal());
            Rgb8& c = image.colour(x, y);
            for (std::uint8_t* channel : {&c.r, &c.g, &c.b})
                *channel = static_cast<std::uint8_t>(
                    std::clamp(std::lround(*channel + kColourSigma * random.normal()), 0l, 255l));
        }
}

/// Images of the room from places a few decimetres apart.
std::vector<DepthImage> nearbyImages(int count) {
    std::vector<DepthImage> images;
    for (int i = 0; i < count; ++i)
        images.push_back(renderTruth(
            bareRoom(), viewFrom({1.0 + 0.05 * (i % 3), 1.2 + 0.05 * (i / 3), 1.5 + 0.02 * i}, {4, 3, 1.1})));
    return images;
}

std::vector<Partner> allBut(std::size_t count, std::size_t self) {
    std::vector<Partner> partners;
    for (std::uint32_t i = 0; i < count; ++i)
        if (i != self) partners.push_back({i, 1.f});
    return partners;
}

Image<Keep> keepAll() {
    return {160, 120, Keep::base};
}

bool hasSameBytes(const DepthImage& a, const DepthImage& b) {
    return a.colour == b.colour && a.flags == b.flags &&
           std::memcmp(a.disparity.pixels().data(), b.disparity.pixels().data(), a.disparity.size() * sizeof(float)) ==
               0;
}

/// Relative errors of disparity and errors of colour against the truth.
struct Errors {
    double bias = 0, deviation = 0, colourBias = 0, colourDeviation = 0;
};
Errors errorsOf(const DepthImage& image, const DepthImage& truth) {
    Errors e;
    double sum = 0, squares = 0, colourSum = 0, colourSquares = 0, count = 0;
    for (int y = 0; y < 120; ++y)
        for (int x = 0; x < 160; ++x, ++count) {
            const double error =
                static_cast<double>(image.disparity(x, y)) / static_cast<double>(truth.disparity(x, y)) - 1;
            const double colourError = image.colour(x, y).g - truth.colour(x, y).g;
            sum += error, squares += error * error, colourSum += colourError,
                colourSquares += colourError * colourError;
        }
    e.bias = sum / count, e.deviation = std::sqrt(squares / count);
    e.colourBias = colourSum / count, e.colourDeviation = std::sqrt(colourSquares / count);
    return e;
}

TEST(Fusion, LowersNoiseWithoutBias) {
    const std::vector<DepthImage> truth = nearbyImages(9);
    std::vector<DepthImage> noisy = truth;
    for (std::size_t i = 0; i < noisy.size(); ++i)
        addNoise(noisy[i], static_cast<unsigned>(i) + 1);
    const Errors before = errorsOf(noisy[4], truth[4]);
    ImageStore store(noisy);
    const Errors after = errorsOf(fuse(store, 4, allBut(9, 4), keepAll(), {}), truth[4]);
    EXPECT_NEAR(before.deviation, kSigma, 0.1 * kSigma);
    EXPECT_LT(after.deviation, 0.4 * before.deviation) << "nine images can give a third";
    EXPECT_LT(after.colourDeviation, 0.4 * before.colourDeviation);
    EXPECT_LT(std::abs(after.bias), 0.05 * kSigma);
    EXPECT_LT(std::abs(after.colourBias), 0.2);
}

TEST(Fusion, OfTrueImagesStaysTrueAndDoesNotSmearSilhouettes) {
    const std::vector<DepthImage> truth = nearbyImages(6);
    ImageStore store(truth);
    for (const std::size_t self : {std::size_t{0}, std::size_t{3}}) {
        const DepthImage fused = fuse(store, self, allBut(6, self), keepAll(), {});
        int off = 0;
        for (int y = 0; y < 120; ++y)
            for (int x = 0; x < 160; ++x) {
                const float d = truth[self].disparity(x, y);
                // The partners are bilinear between their samples; the sphere is curved.
                ASSERT_NEAR(fused.disparity(x, y), d, 0.01f * d) << "image " << self << " at " << x << ", " << y;
                off += std::abs(fused.disparity(x, y) - d) > 0.001f * d;
            }
        EXPECT_LT(off, 160 * 120 / 40) << "image " << self;
    }
}

/// A frame of 4 cm on a wall (y = 0), in the plane z = 1.3.
constexpr glm::dvec3 kFrameLow{1, 0, 1}, kFrameHigh{1.5, 0.04, 1.6};

SyntheticScene frameOnWall() {
    SyntheticModel model;
    const int grey = addMaterial(model, {Pattern::mottled, glm::dvec3(0.8), glm::dvec3(0.7), 0.7, 3});
    addRectangle(model, {-4, 0, 0}, {0, 0, 3}, {9, 0, 0}, grey);
    addBox(model, Pose{}, kFrameLow, kFrameHigh, grey);
    model.lamps.push_back({{0, 3, 2.9}, {0, 1, 0}, {1, 0, 0}, glm::dvec3(3.0)});
    return SyntheticScene(std::move(model));
}

/// Metres from wall and frame, whichever is nearer.
double offFrameAndWall(const glm::dvec3& p) {
    const glm::dvec3 beyond = glm::max(glm::max(kFrameLow - p, p - kFrameHigh), glm::dvec3(0.0));
    const glm::dvec3 within = glm::min(p - kFrameLow, kFrameHigh - p);
    const double frame = glm::length(beyond) > 0 ? glm::length(beyond) : std::min({within.x, within.y, within.z});
    return std::min(frame, std::abs(p.y));
}

TEST(Fusion, WhatIsSeenAcrossDoesNotMoveItAlong) {
    // One looks along the wall, the others from before it: rays of one run along what another sees well.
    const SyntheticScene scene = frameOnWall();
    const std::vector<DepthImage> images{renderTruth(scene, viewFrom({0.3, 0.3, 1.3}, {1.2, 0.05, 1.3})),
                                         renderTruth(scene, viewFrom({-0.8, 2.2, 1.4}, {1.2, 0, 1.3})),
                                         renderTruth(scene, viewFrom({2.4, 1.6, 1.5}, {1.2, 0, 1.3}))};
    ImageStore store(images);
    for (std::size_t i = 0; i < images.size(); ++i) {
        const DepthImage fused = fuse(store, i, allBut(images.size(), i), keepAll(), {});
        double worst = 0;
        int off = 0;
        for (int y = 0; y < 120; ++y)
            for (int x = 0; x < 160; ++x) {
                if (!isSurface(fused.flags(x, y))) continue;
                const double metres =
                    offFrameAndWall(pointInWorld(fused, x + 0.5, y + 0.5, static_cast<double>(fused.disparity(x, y))));
                worst = std::max(worst, metres);
                off += metres > 0.002;
            }
        EXPECT_LT(worst, 0.005) << "image " << i;
        EXPECT_LT(off, 5) << "image " << i;
    }
}

TEST(Fusion, OfASingleImageChangesNoBit) {
    std::vector<DepthImage> images = nearbyImages(1);
    addNoise(images[0], 1);
    images[0].flags(3, 3) = kNoSurface, images[0].disparity(3, 3) = 0;
    images[0].flags(5, 9) = kSkinUpper;
    const DepthImage original = images[0];
    ImageStore store(std::move(images));
    EXPECT_TRUE(hasSameBytes(fuse(store, 0, {}, keepAll(), {}), original));
}

TEST(Fusion, WhatIsClosedStaysSoUnlessAnotherImageMeasuredIt) {
    std::vector<DepthImage> images = nearbyImages(3);
    for (DepthImage& image : images)
        for (int y = 0; y < 120; ++y)
            for (int x = 0; x < 160; ++x)
                if (&image == &images[0] || y < 60) image.flags(x, y) = kInterpolated;
    const auto closedIn = [&](std::vector<DepthImage> all, int fromRow) {
        ImageStore store(std::move(all));
        const DepthImage fused = fuse(store, 0, allBut(3, 0), keepAll(), {});
        int closed = 0;
        for (int y = fromRow; y < fromRow + 40; ++y)
            for (int x = 0; x < 160; ++x)
                closed += isClosed(fused.flags(x, y));
        return closed;
    };
    EXPECT_EQ(closedIn(images, 0), 40 * 160) << "closed in all three";
    for (int x = 10; x < 20; ++x)
        images[0].flags(x, 20) = 0;
    EXPECT_EQ(closedIn(images, 0), 40 * 160 - 3 * 12) << "what stands beside samples is resampled";
    for (int x = 10; x < 20; ++x)
        images[0].disparity(x, 20) *= 1.5f;
    EXPECT_EQ(closedIn(images, 0), 40 * 160 - 10) << "but not beside those of another surface";
    for (int x = 10; x < 20; ++x)
        images[0].flags(x, 20) = kInterpolated, images[0].disparity(x, 20) /= 1.5f;
    EXPECT_LT(closedIn(images, 80), 40 * 160 / 10) << "measured in two; along rims nothing is smooth";
}

TEST(Fusion, SaysWhatIsKeptAndTouchesOnlyWhatDrawingNeeds) {
    std::vector<DepthImage> images = nearbyImages(3);
    for (std::size_t i = 0; i < images.size(); ++i)
        addNoise(images[i], static_cast<unsigned>(i) + 1);
    for (int x = 0; x < 160; ++x)
        images[0].flags(x, 7) = kSkinLower;
    const DepthImage original = images[0];
    Image<Keep> kept(160, 120, Keep::no);
    for (int y = 40; y < 60; ++y)
        for (int x = 50; x < 90; ++x)
            kept(x, y) = x < 70 ? Keep::base : Keep::directional;
    ImageStore store(std::move(images));
    const DepthImage fused = fuse(store, 0, allBut(3, 0), kept, {});
    int changed = 0;
    for (int y = 0; y < 120; ++y)
        for (int x = 0; x < 160; ++x) {
            const int mark = kept(x, y) == Keep::base ? 0 : kept(x, y) == Keep::directional ? kDirectional : kRedundant;
            ASSERT_EQ(fused.flags(x, y), original.flags(x, y) | mark) << "at " << x << ", " << y;
            const bool isNeeded = x >= 49 && x <= 90 && y >= 39 && y <= 60;
            const bool isChanged = fused.disparity(x, y) != original.disparity(x, y);
            ASSERT_TRUE(isNeeded || !isChanged) << "at " << x << ", " << y;
            ASSERT_TRUE(isNeeded || fused.colour(x, y) == original.colour(x, y)) << "at " << x << ", " << y;
            changed += isChanged;
        }
    EXPECT_GT(changed, 600);
    EXPECT_EQ(fused.name, original.name);
    EXPECT_EQ(fused.camera, original.camera);
}

TEST(Fusion, TakesNoColourOfWhatLooksDifferent) {
    const Camera camera = smallCamera();
    std::vector<DepthImage> images;
    for (int i = 0; i < 5; ++i)
        images.push_back(imageOf(
            camera, {glm::dmat3(1.0), {0.05 * i, 0, 0}}, [](double, double) { return 0.5; },
            i == 0 ? Rgb8{100, 100, 100} : Rgb8{250, 100, 100}));
    ImageStore store(std::move(images));
    const DepthImage fused = fuse(store, 0, allBut(5, 0), keepAll(), {});
    EXPECT_TRUE((fused.colour(90, 60) == Rgb8{100, 100, 100})) << "a gleam that others see stays theirs";
}

TEST(Fusion, SamplesWithoutColourTakeThatOfWhoeverHasAny) {
    std::vector<DepthImage> images;
    for (int i = 0; i < 4; ++i) {
        images.push_back(imageOf(
            smallCamera(), {glm::dmat3(1.0), {0.05 * i, 0, 0}}, [](double, double) { return 0.5; },
            i < 2 ? Rgb8{40, 40, 40} : Rgb8{200, 120, 60}));
        if (i < 2)
            for (std::uint8_t& flags : images.back().flags.pixels())
                flags |= kNoColour;
    }
    ImageStore store(images);
    const DepthImage grey = fuse(store, 0, allBut(4, 0), keepAll(), {}),
                     coloured = fuse(store, 2, allBut(4, 2), keepAll(), {});
    EXPECT_TRUE((grey.colour(90, 60) == Rgb8{200, 120, 60}));
    EXPECT_EQ(grey.flags(90, 60) & kNoColour, 0);
    EXPECT_TRUE((coloured.colour(90, 60) == Rgb8{200, 120, 60})) << "intensity is no colour";
    // Where nobody has any, it stays what it is.
    ImageStore greys({images[0], images[1]});
    const DepthImage none = fuse(greys, 0, allBut(2, 0), keepAll(), {});
    EXPECT_TRUE((none.colour(90, 60) == Rgb8{40, 40, 40}));
    EXPECT_NE(none.flags(90, 60) & kNoColour, 0);
}

TEST(Fusion, ColoursAreNotMixedWithTheGreyBesideThem) {
    std::vector<DepthImage> images;
    for (int i = 0; i < 2; ++i) // the other's pixels lie halfway between those of the first
        images.push_back(imageOf(
            smallCamera(), {glm::dmat3(1.0), {i / smallCamera().fx, 0, 0}}, [](double, double) { return 0.5; },
            Rgb8{200, 120, 60}));
    for (int y = 0; y < images[1].camera.height; ++y)
        for (int x = 0; x < 80; ++x)
            images[1].colour(x, y) = {40, 40, 40}, images[1].flags(x, y) |= kNoColour;
    ImageStore store(images);
    const DepthImage fused = fuse(store, 0, allBut(2, 0), keepAll(), {});
    for (int x = 60; x < 100; ++x)
        EXPECT_TRUE((fused.colour(x, 60) == Rgb8{200, 120, 60})) << x;
}

TEST(Fusion, KeepsTheSkyAtInfinity) {
    std::vector<DepthImage> images;
    for (int i = 0; i < 2; ++i)
        images.push_back(imageOf(
            smallCamera(), {glm::dmat3(1.0), {100.0 * i, 0, 0}}, [](double, double) { return 0.0; },
            i == 0 ? Rgb8{100, 120, 200} : Rgb8{110, 120, 200}));
    ImageStore store(std::move(images));
    const DepthImage fused = fuse(store, 0, allBut(2, 0), keepAll(), {});
    for (int y = 0; y < 120; ++y)
        for (int x = 0; x < 160; ++x) {
            ASSERT_EQ(fused.disparity(x, y), 0.f) << "at " << x << ", " << y;
            ASSERT_TRUE((fused.colour(x, y).r >= 104 && fused.colour(x, y).r <= 105 && fused.colour(x, y).b == 200))
                << "at " << x << ", " << y;
        }
}

TEST(Fusion, GivesTheSameBytesOnOneThreadAndOnTwo) {
    std::vector<DepthImage> images = nearbyImages(4);
    for (std::size_t i = 0; i < images.size(); ++i)
        addNoise(images[i], static_cast<unsigned>(i) + 1);
    ImageStore store(std::move(images));
    const auto fusedBy = [&](std::size_t threads) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        return fuse(store, 1, allBut(4, 1), keepAll(), {});
    };
    EXPECT_TRUE(hasSameBytes(fusedBy(1), fusedBy(2)));
}

} // namespace
} // namespace scene
