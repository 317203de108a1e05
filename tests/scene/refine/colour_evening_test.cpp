// Exposures that drift and colours that do not match, against images whose true colours are known.

#include "scene/refine/colour_evening.h"
#include "scene/srgb.h"
#include "scene/synthetic_random.h"

#include "tests/scene/known_scenes.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace scene {
namespace {

constexpr int kImages = 10;

std::vector<std::vector<Partner>> partnersOf(const std::vector<DepthImage>& images) {
    std::vector<ImageOutline> outlines;
    for (const DepthImage& image : images)
        outlines.push_back(outlineOf(image));
    return findPartners(outlines);
}

ColourEvening evened(const std::vector<DepthImage>& images, const ColourEveningOptions& options = {}) {
    const auto partners = partnersOf(images);
    ImageStore store(images);
    return evenColours(store, partners, options);
}

/// As evened, but as the images then are.
std::vector<DepthImage> changed(std::vector<DepthImage> images, const ColourEvening& evening) {
    for (std::size_t i = 0; i < images.size(); ++i)
        applyFactors(images[i].colour, evening.factors[i]);
    return images;
}

void addNoise(Image<Rgb8>& colour, double sigma, unsigned seed) {
    SeededSequence random(seed);
    for (Rgb8& c : colour.pixels())
        for (std::uint8_t* channel : {&c.r, &c.g, &c.b})
            *channel = static_cast<std::uint8_t>(std::clamp(std::lround(*channel + sigma * random.normal()), 0l, 255l));
}

/// Exposures up to half a stop up and down, and a balance that drifts by a tenth.
std::vector<DepthImage> drifted(std::vector<DepthImage> images, unsigned seed) {
    SeededSequence random(seed);
    const auto balance = [&] { return 1 + random.between(-0.1, 0.1); };
    for (DepthImage& image : images) {
        const double exposure = std::exp2(random.between(-0.5, 0.5));
        applyFactors(image.colour, exposure * glm::dvec3{balance(), balance(), balance()});
    }
    return images;
}

double meanOf(const Image<Rgb8>& colour) {
    double sum = 0;
    for (const Rgb8& c : colour.pixels())
        sum += c.r + c.g + c.b;
    return sum / (3 * static_cast<double>(colour.size()));
}

TEST(ColourEvening, SeamsOfDriftingExposuresFallToAFifth) {
    const std::vector<DepthImage> truth = imagesOfBareRoom(kImages);
    for (unsigned seed = 1; seed <= 5; ++seed) {
        std::vector<DepthImage> taken = drifted(truth, seed);
        for (std::size_t i = 0; i < taken.size(); ++i)
            addNoise(taken[i].colour, 3, 100 * seed + static_cast<unsigned>(i));
        const ColourEvening found = evened(taken);
        EXPECT_GT(found.pairs, kImages);
        EXPECT_EQ(found.changed, kImages);
        // Measured anew on the images as they then are, not foretold.
        const double before = found.seamBefore, after = evened(changed(taken, found)).seamBefore;
        EXPECT_GT(before, 0.15);
        EXPECT_LT(after, before / 5);
        EXPECT_NEAR(after, found.seamAfter, 0.01);
    }
}

TEST(ColourEvening, AnEvenCaptureStaysAsItIs) {
    std::vector<DepthImage> images = imagesOfBareRoom(kImages);
    const ColourEvening exact = evened(images);
    EXPECT_GT(exact.pairs, kImages);
    EXPECT_EQ(exact.changed, 0);
    for (std::size_t i = 0; i < images.size(); ++i)
        addNoise(images[i].colour, 8, static_cast<unsigned>(i));
    const ColourEvening noisy = evened(images);
    for (const glm::dvec3& factors : noisy.factors)
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(factors[c], 1, 0.01);
}

TEST(ColourEvening, OneImageThatIsTooDarkIsNotBrightenedIntoNoise) {
    std::vector<DepthImage> images = imagesOfBareRoom(kImages);
    applyFactors(images[4].colour, glm::dvec3(0.2));
    ColourEveningOptions options;
    options.mostStops = 0.5;
    const ColourEvening found = evened(images, options);
    EXPECT_EQ(found.limited, 1);
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(found.factors[4][c], std::sqrt(2.0), 1e-9);
}

TEST(ColourEvening, WhatOverlapsNothingAndWhatHasNoColourStays) {
    std::vector<DepthImage> images = drifted(imagesOfBareRoom(kImages), 3);
    images[2].worldFromCamera.translation.x += 1000;
    for (std::uint8_t& flags : images[5].flags.pixels())
        flags |= kNoColour;
    const ColourEvening found = evened(images);
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(found.factors[2][c], 1, 1e-9);
        EXPECT_NEAR(found.factors[5][c], 1, 1e-9);
    }
    EXPECT_GT(found.changed, 5);
}

TEST(ColourEvening, IsTheSameOnOneThreadAndNeitherBrightensNorDarkensTheWhole) {
    const std::vector<DepthImage> truth = imagesOfBareRoom(kImages), taken = drifted(truth, 8);
    const ColourEvening many = evened(taken);
    {
        const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
        EXPECT_EQ(evened(taken).factors, many.factors);
    }
    const std::vector<DepthImage> even = changed(taken, many);
    double before = 0, after = 0;
    for (int i = 0; i < kImages; ++i) {
        before += meanOf(taken[static_cast<std::size_t>(i)].colour) / kImages;
        after += meanOf(even[static_cast<std::size_t>(i)].colour) / kImages;
    }
    EXPECT_NEAR(after, before, 0.03 * before);
}

} // namespace
} // namespace scene
