// Where samples stand in their pixels, and pictures that are interpolated by it.
#include "render/shaders/shared/sample_place.h"

#include "render/shaders/shared/splat.h"
#include "scene/warp.h"
#include "tests/render/studio.h"

#include <array>
#include <cmath>
#include <random>

namespace render {
namespace {

TEST(SamplePlace, IsKeptToAnEighthOfAPixelAndTakesNothingFromDepth) {
    std::mt19937 random(21);
    std::uniform_real_distribution<float> inPixel(0, 1), beside(-1, 1), inSplat(-0.75f, 0.75f), exponent(-5, 5);
    const auto worst = [](uvec2 key, const PlaceSteps& steps, vec2 truth) {
        const vec2 place = placedSampleOf(key, steps).place;
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

PlacedSample sampleAt(vec2 place, float grey, uint pixelClass = kClassSeen, float nearness = 30) {
    return {pixelClass, nearness, place, vec3(grey, grey, grey)};
}

TEST(SamplePlace, WhatStandsHalfWayCountsHalf) {
    const PlacedSample none{};
    const auto grey = [](uint colour) { return colour & 255u; };
    EXPECT_EQ(grey(interpolatedColour(sampleAt({0, 0}, 77), sampleAt({0, 0}, 200), none, none, none)), 77u)
        << "what stands in the middle of the next pixel has no share";
    EXPECT_NEAR(grey(interpolatedColour(sampleAt({0.5f, 0}, 100), sampleAt({0.5f, 0}, 200), none, none, none)), 150, 1);
    EXPECT_NEAR(grey(interpolatedColour(sampleAt({0, -0.5f}, 100), none, none, none, sampleAt({0, -0.5f}, 200))), 150,
                1);
    EXPECT_NEAR(grey(interpolatedColour(sampleAt({0, 0.25f}, 100), none, none, sampleAt({0, 0.25f}, 180), none)), 120,
                1);
    EXPECT_EQ(grey(interpolatedColour(sampleAt({1, -1}, 91), none, none, none, none)), 91u)
        << "alone, from however far beside";
    EXPECT_EQ(
        grey(interpolatedColour(sampleAt({0.5f, 0}, 100), sampleAt({0.5f, 0}, 200, kClassFilled), none, none, none)),
        100u)
        << "what was measured is mixed with nothing else";
    const PlacedSample near = sampleAt({0.5f, 0}, 100), far = sampleAt({0.5f, 0}, 200, kClassSeen, 28);
    EXPECT_EQ(grey(interpolatedColour(near, far, none, none, none)), 100u) << "it may be seen through a crack";
    EXPECT_NEAR(grey(interpolatedColour(far, near, none, none, none)), 150, 1) << "a rim before it";
}

class Interpolation : public RenderTest {};

Quality interpolating(Warp warp, int footprint) {
    Quality quality = qualityOf(warp);
    quality.maxFootprint = footprint;
    quality.interpolatesSamples = true;
    return quality;
}

TEST_F(Interpolation, IsThatOfTheProcessor) {
    Studio studio(roomInAllTiers());
    for (const Quality& quality :
         {interpolating(Warp::points, 1), interpolating(Warp::points, 3), interpolating(Warp::splats, 1)})
        for (const double x : {-0.2, 0.1, 0.3}) {
            const scene::View eye{cameraOf(220, 160, 1.3), poseAt({x, 0.02, 0.15}, 0.3 * x, 0.1)};
            const EyeImage device = studio.draw(eye, quality);
            const auto processor = studio.drawByProcessor(eye, quality);
            ASSERT_TRUE(processor);
            EXPECT_LE(shareThatDiffers(device, *processor, 0), 0.001) << "eye at " << x;
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
    const auto greyAt = [](const glm::dvec2& p) { return 128 + 60 * std::sin(0.9 * p.x) + 50 * std::sin(0.7 * p.y); };
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
    for (const Warp warp : {Warp::points, Warp::splats}) {
        Quality asItIs = interpolating(warp, 4);
        asItIs.interpolatesSamples = false;
        const double before = errorOf(studio.draw(eye, asItIs)),
                     now = errorOf(studio.draw(eye, interpolating(warp, 4)));
        EXPECT_LE(now, 0.6 * before) << (warp == Warp::points ? "points" : "splats");
    }
}

} // namespace
} // namespace render
