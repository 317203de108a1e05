#include "scene/blend.h"

#include "tests/scene/known_scenes.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace scene {
namespace {

const Camera kSource{400, 300, 300, 300, 200, 150};

/// A tile of one sample in the middle of the source's image, at a disparity.
struct Middle {
    SampleBox box;
    TileMiddle middle;
};

Middle middleAt(double disparity, const glm::dvec2& pixel = {200, 150}) {
    const glm::dvec3 place(pixel, disparity);
    return {{place, place}, {Tier::base, rayThrough(kSource, pixel.x, pixel.y), disparity}};
}

std::optional<BlendSpot> spotFor(const View& eye, const Middle& m, const BlendOptions& options = {}) {
    return blendSpotOf(eyeImageFromSourceImage(eye, kSource, Pose{}), m.box, m.middle, eye.worldFromEye.translation,
                       options);
}

View eyeBeside(double metres) {
    View eye{kSource, {}};
    eye.worldFromEye.translation.x = metres;
    return eye;
}

/// How far beside the camera an eye stands for which that is this share of its distance to what is 2 m before the
/// camera.
double besideFor(double share) {
    return 2 * share / std::sqrt(1 - share * share);
}

TEST(BlendSpot, ImagesCountTheLessTheFartherTheyWereTakenFromTheEye) {
    const Middle at2m = middleAt(0.5);
    const BlendOptions options{.baseline = 0.5f, .quarterBaseline = 0.02f};
    const auto here = spotFor(eyeBeside(0), at2m, options);
    ASSERT_TRUE(here);
    float before = here->weight;
    for (const double share : {0.005, 0.01, 0.02, 0.05, 0.2, 0.45, 0.499}) {
        const auto spot = spotFor(eyeBeside(besideFor(share)), at2m, options);
        ASSERT_TRUE(spot) << share;
        EXPECT_LT(spot->weight, before) << share;
        EXPECT_GT(spot->weight, 0) << share;
        before = spot->weight;
    }
    EXPECT_LT(before, 1e-6f) << "nothing pops where an image comes in";
    EXPECT_FALSE(spotFor(eyeBeside(besideFor(0.501)), at2m, options));
    const auto quarter = spotFor(eyeBeside(besideFor(0.02)), at2m, options);
    EXPECT_NEAR(quarter->weight / here->weight, 0.25, 0.002);
}

TEST(BlendSpot, DepthIsAskedTheLessTheNearerTheImageWasTaken) {
    const Middle at2m = middleAt(0.5);
    const BlendOptions options{.baseline = 1.5f, .parallax = 0.01f, .depthTolerance = 0.05f};
    EXPECT_EQ(spotFor(eyeBeside(0), at2m, options)->tolerance, 1);
    EXPECT_NEAR(spotFor(eyeBeside(besideFor(0.05)), at2m, options)->tolerance, 0.2, 1e-4);
    EXPECT_EQ(spotFor(eyeBeside(besideFor(0.4)), at2m, options)->tolerance, 0.05f);
}

TEST(BlendSpot, TheSkyIsNearForEveryImage) {
    const auto spot = spotFor(eyeBeside(100), middleAt(0));
    ASSERT_TRUE(spot);
    EXPECT_EQ(spot->weight, spotFor(eyeBeside(0), middleAt(0))->weight);
}

TEST(BlendSpot, WhatIsBehindTheEyeOrTooLargeIsLeftOut) {
    const Middle at2m = middleAt(0.5);
    View eye = eyeBeside(0);
    eye.worldFromEye.translation.z = 2.5;
    EXPECT_FALSE(spotFor(eye, at2m, {.baseline = 100}));
    eye.worldFromEye.translation.z = 1.9;
    EXPECT_FALSE(spotFor(eye, at2m, {.baseline = 100, .maxRadius = 10})) << "20 times as large";
    EXPECT_TRUE(spotFor(eye, at2m, {.baseline = 100, .maxRadius = 20}));
}

/// What all samples of a plane together count at a pixel is the same from everywhere, while neighbours overlap.
TEST(BlendSpot, AnImageCountsAlikeHoweverDenselyItSamples) {
    const BlendOptions options{.baseline = 100, .quarterBaseline = 100, .samplesRadius = 1.5f};
    for (const double nearer : {-30.0, -2.0, 0.0, 1.0})
        for (const double turn : {0.0, 0.5}) {
            View eye = eyeBeside(0);
            eye.worldFromEye.translation.z = nearer;
            eye.worldFromEye.rotation =
                glm::dmat3(std::cos(turn), std::sin(turn), 0, -std::sin(turn), std::cos(turn), 0, 0, 0, 1);
            const auto spot = spotFor(eye, middleAt(0.5), options);
            ASSERT_TRUE(spot);
            const double seenSize = 2 / (2 - nearer); // of a source pixel, in eye pixels
            double sum = 0;
            for (int y = -150; y < 150; ++y)
                for (int x = -200; x < 200; ++x) {
                    const double dx = (x + 0.3) * seenSize, dy = (y + 0.6) * seenSize;
                    const double rest =
                        1 - (static_cast<double>(spot->xx) * dx * dx + static_cast<double>(spot->xy) * dx * dy +
                             static_cast<double>(spot->yy) * dy * dy);
                    if (rest > 0) sum += static_cast<double>(spot->weight) * rest * rest;
                }
            // The falloff (1 - q)^2 over the ellipse q < 1 has a third of the ellipse's area.
            const double expected =
                std::numbers::pi / 3 * static_cast<double>(options.samplesRadius * options.samplesRadius);
            EXPECT_NEAR(sum / expected, 1, 0.12) << nearer << " nearer, turned by " << turn;
        }
}

TEST(BlendUnit, ManyImagesFitIntoTheSums) {
    for (const std::size_t images : {1u, 50u, 200u, 5000u, 10'000'000u}) {
        const double unit = static_cast<double>(blendUnitOf(images));
        EXPECT_GE(unit, 1);
        if (unit > 1) {
            EXPECT_LE(unit * 255 * 8 * static_cast<double>(images), 4294967296.0) << images;
        }
    }
    EXPECT_GT(blendUnitOf(200), 8000.f);
}

struct Cut {
    std::vector<DepthImage> images;
    std::vector<TileSet> sets;
    std::vector<TileBlock> blocks;
};
Cut cut(std::vector<DepthImage> images) {
    Cut made{std::move(images), {}, {}};
    for (const DepthImage& image : made.images)
        made.sets.push_back(cutIntoTiles(image));
    for (std::size_t i = 0; i < made.images.size(); ++i)
        made.blocks.push_back(lend(made.sets[i], made.images[i].camera, made.images[i].worldFromCamera));
    return made;
}

TEST(WarpBlend, TheSameSumsOnAnyNumberOfThreads) {
    const Cut room = cut(imagesOfBareRoom(6));
    const View eye = viewsOfBareRoom(7)[1];
    ZBuffer zBuffer(eye.camera.width, eye.camera.height, 0);
    warpMesh(room.blocks, eye, {}, zBuffer);
    const Image<BlendSums> sums = warpBlend(room.blocks, eye, {}, zBuffer);
    for (const std::size_t threads : {1u, 2u, 7u}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        EXPECT_EQ(warpBlend(room.blocks, eye, {}, zBuffer), sums) << threads;
    }
}

TEST(WarpBlend, WithoutSamplesThereIsNothing) {
    const View eye = viewsOfBareRoom(1)[0];
    ZBuffer zBuffer(eye.camera.width, eye.camera.height, 0);
    const Image<BlendSums> sums = warpBlend({}, eye, {}, zBuffer);
    for (const BlendSums& sum : sums.pixels())
        ASSERT_EQ(sum, BlendSums{});
}

} // namespace
} // namespace scene
