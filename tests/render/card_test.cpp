// Work is dealt out otherwise on graphics cards: a pixel an invocation, large pieces by many workgroups, no looks at
// what is hidden. Pictures must be the same to the byte, as one driver computes them.

#include "render/shaders/shared/hole_words.h"
#include "render/shaders/shared/large_part.h"
#include "scene/pyramid.h"
#include "tests/render/studio.h"

#include <array>
#include <vector>

namespace render {
namespace {

class CardTest : public RenderTest {
  protected:
    void SetUp() override {
        if (!testDevice().isProcessor()) GTEST_SKIP() << "draws as a card in any case";
    }

    /// Every way, from every place.
    static void expectSamePictures(const CutScene& scene, std::span<const scene::View> views,
                                   const scene::Coverage* coverage = nullptr) {
        Studio processor(scene, coverage), onCard(scene, coverage, cardDevice());
        for (const Way& way : ways()) {
            Quality quality = way.quality;
            quality.leavesOutHidden = false; // gaps that are filled anyway would differ
            for (std::size_t i = 0; i < views.size(); ++i)
                EXPECT_TRUE(isSame(processor.draw(views[i], quality), onCard.draw(views[i], quality)))
                    << way.name << ", view " << i;
        }
    }
};

TEST_F(CardTest, IsNoProcessor) {
    EXPECT_FALSE(cardDevice().isProcessor());
}

TEST_F(CardTest, ARoomIsDrawnAsByAProcessor) {
    // Neither side of whole words nor of whole parts, and rows wider than one workgroup fills the holes of.
    const scene::Camera eye = cameraOf(300, 90, 1.8);
    scene::Coverage coverage;
    coverage.cornerInWorld = glm::dvec3(-8);
    coverage.edgeMetres = 16;
    coverage.nodes.resize(1);
    coverage.nodes[0].unseen = scene::coverageMask(scene::coverageBit(2, 1, 2));
    const std::vector<scene::View> views{{eye, poseAt({0, 0, 0}, 0.2, 0)}, {eye, poseAt({0.8, 0.3, -1.1}, 2.1, 0.3)}};
    expectSamePictures(roomAllAround(), views, &coverage);
}

TEST_F(CardTest, WhatCoversThePictureIsDrawnAsByAProcessor) {
    // Before a wall: facing it, along it and with part of it behind the eye.
    const scene::Camera eye = cameraOf(150, 90, 1.4);
    const CutScene wall = cutInLevels({takePlane(cameraOf(120, 120, 1.5), {0, 0, 1}, 2)});
    std::vector<scene::View> views;
    for (const double distance : {0.05, 0.004, 1e-4})
        for (const double yaw : {0.0, 0.9, 1.5})
            views.push_back({eye, poseAt({0.0021, 0.0013, 2 - distance}, yaw, 0.1)});
    expectSamePictures(wall, views);
}

/// A frame of both eyes of what of a scene goes into so many bytes, and the same while it stands, with the unseen
/// shown.
std::vector<EyeImage> framesOf(const Device& device, std::span<const scene::TileBlock> blocks, std::size_t bytes,
                               std::span<const scene::View> eyes, Quality quality, const scene::Coverage& seen) {
    GpuScene scene(device, blocks, {.budgetBytes = bytes});
    EXPECT_TRUE(scene.isStreamed());
    scene.settle(eyes, quality);
    const GpuCoverage coverage(device, seen);
    Renderer renderer(device, scene, eyes[0].camera.width, eyes[0].camera.height, 2);
    renderer.letFramesStand(true);
    renderer.draw(eyes, quality);
    std::vector<EyeImage> frames = renderer.readBack();
    EXPECT_TRUE(renderer.draw(eyes, quality).isStanding);
    renderer.useCoverage(&coverage);
    EXPECT_TRUE(renderer.draw(eyes, quality).isStanding);
    for (EyeImage& eye : renderer.readBack())
        frames.push_back(std::move(eye));
    return frames;
}

TEST_F(CardTest, BothEyesOfWhatIsOnlyPartlyThereAreDrawnAsByAProcessor) {
    CutScene rooms;
    for (const double x : {0.0, 6.0})
        for (const scene::DepthImage& face : roomFromWithin(160).images) {
            rooms.images.push_back(face);
            rooms.images.back().worldFromCamera.translation.x += x;
            rooms.sets.push_back(scene::cutIntoLevels(rooms.images.back(), {}));
        }
    const std::vector<scene::TileBlock> blocks = rooms.blocks();
    const std::size_t bytes = GpuScene(testDevice(), blocks).bytesResident() / 3;
    const auto [left, right] = scene::eyesOf(cameraOf(150, 70, 1.6), poseAt({0.3, 0.1, -0.4}, 0.4, 0.1), 0.063);
    const std::array eyes{left, right};
    scene::Coverage coverage;
    coverage.cornerInWorld = glm::dvec3(-8);
    coverage.edgeMetres = 32;
    coverage.nodes.resize(1);
    coverage.nodes[0].unseen = scene::coverageMask(scene::coverageBit(1, 1, 1));
    for (const Warp warp : {Warp::points, Warp::mesh, Warp::adaptive, Warp::splats}) {
        Quality quality = qualityOf(warp);
        quality.leavesOutHidden = false;
        const auto expected = framesOf(testDevice(), blocks, bytes, eyes, quality, coverage);
        const auto found = framesOf(cardDevice(), blocks, bytes, eyes, quality, coverage);
        for (std::size_t i = 0; i < 2; ++i)
            EXPECT_TRUE(isSame(found[i], expected[i])) << static_cast<int>(warp) << ", picture " << i;
        // Rays through open space that go together end elsewhere where fewer do, and are rounded otherwise from there.
        for (std::size_t i = 2; i < 4; ++i) {
            EXPECT_TRUE(found[i].pixelClass == expected[i].pixelClass) << static_cast<int>(warp) << ", picture " << i;
            for (std::size_t k = 0; k < expected[i].depthMetres.size(); ++k) {
                const float depth = expected[i].depthMetres.pixels()[k];
                EXPECT_NEAR(found[i].depthMetres.pixels()[k], depth, 1e-5f * depth) << k;
            }
        }
        EXPECT_FALSE(isSame(expected[0], expected[2])) << "something is unseen";
    }
}

/// Lavapipe lets no invocation go through loops as often as these would: parts of the picture were missing.
TEST_F(CardTest, LargePicturesRightBeforeAWallAreDrawnAsByAProcessor) {
    const scene::Camera eye = cameraOf(1600, 1200, 1.4);
    const CutScene wall = cutInLevels({takePlane(cameraOf(120, 120, 1.5), {0, 0, 1}, 2)});
    std::vector<scene::View> views;
    for (const double distance : {0.2, 0.004})
        views.push_back({eye, poseAt({0.0021, 0.0013, 2 - distance}, 0.6, 0.1)});
    expectSamePictures(wall, views);
    Studio processor(wall), onCard(wall, nullptr, cardDevice());
    for (const Warp warp : {Warp::mesh, Warp::adaptive})
        EXPECT_EQ(coverage(processor.draw(views[0], qualityOf(warp))), 1) << static_cast<int>(warp);
    Quality widest = qualityOf(Warp::points);
    widest.maxFootprint = 64; // as wide as is let
    EXPECT_TRUE(isSame(processor.draw(views[0], widest), onCard.draw(views[0], widest)));
}

TEST_F(CardTest, WhatIsTooMuchForTheListIsDrawnAllTheSame) {
    // Before so many walls, so near that one square of each covers the picture.
    const scene::Camera eye = cameraOf(64, 48, 1.4);
    constexpr int kWalls = 300;
    const auto words = static_cast<uint>(pinholesAt(eye.width, eye.height, eye.height));
    const std::size_t room = (words - kLargePartsHead) * sizeof(std::uint32_t) / sizeof(LargePart);
    ASSERT_GT(kWalls * partsOf({eye.width, eye.height}), room);
    std::vector<scene::DepthImage> images;
    for (int i = 0; i < kWalls; ++i)
        images.push_back(takePlane(cameraOf(16, 16, 1.5), {0, 0, 1}, 2 - 1e-5 * i)); // the nearest comes last
    const scene::View view{eye, poseAt({0, 0, 1.99}, 0.1, 0)};
    expectSamePictures(cutInLevels(std::move(images)), std::array{view});
}

} // namespace
} // namespace render
