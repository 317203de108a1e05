#include "render/shaders/shared/hole_fill.h"

#include "scene/warp.h"
#include "tests/render/test_device.h"
#include "tests/render/test_scenes.h"

#include <array>
#include <cmath>
#include <random>

namespace render {
namespace {

HoleFill fillWithin(int radius) {
    return {.radius = radius, .sameSurface = 0.03f, .sameColour = 64, .pinholeDepth = 0.05f};
}

constexpr uint kGrey = 0x808080;

/// A z-buffer drawn by hand.
struct Picture {
    scene::Image<uvec2> keys;
    Picture(int width, int height) : keys(width, height, uvec2(0)) {}
    uvec2 operator()(ivec2 p) const {
        return p.x >= 0 && p.y >= 0 && p.x < keys.width() && p.y < keys.height() ? keys(p.x, p.y) : uvec2(0);
    }
    void put(int x, int y, float disparity, uint colour = kGrey) {
        keys(x, y) = packKey(disparity, colour, kClassSeen);
    }
    uvec2 fill(int x, int y, const HoleFill& holes) const {
        const ivec2 pixel{x, y};
        const uvec2 own = keys(x, y);
        const bool asks =
            isHole(own) || isPinhole(own, (*this)(pixel - ivec2(1, 0)), (*this)(pixel - ivec2(0, 1)), holes);
        const uvec2 key = asks ? filled(*this, pixel, own, holes) : own;
        return key == own ? filledAtRim(*this, pixel, ivec2(keys.width(), keys.height()), own) : key;
    }
};

/// As scene::resolve would have it after filling.
scene::ZBuffer filledOnProcessor(const scene::ZBuffer& zBuffer, const HoleFill& holes) {
    Picture picture(zBuffer.width(), zBuffer.height());
    for (int y = 0; y < zBuffer.height(); ++y)
        for (int x = 0; x < zBuffer.width(); ++x)
            picture.keys(x, y) = {static_cast<uint>(zBuffer(x, y)), static_cast<uint>(zBuffer(x, y) >> 32)};
    scene::ZBuffer result(zBuffer.width(), zBuffer.height());
    for (int y = 0; y < zBuffer.height(); ++y)
        for (int x = 0; x < zBuffer.width(); ++x) {
            const uvec2 key = picture.fill(x, y, holes);
            result(x, y) = std::uint64_t{key.y} << 32 | key.x;
        }
    return result;
}

TEST(HoleFill, AtTheRimWhatStandsRightBesideIsShown) {
    Picture picture(8, 6);
    for (int y = 1; y < 5; ++y)
        for (int x = 1; x < 7; ++x)
            picture.put(x, y, 0.1f * static_cast<float>(x + 1), static_cast<uint>(y));
    picture.put(3, 0, 0.9f);
    picture.keys(5, 4) = uvec2(0); // a hole of two pixels: of what lies in it nothing is known
    const HoleFill none = fillWithin(1);
    const auto expectAs = [&](int x, int y, int fromX, int fromY) {
        const uvec2 key = picture.fill(x, y, none);
        EXPECT_EQ(key.x & 3u, kClassFilled) << x << ", " << y;
        EXPECT_EQ(key.x >> 8, static_cast<uint>(fromY)) << x << ", " << y;
        EXPECT_FLOAT_EQ(eyeDisparityOf(key), eyeDisparityOf(picture.keys(fromX, fromY))) << x << ", " << y;
    };
    expectAs(1, 0, 1, 1);
    expectAs(0, 3, 1, 3);
    expectAs(7, 2, 6, 2);
    expectAs(0, 5, 1, 4);
    EXPECT_EQ(picture.fill(3, 0, none), picture.keys(3, 0)) << "no hole";
    EXPECT_TRUE(isHole(picture.fill(5, 5, none)));
    for (const ivec2 size : {ivec2(1, 1), ivec2(1, 5), ivec2(2, 2)}) {
        Picture tiny(size.x, size.y);
        EXPECT_TRUE(isHole(tiny.fill(0, 0, none)));
    }
}

TEST(HoleFill, TheMaskIsThePapers) {
    std::mt19937 random(3);
    std::uniform_int_distribution<int> shade(0, 255), among(0, 3);
    int filledCount = 0;
    for (int i = 0; i < 20000; ++i) {
        Picture picture(3, 3);
        std::array<float, 9> disparity{}; // of 1 to 8, as the paper counts, with the hole at 4
        std::array<int, 9> grey{};
        for (int n = 0; n < 9; ++n) {
            if (n == 4 || among(random) == 0) continue;
            const auto k = static_cast<std::size_t>(n);
            disparity[k] = among(random) < 2 ? 0.5f : 0.8f, grey[k] = shade(random);
            picture.put(n % 3, n / 3, disparity[k], static_cast<uint>(grey[k]) * 0x10101u);
        }
        bool isFilled = false;
        for (std::size_t n = 0; n < 4; ++n)
            isFilled |= disparity[n] > 0 && disparity[8 - n] > 0 && std::abs(disparity[n] - disparity[8 - n]) < 0.01f &&
                        std::abs(grey[n] - grey[8 - n]) <= 64;
        const uvec2 key = picture.fill(1, 1, fillWithin(1));
        ASSERT_EQ(!isHole(key), isFilled) << i;
        filledCount += isFilled;
        EXPECT_EQ(key.x & 3u, isFilled ? kClassFilled : kClassBackground);
    }
    EXPECT_GT(filledCount, 2000);
    EXPECT_LT(filledCount, 18000);
}

/// On a tilted floor with the horizon in the picture, everything that is missing within reach comes back where it was.
TEST(HoleFill, WhatIsMissingOfAPlaneComesBack) {
    const auto planeAt = [](int x, int y) {
        return 0.002f * static_cast<float>(x) + 0.01f * static_cast<float>(y) + 0.05f;
    };
    std::mt19937 random(5);
    for (const int radius : {1, 2, 4, 8, 16}) {
        Picture picture(120, 90);
        for (int y = 0; y < 90; ++y)
            for (int x = 0; x < 120; ++x)
                picture.put(x, y, planeAt(x, y));
        const int width = radius == 1 ? 1 : radius; // of each missing square; its middle is within reach
        for (int y = 20; y + width < 70; y += 2 * width + 8)
            for (int x = 20; x + width < 100; x += 2 * width + 8)
                for (int i = 0; i < width * width; ++i)
                    picture.keys(x + i % width, y + i / width) = uvec2(0);
        int missing = 0;
        for (int y = 0; y < 90; ++y)
            for (int x = 0; x < 120; ++x) {
                const uvec2 key = picture.fill(x, y, fillWithin(radius));
                if (!isHole(picture.keys(x, y))) {
                    ASSERT_EQ(key, picture.keys(x, y)) << "what is there stays as it is";
                    continue;
                }
                ++missing;
                ASSERT_FALSE(isHole(key)) << radius << ": " << x << " " << y;
                EXPECT_NEAR(eyeDisparityOf(key), planeAt(x, y), 1e-5);
                EXPECT_EQ(key.x >> 8, kGrey);
            }
        EXPECT_GT(missing, 3);
    }
}

TEST(HoleFill, NothingIsBuiltBetweenForegroundAndBackground) {
    for (const int gap : {1, 2, 5}) {
        Picture picture(60, 40);
        for (int y = 0; y < 40; ++y)
            for (int x = 0; x < 60; ++x) {
                if (x < 30) picture.put(x, y, 1.0f);
                if (x >= 30 + gap) picture.put(x, y, 0.4f);
            }
        for (const int radius : {1, 4, 16})
            for (int y = 17; y < 23; ++y)
                for (int x = 30; x < 30 + gap; ++x)
                    EXPECT_TRUE(isHole(picture.fill(x, y, fillWithin(radius)))) << gap << " " << radius << " " << x;
    }
}

TEST(HoleFill, OtherColoursAreAnotherSurface) {
    Picture picture(3, 1);
    picture.put(0, 0, 0.5f, 0x101010), picture.put(2, 0, 0.5f, 0xf0f0f0);
    EXPECT_TRUE(isHole(picture.fill(1, 0, fillWithin(4))));
    picture.put(2, 0, 0.5f, 0x303030);
    EXPECT_EQ(picture.fill(1, 0, fillWithin(4)).x >> 8, 0x202020u);
}

TEST(HoleFill, HolesInTheSkyAreSkyAndNothingIsNaN) {
    Picture picture(9, 9);
    for (int y = 0; y < 9; ++y)
        for (int x = 0; x < 9; ++x)
            picture.put(x, y, 0);
    picture.keys(4, 4) = picture.keys(0, 0) = uvec2(0);
    for (const int radius : {1, 16})
        EXPECT_TRUE(std::isinf(depthOf(picture.fill(4, 4, fillWithin(radius)))));
    EXPECT_TRUE(std::isinf(depthOf(picture.fill(0, 0, fillWithin(16))))) << "in a corner, as beside it";
    std::mt19937 random(7);
    std::uniform_real_distribution<float> exponent(-30, 5);
    for (int i = 0; i < 5000; ++i) {
        for (uvec2& key : picture.keys.pixels())
            key = random() % 3 == 0 ? uvec2(0)
                                    : packKey(random() % 5 == 0 ? 0 : std::pow(10.f, exponent(random)),
                                              static_cast<uint>(random()) & 0xffffffu,
                                              (static_cast<uint>(random()) & 63u) << 2 | kClassSeen);
        HoleFill all = fillWithin(1 + i % 16);
        all.sameColour = 255, all.sameSurface = 2;
        const uvec2 key = picture.fill(4, 4, all);
        ASSERT_FALSE(std::isnan(depthOf(key)));
        ASSERT_GE(depthOf(key), 0);
    }
}

TEST(HoleFill, ACrackThroughWhatStandsBeforeIsClosedAndAThinThingIsNot) {
    for (const ivec2 along : {ivec2(0, 1), ivec2(1, 0), ivec2(1, 1), ivec2(1, -1)}) {
        Picture crack(21, 21), pole(21, 21);
        for (int y = 0; y < 21; ++y)
            for (int x = 0; x < 21; ++x)
                crack.put(x, y, 1.0f), pole.put(x, y, 0.4f);
        for (int k = -8; k <= 8; ++k)
            crack.put(10 + k * along.x, 10 + k * along.y, 0.4f), pole.put(10 + k * along.x, 10 + k * along.y, 1.0f);
        const uvec2 closed = crack.fill(10, 10, fillWithin(4));
        EXPECT_NEAR(eyeDisparityOf(closed), 1, 1e-6) << along.x << " " << along.y;
        EXPECT_EQ(closed.x & 3u, kClassFilled);
        for (int y = 1; y < 20; ++y)
            for (int x = 1; x < 20; ++x)
                EXPECT_EQ(pole.fill(x, y, fillWithin(4)), pole.keys(x, y)) << x << " " << y;
    }
    // Where a crack goes on beside itself, as most do.
    for (const int rows : {1, 2, 3}) {
        Picture stepped(21, 21);
        for (int y = 0; y < 21; ++y)
            for (int x = 0; x < 21; ++x)
                stepped.put(x, y, x == 4 + y / rows ? 0.4f : 1.0f);
        for (int y = 3; y < 15; ++y)
            EXPECT_NEAR(eyeDisparityOf(stepped.fill(4 + y / rows, y, fillWithin(4))), 1, 1e-6) << rows << ", " << y;
    }
    // What is seen past a straight edge, in a gap of two pixels, and through a fence's squares is not closed.
    Picture edge(21, 21);
    for (int y = 0; y < 21; ++y)
        for (int x = 0; x < 21; ++x)
            edge.put(x, y, x < 6 || x == 9 || (x > 12 && (x % 3 == 0 || y % 3 == 0)) ? 1.0f : 0.4f);
    for (int y = 1; y < 20; ++y)
        for (int x = 1; x < 20; ++x)
            EXPECT_EQ(edge.fill(x, y, fillWithin(4)), edge.keys(x, y)) << x << " " << y;
}

class HoleFillOnDevice : public RenderTest {};

/// Room and walls seen from so near that their samples part, past the edges of what was taken.
TEST_F(HoleFillOnDevice, IsThatOfTheProcessor) {
    const CutScene room = cut({takeRoom(cameraOf(200, 150, 1.2), poseAt({-0.2, 0.1, 0.1}, 0.1, 0.05)),
                               takeRoom(cameraOf(160, 120, 0.9), poseAt({0.3, 0, 0.2}, -0.2, 0.1))});
    const auto blocks = room.blocks();
    const GpuScene scene(testDevice(), blocks);
    for (const int radius : {0, 1, 2, 4, 9, 16})
        for (const double x : {-0.3, 0.2}) {
            const scene::View eye{cameraOf(333, 217, 1.7), poseAt({x, 0.05, 0.4}, 0.3, -0.1)};
            Quality quality;
            quality.maxFootprint = 1;
            quality.holes.radius = radius;
            scene::WarpOptions options;
            options.preference = quality.preference;
            scene::ZBuffer zBuffer(333, 217, 0);
            scene::warpPoints(blocks, eye, options, zBuffer);
            if (radius > 0) zBuffer = filledOnProcessor(zBuffer, quality.holes);
            const scene::EyeImage truth = scene::resolve(zBuffer);
            const EyeImage drawn = drawOnce(scene, eye, quality);
            int differ = 0, fillers = 0;
            for (std::size_t i = 0; i < drawn.colour.size(); ++i) {
                fillers += truth.pixelClass.pixels()[i] == 2;
                const scene::Rgb8 a = drawn.colour.pixels()[i], b = truth.colour.pixels()[i];
                const bool isAlike = drawn.pixelClass.pixels()[i] == truth.pixelClass.pixels()[i] &&
                                     std::abs(a.r - b.r) <= 1 && std::abs(a.g - b.g) <= 1 && std::abs(a.b - b.b) <= 1 &&
                                     std::abs(drawn.depthMetres.pixels()[i] - truth.depthMetres.pixels()[i]) <=
                                         1e-5f * truth.depthMetres.pixels()[i];
                differ += !isAlike;
            }
            // One sample that rounds into the next pixel changes what is filled around it.
            EXPECT_LE(differ, 0.002 * 333 * 217) << radius << " " << x;
            EXPECT_EQ(fillers > 500, radius > 0) << fillers;
        }
}

/// Filled by the processor is what the device itself drew without filling, so that nothing of the warp's rounding is in
/// it: no hole may differ, in pictures of any width.
TEST_F(HoleFillOnDevice, NoHoleIsForgottenAndNoneAdded) {
    const CutScene room = cut({takeRoom(cameraOf(200, 150, 1.2), poseAt({-0.2, 0.1, 0.1}, 0.1, 0.05)),
                               takeRoom(cameraOf(160, 120, 0.9), poseAt({0.3, 0, 0.2}, -0.2, 0.1))});
    const GpuScene scene(testDevice(), room.blocks());
    for (const int width : {333, 65, 31, 2}) {
        const scene::View eye{{width, 217, 566, 566, 0.5 * width, 108.5}, poseAt({-0.3, 0.05, 0.4}, 0.3, -0.1)};
        Quality quality;
        quality.maxFootprint = 1;
        quality.holes.radius = 0;
        const EyeImage open = drawOnce(scene, eye, quality);
        for (const int radius : {1, 3, 4, kMostHoleRadius}) {
            quality.holes.radius = radius;
            const EyeImage drawn = drawOnce(scene, eye, quality);
            scene::ZBuffer zBuffer(width, 217, 0);
            for (std::size_t i = 0; i < zBuffer.pixels().size(); ++i) {
                if (open.pixelClass.pixels()[i] == 0) continue;
                const scene::Rgb8 c = open.colour.pixels()[i];
                const uvec2 key = packKey(1 / open.depthMetres.pixels()[i],
                                          uint(c.r) | uint(c.g) << 8 | uint(c.b) << 16, open.pixelClass.pixels()[i]);
                zBuffer.pixels()[i] = std::uint64_t{key.y} << 32 | key.x;
            }
            const scene::EyeImage truth = scene::resolve(filledOnProcessor(zBuffer, quality.holes));
            int differ = 0, fillers = 0;
            for (std::size_t i = 0; i < zBuffer.pixels().size(); ++i) {
                fillers += truth.pixelClass.pixels()[i] == 2;
                differ += truth.pixelClass.pixels()[i] != drawn.pixelClass.pixels()[i];
            }
            EXPECT_EQ(differ, 0) << "radius " << radius << ", width " << width << ": " << fillers << " filled";
            EXPECT_GT(fillers, width > 60 ? 100 : 0) << "radius " << radius << ", width " << width;
        }
    }
}

TEST_F(HoleFillOnDevice, TheSameBytesEveryTime) {
    const CutScene room = roomFromWithin(60);
    const GpuScene scene(testDevice(), room.blocks());
    Quality quality;
    quality.maxFootprint = 1;
    quality.holes.radius = 4;
    const scene::View eye{cameraOf(400, 300, 1.2), poseAt({0.4, 0, 0.2}, 0.4, 0.1)};
    const EyeImage first = drawOnce(scene, eye, quality);
    for (int i = 0; i < 3; ++i)
        EXPECT_TRUE(isSame(first, drawOnce(scene, eye, quality)));
}

/// From nearby the samples of a wall part; what lies between them is found at its place, and between a ball and the
/// wall behind it nothing is made up.
TEST_F(HoleFillOnDevice, FilledPixelsStandWhereTheSurfaceDoes) {
    const scene::DepthImage image = takeRoom(cameraOf(160, 120, 1.2), poseAt({0, 0, 0}, 0, 0));
    const CutScene room = cut({image});
    const GpuScene scene(testDevice(), room.blocks());
    const scene::View eye{cameraOf(320, 240, 1.0), poseAt({0.15, 0.1, 0.3}, 0.05, 0.1)};
    const scene::DepthImage truth = takeRoom(eye.camera, eye.worldFromEye);
    Quality quality;
    quality.maxFootprint = 1;
    for (const int radius : {1, 4, 8}) {
        quality.holes.radius = radius;
        const EyeImage drawn = drawOnce(scene, eye, quality);
        int filledCount = 0, wrong = 0;
        for (std::size_t i = 0; i < drawn.colour.size(); ++i) {
            if (drawn.pixelClass.pixels()[i] != kClassFilled) continue;
            ++filledCount;
            wrong += std::abs(drawn.depthMetres.pixels()[i] * truth.disparity.pixels()[i] - 1) > 0.03f;
        }
        EXPECT_GT(filledCount, 4000) << radius;
        EXPECT_LE(wrong, 0.02 * filledCount) << radius;
    }
}

} // namespace
} // namespace render
