// Where samples stand in their pixels, and pictures that are interpolated by it.
#include "render/shaders/shared/between_samples.h"
#include "render/shaders/shared/sample_place.h"

#include "render/shaders/shared/splat.h"
#include "scene/warp.h"
#include "tests/render/studio.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>

namespace render {
namespace {

TEST(SamplePlace, IsKeptToAnEighthOfAPixelAndTakesNothingFromDepth) {
    std::mt19937 random(21);
    std::uniform_real_distribution<float> inPixel(0, 1), beside(-1, 1), inSplat(-0.75f, 0.75f), exponent(-5, 5);
    const auto worst = [](uvec2 key, const PlaceSteps& steps, vec2 truth) {
        const vec2 place = vec2(placeOf(key, steps)) / static_cast<float>(kEighths);
        return std::max(std::abs(place.x - truth.x), std::abs(place.y - truth.y));
    };
    for (int i = 0; i < 20000; ++i) {
        const float order = std::pow(10.f, exponent(random)), disparity = order * scene::orderScale(5);
        const uvec2 middle = packKey(order, 0x123456u, 5u << 2 | kClassSeen);
        const vec2 at(300 + std::floor(inPixel(random) * 9) + inPixel(random), 200 + inPixel(random));
        const ivec2 own(floor(at));
        const uvec2 key = keyOfPoint(order, 0x123456u, 5u << 2 | kClassSeen, own, at);
        ASSERT_LE(worst(key, placeStepsOfPoints(), -offsetOfPixel(own, at)), 0.1251f);
        ASSERT_EQ(eyeDisparityOf(key), eyeDisparityOf(middle));
        ASSERT_NEAR(eyeDisparityOf(key) / disparity, 1, 4e-6f);
        ASSERT_EQ(colourAndClassOf(key), 0x01123456u);

        const vec2 away(beside(random), beside(random)), far = vec2(own) + 0.5f + away;
        const uvec2 rim = keyOfPoint(order, 0x123456u, 5u << 2 | kClassSeen, own, far);
        if (ivec2(floor(far)) != own) {
            ASSERT_LE(worst(rim, placeStepsOfPoints(), away), 0.2501f);
            ASSERT_NEAR(eyeDisparityOf(rim) / disparity, 1, 4e-6f);
            ASSERT_LT(rim.y, middle.y) << "rims give way";
        }
        const vec2 centre(inSplat(random), inSplat(random));
        const uvec2 splat = keyOfSplat(order, -centre, 0x123456u, 5u << 2 | kClassSeen);
        ASSERT_LE(worst(splat, placeStepsOfSplats(), centre), 0.1876f);
    }
}

TEST(SamplePlace, NothingIsBesideTheMiddleOfWhatIsInfinitelyFar) {
    const uvec2 sky = packKey(0, 0x123456u, kClassSeen);
    EXPECT_EQ(keyOfPoint(0, 0x123456u, kClassSeen, {3, 4}, {3.9f, 4.1f}), sky);
    EXPECT_EQ(keyOfPoint(0, 0x123456u, kClassSeen, {3, 4}, {2.9f, 4.1f}), sky) << "at its rim";
    EXPECT_TRUE(std::isinf(depthOf(keyOfSplat(0, {0.3f, 0.3f}, 0x123456u, kClassSeen))));
}

/// A key whose sample stands so far from its pixel's centre.
uvec2 grey(uint value, vec2 place, uint pixelClass = kClassSeen, float order = 0.5f) {
    return keyOfPoint(order, value * 0x010101u, pixelClass, {300, 200}, vec2(300.5f, 200.5f) + place);
}

uint interpolatedGrey(uvec2 own, uvec2 beside, uvec2 over, uvec2 across) {
    const PlaceSteps steps = placeStepsOfPoints();
    const uint colour = interpolatedColour(own, beside, over, across, wayAcross(placeOf(own, steps)), steps);
    EXPECT_EQ(colour >> 24, own.x & 3u);
    return colour & 255u;
}

TEST(SamplePlace, WhatStandsHalfWayCountsHalf) {
    const uvec2 none(0u, 0u);
    const vec2 middle(0, 0), left(-0.5f, 0), aboveLeft(-0.5f, -0.5f);
    EXPECT_EQ(interpolatedGrey(grey(77, middle), grey(200, middle), grey(210, middle), grey(220, middle)), 77u)
        << "what stands in the middle of its pixel is all of it";
    EXPECT_NEAR(interpolatedGrey(grey(100, left), grey(200, left), none, none), 150, 2);
    EXPECT_NEAR(interpolatedGrey(grey(100, vec2(0, 0.25f)), none, grey(180, vec2(0, 0.25f)), none), 120, 2);
    EXPECT_NEAR(
        interpolatedGrey(grey(100, aboveLeft), grey(140, aboveLeft), grey(180, aboveLeft), grey(220, aboveLeft)), 160,
        3);
    EXPECT_EQ(interpolatedGrey(grey(91, vec2(0.9f, -0.9f)), none, none, none), 91u) << "alone, from however far beside";
    EXPECT_EQ(interpolatedGrey(grey(100, left), grey(200, left, kClassFilled), none, none), 100u)
        << "what was measured is mixed with nothing else";
    const uvec2 near = grey(100, left), far = grey(200, left, kClassSeen, 0.47f);
    EXPECT_EQ(interpolatedGrey(near, far, none, none), 100u) << "it may be seen through a crack";
    EXPECT_NEAR(interpolatedGrey(far, near, none, none), 150, 2) << "a rim before it";
}

/// What four samples make of what changes evenly over the picture, by so much per step along x and y; 0 is right.
double errorOf(const FourSamples& at, const glm::dvec2& perStep) {
    const FourShares shares = sharesOf(at);
    double sum = 0, value = 0;
    for (const auto& [share, place] : {std::pair{shares.own, at.own},
                                       {shares.beside, at.beside},
                                       {shares.over, at.over},
                                       {shares.across, at.across}}) {
        sum += share, value += share * glm::dot(perStep, glm::dvec2(place));
    }
    EXPECT_LT(sum, 1 << 22);
    EXPECT_GT(shares.own, 0u);
    return value / sum;
}

TEST(SamplePlace, BetweenLevelRowsWhatChangesEvenlyIsExact) {
    std::mt19937 random(5);
    std::uniform_int_distribution<int> in(0, 14), beyond(18, 46);
    for (int i = 0; i < 4000; ++i) {
        const ivec2 side(random() % 2 == 0 ? 1 : -1, random() % 2 == 0 ? 1 : -1);
        // On both sides of the wanted place along either row, however far, and above and below.
        const ivec2 own = side * ivec2(in(random), in(random));
        const int high = -side.y * beyond(random);
        const FourSamples at{own,
                             {-side.x * beyond(random), own.y},
                             {side.x * in(random), high},
                             {-side.x * beyond(random), high},
                             true,
                             true,
                             true};
        EXPECT_LE(std::abs(errorOf(at, {1, 0})), 1.0) << "a step of " << kPerPixel << " in a pixel";
        EXPECT_LE(std::abs(errorOf(at, {0, 1})), 1.0);
    }
}

// Samples anywhere in their pixels, as sheared and turned images have them: rows are not level, and a row's samples may
// be on one side. Nearest alone is what is drawn without interpolation.
TEST(SamplePlace, BetweenAnySamplesItIsFarNearerThanTheNearestAlone) {
    std::mt19937 random(6);
    std::uniform_int_distribution<int> in(-4, 4);
    double mixedSquares = 0, nearestSquares = 0;
    int worst = 0;
    for (int i = 0; i < 20000; ++i) {
        const auto place = [&] { return ivec2(in(random), in(random)); };
        const ivec2 own = sampleFrom(ivec2(0, 0), place()), way = wayAcross(own);
        const FourSamples at{own,
                             sampleFrom(kPerPixel * ivec2(way.x, 0), place()),
                             sampleFrom(kPerPixel * ivec2(0, way.y), place()),
                             sampleFrom(kPerPixel * way, place()),
                             true,
                             true,
                             true};
        const double error = errorOf(at, {1, 0}), nearest = own.x;
        mixedSquares += error * error, nearestSquares += nearest * nearest;
        worst = std::max(worst, static_cast<int>(std::abs(error)));
    }
    std::printf("off by %.2f steps instead of %.2f, at worst %d\n", std::sqrt(mixedSquares / 20000),
                std::sqrt(nearestSquares / 20000), worst);
    EXPECT_LE(mixedSquares, 0.25 * nearestSquares);
    EXPECT_LE(worst, kPerPixel / 2);
}

TEST(SamplePlace, ARimFromFarAsideDoesNotTakeThePixel) {
    const FourSamples at{{8, 0}, {0, -32}, {0, 0}, {0, 0}, true, false, false};
    EXPECT_LE(std::abs(errorOf(at, {0, 1})), 8) << "as far as the own one is aside";
}

TEST(SamplePlace, WhatIsNotTakenHasNoShareAndTheRestHasAll) {
    const FourSamples all{{4, 4}, {-28, 4}, {4, -28}, {-28, -28}, true, true, true};
    // What is not taken may stand anywhere.
    const ivec2 astray(40, 3);
    for (int without = 1; without < 8; ++without) {
        FourSamples at = all;
        at.takesBeside = (without & 1) == 0, at.takesOver = (without & 2) == 0, at.takesAcross = (without & 4) == 0;
        if (!at.takesBeside) at.beside = astray;
        if (!at.takesOver) at.over = astray;
        if (!at.takesAcross) at.across = astray;
        const FourShares shares = sharesOf(at);
        EXPECT_GT(shares.own, 0u);
        EXPECT_EQ(shares.beside > 0, at.takesBeside) << without;
        EXPECT_EQ(shares.over > 0, at.takesOver) << without;
        EXPECT_EQ(shares.across > 0, at.takesAcross) << without;
        // The other row counts as much, whoever is left of it: but for the step that both rows have more.
        const double sum = shares.own + shares.beside + shares.over + shares.across;
        EXPECT_NEAR((shares.over + shares.across) / sum, at.takesOver || at.takesAcross ? 4 / 33. : 0, 1e-3) << without;
    }
}

class Interpolation : public RenderTest {};

Quality interpolating(Warp warp, int footprint) {
    Quality quality = qualityOf(warp);
    quality.maxFootprint = footprint;
    quality.interpolatesSamples = true;
    return quality;
}

TEST_F(Interpolation, IsThatOfTheProcessorOfSmallerPicturesToo) {
    Studio studio(roomInAllTiers());
    for (Quality quality :
         {interpolating(Warp::points, 1), interpolating(Warp::points, 3), interpolating(Warp::splats, 1)})
        for (const double scale : {1.0, 0.93, 0.7, 0.5})
            for (const double x : {-0.2, 0.1, 0.3}) {
                SCOPED_TRACE("scale " + std::to_string(scale) + ", eye at " + std::to_string(x));
                quality.resolutionScale = scale;
                const scene::View eye{cameraOf(220, 160, 1.3), poseAt({x, 0.02, 0.15}, 0.3 * x, 0.1)};
                const EyeImage device = studio.draw(eye, quality);
                EXPECT_TRUE(isSane(device));
                const auto processor = studio.drawByProcessor(eye, quality);
                ASSERT_TRUE(processor);
                EXPECT_LE(shareThatDiffers(device, *processor, 0), 0.001);
                Quality asItIs = quality;
                asItIs.interpolatesSamples = false;
                const EyeImage other = studio.draw(eye, asItIs);
                EXPECT_EQ(other.pixelClass, device.pixelClass) << "classes stay";
                EXPECT_EQ(other.depthMetres, device.depthMetres) << "depths stay";
                EXPECT_NE(other.colour, device.colour);
            }
}

TEST_F(Interpolation, WhatTheHoleFillerLeavesKeepsItsColour) {
    Studio studio(roomInAllTiers());
    for (const Warp warp : {Warp::points, Warp::splats}) {
        Quality open = interpolating(warp, 1), filled = open;
        open.leavesOutHidden = filled.leavesOutHidden = false;
        filled.holes.radius = 4;
        const scene::View eye{cameraOf(220, 160, 1.3), poseAt({0.3, 0.02, 0.9}, 0.1, 0.1)};
        const EyeImage before = studio.draw(eye, open), after = studio.draw(eye, filled);
        const double changed = shareOf(before, [&](int x, int y) {
            return before.pixelClass(x, y) == after.pixelClass(x, y) &&
                   before.depthMetres(x, y) == after.depthMetres(x, y) && before.colour(x, y) != after.colour(x, y);
        });
        EXPECT_EQ(changed, 0.0);
        if (warp == Warp::points) {
            EXPECT_NE(before.depthMetres, after.depthMetres) << "something was filled";
        }
    }
}

TEST_F(Interpolation, AnImageComesBackAtItsOwnCamera) {
    const scene::DepthImage image = roomFromThreePlaces()[0];
    Studio studio(cut({image}));
    const scene::View eye{image.camera, image.worldFromCamera};
    for (const Warp warp : {Warp::points, Warp::splats}) {
        const EyeImage drawn = studio.draw(eye, interpolating(warp, 1));
        EXPECT_LE(shareOf(drawn,
                          [&](int x, int y) {
                              return drawn.pixelClass(x, y) == kClassSeen && drawn.colour(x, y) != image.colour(x, y);
                          }),
                  0.001);
    }
}

TEST_F(Interpolation, ASurfaceComesNearerToItsTruth) {
    const scene::Camera camera = cameraOf(240, 180, 0.8);
    const glm::dvec3 normal = glm::normalize(glm::dvec3(0.3, 0.1, 1));
    scene::DepthImage wall = takePlane(camera, normal, 2);
    const auto greyAt = [](const glm::dvec2& p) { return 128 + 60 * std::sin(0.45 * p.x) + 50 * std::sin(0.35 * p.y); };
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x) {
            const auto grey = static_cast<std::uint8_t>(std::lround(greyAt({x + 0.5, y + 0.5})));
            wall.colour(x, y) = {grey, grey, grey};
        }
    Studio studio(cut({wall}));
    const scene::View eye{cameraOf(200, 150, 0.65), poseAt({0.03, 0.02, -0.01}, 0.05, 0.02)};
    const auto errorOf = [&](const EyeImage& drawn) {
        double sum = 0, count = 0;
        for (int y = 0; y < drawn.colour.height(); ++y)
            for (int x = 0; x < drawn.colour.width(); ++x) {
                if (drawn.pixelClass(x, y) != kClassSeen) continue;
                const glm::dvec3 ray =
                    eye.worldFromEye.rotation *
                    glm::dvec3((x + 0.5 - eye.camera.cx) / eye.camera.fx, (y + 0.5 - eye.camera.cy) / eye.camera.fy, 1);
                const glm::dvec3 from = eye.worldFromEye.translation;
                const glm::dvec3 p = from + ray * ((2 - glm::dot(normal, from)) / glm::dot(normal, ray));
                const double truth = greyAt({camera.fx * p.x / p.z + camera.cx, camera.fy * p.y / p.z + camera.cy});
                sum += (drawn.colour(x, y).g - truth) * (drawn.colour(x, y).g - truth), ++count;
            }
        return std::sqrt(sum / count);
    };
    for (const Warp warp : {Warp::points, Warp::splats})
        for (const double scale : {1.0, 0.8, 0.6}) {
            Quality quality = interpolating(warp, 4), asItIs = quality;
            asItIs.interpolatesSamples = false;
            quality.resolutionScale = asItIs.resolutionScale = scale;
            const double before = errorOf(studio.draw(eye, asItIs)), now = errorOf(studio.draw(eye, quality));
            std::printf("%s, scale %.1f: %.2f greys off as they are, %.2f by places\n",
                        warp == Warp::points ? "points" : "splats", scale, before, now);
            // Where several samples fall into a pixel, the one shown is not the one that a smooth picture would ask
            // for.
            EXPECT_LE(now, (scale < 0.7 ? 0.85 : 0.6) * before)
                << (warp == Warp::points ? "points" : "splats") << ", scale " << scale;
        }
}

} // namespace
} // namespace render
