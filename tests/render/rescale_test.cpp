// Pictures that are drawn at another resolution than the eye's.

#include "render/images.h"
#include "render/post/rescale.h"
#include "render/shaders/shared/rescale.h"
#include "tests/render/test_device.h"
#include "tests/render/test_scenes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

namespace render {
namespace {

constexpr std::array<std::pair<uint, uint>, 9> kSizes{
    {{1, 1}, {1, 7}, {5, 5}, {320, 640}, {333, 640}, {639, 640}, {641, 640}, {1280, 640}, {2560, 640}}};

TEST(RescaleWeights, AreOnlyOnPixelsThatThereAreAndSumToTheNewPixelsWidth) {
    for (const auto& [from, to] : kSizes)
        for (uint i = 0; i < to; ++i) {
            const uint first = firstPixel(i, from, to), last = lastPixel(i, from, to), near = nearestPixel(i, from, to);
            ASSERT_LE(first, near) << from << " to " << to << ", pixel " << i;
            ASSERT_LE(near, last);
            ASSERT_LT(last, from);
            double sum = 0, mean = 0;
            for (uint p = first; p <= last; ++p) {
                sum += weightOf(p, i, from, to);
                mean += (p + 0.5) * weightOf(p, i, from, to);
            }
            EXPECT_GT(weightOf(near, i, from, to), 0u) << from << " to " << to << ", pixel " << i;
            const double width = std::max(1.0, static_cast<double>(from) / to);
            EXPECT_NEAR(sum / kWholeWeight, width, 0.01) << from << " to " << to << ", pixel " << i;
            // Weighted so, the old pixels stand where the new one does, unless there is an edge.
            const double centre = (i + 0.5) * from / to;
            if (centre < 0.5 || centre > from - 0.5) continue;
            EXPECT_NEAR(mean / sum, centre, 0.01) << from << " to " << to << ", pixel " << i;
        }
}

TEST(RescaleWeights, OfAnEnlargedPictureAreTheSameWorkedOutAtOnce) {
    for (const auto& [from, to] : kSizes)
        for (uint i = 0; i < to && from <= to; ++i) {
            const Between between = betweenOf(i, from, to);
            ASSERT_EQ(between.first, firstPixel(i, from, to)) << from << " to " << to << ", pixel " << i;
            ASSERT_EQ(between.last, lastPixel(i, from, to)) << from << " to " << to << ", pixel " << i;
            EXPECT_EQ(between.isNearLast ? between.last : between.first, nearestPixel(i, from, to));
            EXPECT_EQ(kWholeWeight - between.lastWeight, weightOf(between.first, i, from, to));
            const uint nearest = nearestPixel(i, from, to);
            const double apart = nearest + 0.5 - (i + 0.5) * from / to;
            EXPECT_NEAR(nearestCentre(i, nearest, from, to), kPerPixel * apart, 0.5001) << "at the borders, too";
        }
}

TEST(RescaleColours, OfOneKindAreMixedAndOthersAreLeftOut) {
    EXPECT_EQ(kindOf(0x01000000u), kindOf(0x02ffffffu)) << "filled stands beside seen";
    EXPECT_NE(kindOf(0x01000000u), kindOf(0x03000000u)) << "the unseen must not shine through";
    EXPECT_NE(kindOf(0x01000000u), kindOf(0x00000000u));
    ColourSum sum{0, 0, 0, 0};
    sum = addColour(sum, 0x01ff8000u, 3);
    sum = addColour(sum, 0x01000000u, 1);
    EXPECT_EQ(meanColour(sum, 0x02123456u), 0x02bf6000u);
}

/// As shaders/rescale.comp should do it, from the same weights.
EyeImage rescaledOnProcessor(const EyeImage& from, int width, int height) {
    EyeImage to{{width, height}, {width, height}, {width, height}};
    const uint fromWidth = static_cast<uint>(from.colour.width()), fromHeight = static_cast<uint>(from.colour.height());
    const auto pixelAt = [&](uint x, uint y) {
        const scene::Rgb8 c = from.colour(static_cast<int>(x), static_cast<int>(y));
        return static_cast<uint>(c.r | c.g << 8 | c.b << 16) |
               static_cast<uint>(from.pixelClass(static_cast<int>(x), static_cast<int>(y))) << 24;
    };
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const uint ux = static_cast<uint>(x), uy = static_cast<uint>(y), toWidth = static_cast<uint>(width),
                       toHeight = static_cast<uint>(height);
            const uint nearX = nearestPixel(ux, fromWidth, toWidth), nearY = nearestPixel(uy, fromHeight, toHeight);
            const uint nearest = pixelAt(nearX, nearY);
            ColourSum sum{0, 0, 0, 0};
            for (uint v = firstPixel(uy, fromHeight, toHeight); v <= lastPixel(uy, fromHeight, toHeight); ++v)
                for (uint u = firstPixel(ux, fromWidth, toWidth); u <= lastPixel(ux, fromWidth, toWidth); ++u)
                    if (kindOf(pixelAt(u, v)) == kindOf(nearest))
                        sum = addColour(sum, pixelAt(u, v),
                                        weightOf(u, ux, fromWidth, toWidth) * weightOf(v, uy, fromHeight, toHeight));
            const uint mean = meanColour(sum, nearest);
            to.colour(x, y) = {static_cast<std::uint8_t>(mean), static_cast<std::uint8_t>(mean >> 8),
                               static_cast<std::uint8_t>(mean >> 16)};
            to.pixelClass(x, y) = static_cast<std::uint8_t>(mean >> 24);
            to.depthMetres(x, y) = from.depthMetres(static_cast<int>(nearX), static_cast<int>(nearY));
        }
    return to;
}

class RescaleTest : public RenderTest {
  protected:
    static scene::View eyeOf(int width, int height) {
        return {scene::resized(cameraOf(160, 120, 1.2), width, height), poseAt({0.4, 0.1, -0.7}, 0.4, 0.1)};
    }
    CutScene room_ = roomFromWithin(160);
    GpuScene scene_{testDevice(), room_.blocks()};
};

TEST_F(RescaleTest, IsThePictureOfTheOtherSizeRescaledOnTheProcessor) {
    for (const Warp warp : {Warp::points, Warp::mesh})
        for (const auto& [scale, width, height] : {std::tuple{0.5, 80, 60},
                                                   {0.7, 112, 84},
                                                   {0.37, 59, 44},
                                                   {1.5, 240, 180},
                                                   {2.0, 320, 240},
                                                   {4.0, 640, 480}}) {
            Quality quality{.warp = warp};
            const EyeImage other = drawOnce(scene_, eyeOf(width, height), quality);
            quality.resolutionScale = scale;
            const EyeImage scaled = drawOnce(scene_, eyeOf(160, 120), quality);
            EXPECT_GT(coverage(scaled), 0.5);
            EXPECT_TRUE(isSame(scaled, rescaledOnProcessor(other, 160, 120))) << "scale " << scale;
        }
}

TEST_F(RescaleTest, TheScaleMayChangeFromFrameToFrame) {
    const std::array views{eyeOf(160, 120), eyeOf(160, 120)};
    Renderer renderer(testDevice(), scene_, 160, 120, 2);
    std::mt19937 random(11);
    const std::array scales{1.0, 0.5, 2.0, 0.8, 1.3, 0.25};
    for (int frame = 0; frame < 24; ++frame) {
        Quality quality{.warp = Warp::points};
        quality.resolutionScale = scales[random() % scales.size()];
        const FrameStats stats = renderer.draw(views, quality);
        if (frame % 5 != 4) continue; // else two frames are in flight
        const std::vector<EyeImage> drawn = renderer.readBack();
        EXPECT_TRUE(isSame(drawn[0], drawOnce(scene_, views[0], quality))) << quality.resolutionScale;
        EXPECT_TRUE(isSame(drawn[1], drawn[0]));
    }
}

TEST_F(RescaleTest, SmallPicturesAreLeftAsTheyAreWhereTheDisplayEnlarges) {
    Renderer renderer(testDevice(), scene_, 160, 120, 2);
    const std::array views{eyeOf(160, 120), eyeOf(160, 120)};
    for (const auto& [scale, width, height] :
         {std::tuple{1.0, 160, 120}, {0.5, 80, 60}, {0.37, 59, 44}, {1.5, 160, 120}, {0.7, 112, 84}})
        for (const bool isLetTo : {true, false}) {
            Quality quality{.warp = Warp::points};
            renderer.letDisplayEnlarge(isLetTo);
            const EyeImage other = drawOnce(scene_, eyeOf(width, height), quality);
            quality.resolutionScale = scale;
            renderer.keepNext();
            const PictureSize size = renderer.draw(views, quality).picture;
            EXPECT_EQ(size.width, isLetTo ? width : 160) << scale;
            EXPECT_EQ(size.height, isLetTo ? height : 120) << scale;
            const EyeImage drawn = renderer.readBack()[1];
            const bool isSmall = isLetTo && scale < 1;
            EXPECT_TRUE(isSame(drawn, isSmall ? other : drawOnce(scene_, views[1], quality))) << scale;
            FramePictures kept;
            ASSERT_TRUE(renderer.takeKept(kept));
            EXPECT_EQ(kept.width, size.width);
            EXPECT_EQ(kept.height, size.height);
            ASSERT_EQ(kept.eyes[1].size(), drawn.colour.size());
            for (std::size_t i = 0; i < drawn.colour.size(); ++i)
                ASSERT_EQ(kept.eyes[1][i] & 0xffu, drawn.colour.pixels()[i].r) << i;
        }
}

TEST_F(RescaleTest, WhatIsWrittenOverThePictureIsEnlargedBeforeThat) {
    Renderer renderer(testDevice(), scene_, 160, 120, 1);
    renderer.letDisplayEnlarge(true);
    const std::array views{eyeOf(160, 120)};
    Quality quality{.warp = Warp::points};
    quality.resolutionScale = 0.5;
    Overlay overlay;
    overlay.labels.push_back({.at = views[0].worldFromEye * glm::dvec3(0, 0, 0.5), .text = "A", .colour = {}});
    EXPECT_EQ(renderer.draw(views, quality, {}, &overlay).picture.width, 160);

    // A line is as wide as it would be, enlarged.
    Overlay line;
    line.segments.push_back({.a = views[0].worldFromEye * glm::dvec3(-0.2, 0, 0.5),
                             .b = views[0].worldFromEye * glm::dvec3(0.2, 0, 0.5),
                             .colour = {0, 255, 0},
                             .widthPixels = 8});
    EXPECT_EQ(renderer.draw(views, quality, {}, &line).picture.width, 80);
    const EyeImage drawn = renderer.readBack()[0];
    int high = 0;
    for (int y = 0; y < 60; ++y)
        if (drawn.colour(40, y) == scene::Rgb8{0, 255, 0}) ++high;
    EXPECT_GE(high, 3);
    EXPECT_LE(high, 5);
}

TEST_F(RescaleTest, ClassAndDepthAreThoseOfOnePixel) {
    Quality quality{.warp = Warp::mesh};
    quality.resolutionScale = 0.4;
    const EyeImage scaled = drawOnce(scene_, eyeOf(160, 120), quality);
    for (int y = 0; y < 120; ++y)
        for (int x = 0; x < 160; ++x)
            EXPECT_EQ(scaled.depthMetres(x, y) > 0, scaled.pixelClass(x, y) != 0) << x << ", " << y;
}

TEST(RescaleSides, AreNeverNothing) {
    EXPECT_EQ(scaledSide(1, 0.1), 1);
    EXPECT_EQ(scaledSide(640, 0.5), 320);
    EXPECT_EQ(scaledSide(480, 1.0), 480);
    EXPECT_EQ(scaledSide(3, 0.5), 2);
}

} // namespace
} // namespace render
