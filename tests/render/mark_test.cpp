// What was not measured, told by a tint, and which pixels that is.

#include "render/shaders/shared/mark.h"

#include "tests/render/reference.h"
#include "tests/render/test_device.h"
#include "tests/render/test_scenes.h"

#include <array>

namespace render {
namespace {

class MarkTest : public RenderTest {};

uint packed(const scene::Rgb8& colour, std::uint8_t pixelClass) {
    return uint{colour.r} | uint{colour.g} << 8 | uint{colour.b} << 16 | uint{pixelClass} << 24;
}

Quality fromNear(Warp warp) {
    Quality quality;
    quality.warp = warp;
    quality.preference.nearBaseline = 0.07f;
    quality.drawsLone = true;
    return quality;
}

TEST_F(MarkTest, TintsWhatWasNotMeasuredAndChangesNothingElse) {
    const CutScene room = roomInAllTiers();
    const auto blocks = room.blocks();
    const GpuScene scene(testDevice(), blocks);
    const scene::View view{cameraOf(200, 150, 1.5), poseAt({0.1, 0, 0.1}, 0.2, 0)};
    Painter paint(scene, view.camera);
    for (const Warp warp : {Warp::points, Warp::splats, Warp::mesh, Warp::adaptive})
        for (const double scale : {1.0, 0.5}) {
            Quality quality = fromNear(warp);
            quality.resolutionScale = scale;
            const EyeImage plain = paint(view, quality);
            quality.marksUnmeasured = true;
            const EyeImage tinted = paint(view, quality);
            std::array<int, 4> pixels{};
            for (std::size_t i = 0; i < plain.colour.size(); ++i) {
                const std::uint8_t pixelClass = plain.pixelClass.pixels()[i];
                ++pixels.at(pixelClass);
                ASSERT_EQ(packed(tinted.colour.pixels()[i], tinted.pixelClass.pixels()[i]),
                          marked(packed(plain.colour.pixels()[i], pixelClass)));
            }
            EXPECT_GT(pixels[kClassSeen], 1000);
            EXPECT_GT(pixels[kClassFilled], 1000);
            EXPECT_EQ(plain.depthMetres, tinted.depthMetres);
        }
}

struct WayOfDrawing {
    const char* name = "";
    Quality quality;
    bool isLeftSmall = false, hasOverlay = false;
};

std::vector<WayOfDrawing> waysOfDrawing() {
    std::vector<WayOfDrawing> ways{{"blended", fromNear(Warp::mesh)},
                                   {"points in one pass", fromNear(Warp::points)},
                                   {"splats in one pass", fromNear(Warp::splats)},
                                   {"left small", fromNear(Warp::points), true},
                                   {"larger", fromNear(Warp::points)},
                                   {"below an overlay", fromNear(Warp::points), false, true}};
    ways[0].quality.isBlended = true;
    ways[1].quality.isOnePass = ways[2].quality.isOnePass = true;
    ways[3].quality.resolutionScale = 0.7, ways[4].quality.resolutionScale = 1.5;
    for (WayOfDrawing& way : ways)
        way.quality.holes.radius = 4;
    return ways;
}

TEST_F(MarkTest, TintsBothEyesHoweverTheyAreDrawn) {
    const CutScene room = roomInAllTiers();
    const auto blocks = room.blocks();
    const GpuScene scene(testDevice(), blocks);
    const scene::Camera camera = cameraOf(200, 150, 1.5);
    const auto [left, right] = scene::eyesOf(camera, poseAt({0.1, 0, 0.1}, 0.2, 0), 0.063);
    const std::array eyes{left, right};
    Overlay cross;
    cross.segments.push_back({{-1, 0.2, 1.5}, {1, -0.2, 1.5}, {255, 0, 0}});
    for (const WayOfDrawing& way : waysOfDrawing()) {
        Renderer renderer(testDevice(), scene, camera.width, camera.height, 2);
        renderer.letDisplayEnlarge(way.isLeftSmall);
        const Overlay* const overlay = way.hasOverlay ? &cross : nullptr;
        renderer.draw(eyes, way.quality);
        const std::vector<EyeImage> plain = renderer.readBack();
        renderer.draw(eyes, way.quality, {}, overlay);
        const std::vector<EyeImage> below = renderer.readBack();
        Quality marks = way.quality;
        marks.marksUnmeasured = true;
        EXPECT_EQ(renderer.draw(eyes, marks, {}, overlay).isOnePass, way.quality.isOnePass) << way.name;
        const std::vector<EyeImage> tinted = renderer.readBack();
        for (std::size_t eye = 0; eye < eyes.size(); ++eye) {
            ASSERT_EQ(plain[eye].colour.width(), way.isLeftSmall ? 140 : 200) << way.name;
            std::array<int, 4> pixels{};
            int overlaid = 0;
            for (std::size_t i = 0; i < plain[eye].colour.size(); ++i) {
                const std::uint8_t pixelClass = plain[eye].pixelClass.pixels()[i];
                ++pixels.at(pixelClass);
                if (!(below[eye].colour.pixels()[i] == plain[eye].colour.pixels()[i])) { // what lies over it is no scan
                    ++overlaid;
                    continue;
                }
                ASSERT_EQ(packed(tinted[eye].colour.pixels()[i], tinted[eye].pixelClass.pixels()[i]),
                          marked(packed(plain[eye].colour.pixels()[i], pixelClass)))
                    << way.name << ", eye " << eye << ", pixel " << i;
            }
            EXPECT_GT(pixels[kClassSeen], 1000) << way.name;
            EXPECT_GT(pixels[kClassFilled], 1000) << way.name;
            EXPECT_EQ(overlaid > 0, way.hasOverlay) << way.name;
            EXPECT_EQ(plain[eye].depthMetres, tinted[eye].depthMetres) << way.name;
        }
    }
}

TEST(Mark, IsHalfOfATintAndLeavesWhatWasSeen) {
    EXPECT_EQ(marked(0x01123456u), 0x01123456u);
    EXPECT_EQ(marked(0x02000000u), 0x0218507fu);
    EXPECT_EQ(marked(0x02ffffffu), 0x0297cffeu);
    EXPECT_EQ(marked(0x00000000u), 0x00501040u);
    EXPECT_EQ(marked(0x03ffffffu), 0x03cf8fbfu);
}

// One wall that is closed everywhere: all eyes are shown it, and it is filled wherever it is.
TEST_F(MarkTest, WhatWasClosedIsDrawnForAllEyesAndIsFilled) {
    std::vector<scene::DepthImage> images{takeRoom(cameraOf(200, 150, 1.4), poseAt({}, 0, 0))};
    const CutScene measured = cut(images);
    for (std::uint8_t& flags : images[0].flags.pixels())
        flags = static_cast<std::uint8_t>(flags | scene::kInterpolated);
    const CutScene closed = cut(std::move(images));
    const auto measuredBlocks = measured.blocks(), closedBlocks = closed.blocks();
    const GpuScene asMeasured(testDevice(), measuredBlocks), asClosed(testDevice(), closedBlocks);
    for (const Warp warp : {Warp::points, Warp::splats, Warp::mesh, Warp::adaptive})
        for (const double away : {0.0, 0.8}) {
            const scene::View view{cameraOf(160, 120, 1.4), poseAt({away, 0, 0}, 0.3 * away, 0)};
            Painter paintMeasured(asMeasured, view.camera), paintClosed(asClosed, view.camera);
            const EyeImage seen = paintMeasured(view, fromNear(warp)), filled = paintClosed(view, fromNear(warp));
            EXPECT_EQ(seen.colour, filled.colour);
            EXPECT_EQ(seen.depthMetres, filled.depthMetres);
            int covered = 0;
            for (std::size_t i = 0; i < seen.colour.size(); ++i) {
                ASSERT_EQ(filled.pixelClass.pixels()[i], 2 * seen.pixelClass.pixels()[i]);
                covered += seen.pixelClass.pixels()[i] == kClassSeen;
            }
            EXPECT_GT(covered, 5000);
        }
}

} // namespace
} // namespace render
