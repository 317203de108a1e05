#include "tests/render/reference.h"
#include "tests/render/test_device.h"
#include "tests/render/test_scenes.h"

#include <array>
#include <cmath>

namespace render {
namespace {

class EdgeCases : public RenderTest {};

const scene::Camera kEdgeEye = cameraOf(200, 150, 1.5);

TEST_F(EdgeCases, NoImagesAtAll) {
    const GpuScene scene(testDevice(), {});
    EXPECT_EQ(scene.bytesResident(), 0u);
    for (const Warp warp : {Warp::points, Warp::mesh}) {
        const EyeImage drawn = drawOnce(scene, {kEdgeEye, {}}, {.warp = warp});
        EXPECT_EQ(coverage(drawn), 0.0);
        for (const float depth : drawn.depthMetres.pixels())
            ASSERT_EQ(depth, 0.0f);
    }
}

TEST_F(EdgeCases, AnImageWithoutTilesAndOneBesideIt) {
    scene::DepthImage empty = takePlane(kEdgeEye, {0, 0, 1}, 2);
    for (std::uint8_t& flags : empty.flags.pixels())
        flags = scene::kNoSurface;
    const CutScene both = cut({empty, takePlane(kEdgeEye, {0, 0, 1}, 3)});
    ASSERT_TRUE(both.sets[0].tiles.empty());
    const EyeImage drawn = drawOnce(GpuScene(testDevice(), both.blocks()), {kEdgeEye, {}}, {});
    EXPECT_EQ(coverage(drawn), 1.0);
    EXPECT_NEAR(drawn.depthMetres(7, 7), 3, 1e-5);
}

TEST_F(EdgeCases, LookingAwayShowsNothing) {
    const CutScene plane = cut({takePlane(cameraOf(64, 64, 0.5), {0, 0, 1}, 2)});
    const GpuScene scene(testDevice(), plane.blocks());
    Renderer renderer(testDevice(), scene, 200, 150, 1);
    const scene::View away{kEdgeEye, poseAt({0, 0, 0}, std::acos(-1.0), 0)};
    const FrameStats stats = renderer.draw(std::span(&away, 1), {});
    EXPECT_EQ(stats.eyes[0].tilesDrawn, 0u);
    EXPECT_EQ(coverage(renderer.readBack()[0]), 0.0);
}

TEST_F(EdgeCases, ATenthOfAMillimetreFromASurface) {
    const CutScene plane = cut({takePlane(cameraOf(200, 200, 1.5), {0, 0, 1}, 2)});
    const GpuScene scene(testDevice(), plane.blocks());
    const scene::View view{kEdgeEye, {glm::dmat3(1.0), {0.0021, 0.0013, 2 - 1e-4}}};
    const EyeImage mesh = drawOnce(scene, view, {.warp = Warp::mesh});
    EXPECT_EQ(coverage(mesh), 1.0);
    for (const float depth : mesh.depthMetres.pixels())
        ASSERT_NEAR(depth / 1e-4, 1, 0.02) << "2 um of quantisation";
    EXPECT_NO_THROW(drawOnce(scene, view, {}));
}

TEST_F(EdgeCases, InTheSurfaceAndBehindItNothingIsDrawnOfIt) {
    const CutScene plane = cut({takePlane(cameraOf(100, 100, 1.5), {0, 0, 1}, 2)});
    const GpuScene scene(testDevice(), plane.blocks());
    for (const Warp warp : {Warp::points, Warp::mesh})
        for (const double z : {2.0, 2.5})
            EXPECT_EQ(coverage(drawOnce(scene, {kEdgeEye, {glm::dmat3(1.0), {0, 0, z}}}, {.warp = warp})), 0.0) << z;
}

TEST_F(EdgeCases, SkyStandsBehindEverythingAndInfinitelyFar) {
    scene::DepthImage sky = takePlane(kEdgeEye, {0, 0, 1}, 1);
    for (float& disparity : sky.disparity.pixels())
        disparity = 0;
    for (scene::Rgb8& colour : sky.colour.pixels())
        colour = {250, 251, 252}; // larger than any other in a key
    scene::DepthImage wall = takePlane(kEdgeEye, {0, 0, 1}, 5000);
    for (int y = 0; y < 150; ++y)
        for (int x = 100; x < 200; ++x)
            wall.flags(x, y) |= scene::kNoSurface;
    const CutScene both = cut({sky, wall});
    const GpuScene scene(testDevice(), both.blocks());
    for (const Warp warp : {Warp::points, Warp::mesh}) {
        const EyeImage drawn = drawOnce(scene, {kEdgeEye, {}}, {.warp = warp});
        EXPECT_EQ(coverage(drawn), 1.0);
        EXPECT_EQ(drawn.colour(150, 70), (scene::Rgb8{250, 251, 252}));
        EXPECT_TRUE(std::isinf(drawn.depthMetres(150, 70)));
        EXPECT_NEAR(drawn.depthMetres(50, 70), 5000, 0.01);
        // Moving does not move the sky.
        const EyeImage moved = drawOnce(scene, {kEdgeEye, poseAt({900, 0, 0}, 0, 0)}, {.warp = warp});
        EXPECT_EQ(moved.colour(150, 70), (scene::Rgb8{250, 251, 252}));
    }
}

TEST_F(EdgeCases, SeveralPagesDrawWhatOneDraws) {
    const CutScene room = roomFromWithin(100, 16);
    const GpuScene whole(testDevice(), room.blocks()), paged(testDevice(), room.blocks(), 20000);
    EXPECT_EQ(whole.pageCount(), 1u);
    EXPECT_GT(paged.pageCount(), 20u);
    const scene::View view{kEdgeEye, poseAt({0.3, 0, 0}, 1, 0.3)};
    for (const Warp warp : {Warp::points, Warp::mesh})
        EXPECT_TRUE(isSame(drawOnce(whole, view, {.warp = warp}), drawOnce(paged, view, {.warp = warp})));
}

TEST_F(EdgeCases, WhatHiddenTilesAreLeftOutOfIsTheSamePicture) {
    if (!testDevice().isProcessor()) GTEST_SKIP() << "graphics cards leave nothing out";
    // The same room again and again behind its walls, and three pictures of it in all tiers.
    const CutScene room = roomInAllTiers(), faces = roomFromWithin(160);
    std::vector<scene::TileBlock> blocks = room.blocks();
    for (int away = 0; away < 6; ++away)
        for (scene::TileBlock block : faces.blocks()) {
            block.worldFromCamera.translation += glm::dvec3(3.0 * away, 0.2 * away, 7.0 * away);
            blocks.push_back(block);
        }
    ASSERT_TRUE(testDevice().looksAlways()) << "REVISIT_TUNING is something else";
    const GpuScene scene(testDevice(), blocks);
    Renderer renderer(testDevice(), scene, kEdgeEye.width, kEdgeEye.height, 1);
    const auto draw = [&](const scene::View& view, const Quality& quality) {
        renderer.draw({&view, 1}, quality);
        return renderer.readBack()[0];
    };
    std::size_t batches = 0;
    for (const Warp warp : {Warp::points, Warp::mesh, Warp::adaptive, Warp::splats})
        for (const float nearBaseline : {0.0f, 0.2f})
            for (int i = 0; i < 6; ++i) {
                const scene::View view{kEdgeEye, poseAt({0.3 * i - 0.9, 0.1 * i - 0.3, 0.2}, 1.1 * i, 0.1 * i - 0.2)};
                Quality with, without;
                with.warp = warp, with.preference.nearBaseline = nearBaseline, with.maxFootprint = 1 + i;
                // Meshes have gaps at silhouettes alone, and what is seen through those is no matter of filling.
                if (warp == Warp::mesh || warp == Warp::adaptive) with.holes.radius = i % 2 == 0 ? 0 : 4;
                with.drawsLone = with.drawsSquaresNear = i % 3 != 0;
                without = with;
                without.leavesOutHidden = false;
                EXPECT_TRUE(isSame(draw(view, with), draw(view, without))) << static_cast<int>(warp) << " " << i;
                DrawList list;
                VisibleTiles all{numbersOf(scene.pieces()), {}, {}};
                const auto sources = sourceViewsOf(scene.images(), view, with);
                std::vector<ImagePlanes> planes;
                for (std::size_t k = 0; k < sources.size(); ++k)
                    planes.push_back(planesOf(sources[k].eyeImageFromSource, kEdgeEye.width, kEdgeEye.height, 4,
                                              scene.images()[k].extent));
                cull(
                    scene.bounds(), scene.pieces(), [&](const TilePiece& piece) { return planes[piece.image]; }, all);
                chooseDraws(scene.index(), scene.places(), sources, all, with, list,
                            static_cast<double>(kEdgeEye.width * kEdgeEye.height), 0);
                batches = std::max<std::size_t>(batches, list.runs.back().batch + 1);
            }
    EXPECT_EQ(batches, 3u) << "there was something to leave out";
}

TEST_F(EdgeCases, ListsGrowWithWhatIsSeen) {
    // One image in tiny tiles, seen by a corner first and then whole: more draws than there was room for at first.
    const CutScene plane = cut({takePlane(cameraOf(600, 600, 1.5), {0, 0, 1}, 2)}, 6);
    const GpuScene scene(testDevice(), plane.blocks());
    ASSERT_GT(scene.tiles().size(), 2 * 4096u);
    const scene::View corner{kEdgeEye, poseAt({0, 0, 0}, 0.75, 0)}, whole{kEdgeEye, poseAt({0, 0, -1}, 0, 0)};
    for (const bool isBlended : {false, true}) {
        Quality quality;
        quality.isBlended = isBlended;
        Renderer renderer(testDevice(), scene, kEdgeEye.width, kEdgeEye.height, 1);
        for (const scene::View& view : {corner, whole, whole, corner}) {
            renderer.draw({&view, 1}, quality);
            EXPECT_TRUE(isSame(renderer.readBack()[0], drawOnce(scene, view, quality)));
        }
        EXPECT_GT(renderer.finish().eyes[0].tilesTested, 4096u);
    }
}

TEST_F(EdgeCases, MoreThanAPageOfVertices) {
    // The same block again and again: 70 MiB of vertices. The first, one in the middle and the last stand nearer, aside
    // of each other, so that what is missing of any shows.
    constexpr std::size_t kSmallPageBytes = std::size_t{64} << 20;
    const CutScene plane = cut({takePlane(cameraOf(512, 512, 1.5), {0, 0, 1}, 2)});
    std::vector<scene::TileBlock> blocks(36, plane.blocks()[0]);
    blocks[0].worldFromCamera.translation = {-0.9, 0, -0.1};
    blocks[18].worldFromCamera.translation = {0.9, 0, -0.2};
    blocks[35].worldFromCamera.translation = {0, 0.9, -0.3};
    const std::vector few{blocks[0], blocks[1], blocks[18], blocks[35]};
    const GpuScene scene(testDevice(), blocks, kSmallPageBytes);
    EXPECT_GT(scene.bytesResident(), 2 * kSmallPageBytes);
    EXPECT_GE(scene.pageCount(), 2u);
    EXPECT_EQ(GpuScene(testDevice(), blocks).pageCount(), 1u);
    const scene::View view{kEdgeEye, {}};
    const EyeImage once = drawOnce(GpuScene(testDevice(), few), view, {});
    EXPECT_TRUE(isSame(drawOnce(scene, view, {}), once));
    // Brought in several goes where the processor cannot see the device's memory.
    const GpuScene staged(testDevice(), blocks, {.pageBytes = kSmallPageBytes, .isStaged = true});
    EXPECT_TRUE(isSame(drawOnce(staged, view, {}), once));
    for (std::size_t left = 0; left < few.size(); ++left) {
        if (left == 1) continue; // one of many that stand in the same place
        std::vector<scene::TileBlock> others = few;
        others.erase(others.begin() + static_cast<std::ptrdiff_t>(left));
        EXPECT_FALSE(isSame(drawOnce(GpuScene(testDevice(), others), view, {}), once)) << left;
    }
}

TEST_F(EdgeCases, AChunkMayBeEmpty) {
    const CutScene plane = cut({takePlane(cameraOf(64, 64, 1.5), {0, 0, 1}, 2)});
    const std::array nothing{scene::Tile{.width = 8, .height = 8}};
    scene::TileBlock empty = plane.blocks()[0];
    empty.tiles = nothing, empty.vertices = {}, empty.quads = {};
    const scene::View view{kEdgeEye, {}};
    for (const bool isStaged : {false, true}) {
        const auto drawn = [&](const std::vector<scene::TileBlock>& blocks) {
            return drawOnce(GpuScene(testDevice(), blocks, {.isStaged = isStaged}), view, {});
        };
        EXPECT_EQ(coverage(drawn({empty})), 0.0);
        EXPECT_TRUE(isSame(drawn({empty, plane.blocks()[0]}), drawn(plane.blocks())));
    }
}

TEST_F(EdgeCases, OnePixelAndOddSizes) {
    const CutScene plane = cut({takePlane(cameraOf(65, 33, 1.5), {0, 0, 1}, 2)}, 63);
    const GpuScene scene(testDevice(), plane.blocks());
    for (const int radius : {0, 1, kMostHoleRadius})
        for (const glm::ivec2 size : {glm::ivec2(1, 1), glm::ivec2(3, 1), glm::ivec2(1, 7), glm::ivec2(37, 19),
                                      glm::ivec2(31, 5), glm::ivec2(32, 5), glm::ivec2(33, 5)}) {
            Quality quality;
            quality.maxFootprint = 8, quality.holes.radius = radius;
            const EyeImage drawn = drawOnce(scene, {{size.x, size.y, 60, 60, size.x / 2.0, size.y / 2.0}, {}}, quality);
            EXPECT_EQ(coverage(drawn), 1.0) << size.x << " x " << size.y << ", radius " << radius;
        }
}

} // namespace
} // namespace render
