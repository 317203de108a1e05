#include "tests/render/lone_samples.h"
#include "tests/render/reference.h"
#include "tests/render/test_device.h"
#include "tests/render/test_scenes.h"

#include <tbb/global_control.h>

#include <array>
#include <cmath>
#include <random>

namespace render {
namespace {

class MeshTest : public RenderTest {};

const Quality kMesh{.warp = Warp::mesh};

TEST_F(MeshTest, AgreesWithTheReference) {
    const CutScene room = roomFromWithin(100);
    const auto blocks = room.blocks();
    const GpuScene scene(testDevice(), blocks);
    std::mt19937 random(41);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int i = 0; i < 8; ++i) {
        const scene::View view{cameraOf(200, 150, 1.5), poseAt({unit(random), 0.5 * unit(random), unit(random)},
                                                               3 * unit(random), 0.5 * unit(random))};
        const EyeImage drawn = drawOnce(scene, view, kMesh);
        const ReferenceImage truth = referenceMesh(blocks, view);
        double certain = 0, covered = 0, sameDepth = 0, sameColour = 0;
        for (int y = 0; y < 150; ++y)
            for (int x = 0; x < 200; ++x) {
                if (truth.isUncertain(x, y)) {
                    EXPECT_TRUE(truth.disparity(x, y) < 0 || drawn.pixelClass(x, y) == 1)
                        << "a crack at " << x << " " << y;
                    continue;
                }
                ++certain;
                ASSERT_EQ(drawn.pixelClass(x, y) != 0, truth.disparity(x, y) >= 0) << i << ": " << x << " " << y;
                if (truth.disparity(x, y) < 0) continue;
                ++covered;
                const scene::Rgb8 a = drawn.colour(x, y), b = truth.colour(x, y);
                sameColour += std::abs(a.r - b.r) <= 2 && std::abs(a.g - b.g) <= 2 && std::abs(a.b - b.b) <= 2;
                sameDepth += std::abs(drawn.depthMetres(x, y) * truth.disparity(x, y) - 1) < 2e-5;
            }
        EXPECT_GT(certain, 0.5 * 200 * 150);
        EXPECT_GE(sameDepth, 0.999 * covered) << i;
        EXPECT_GE(sameColour, 0.999 * covered) << i;
    }
}

TEST_F(MeshTest, FromItsOwnCameraAnImageComesBackButForItsLastRowAndColumn) {
    const scene::DepthImage image = takePlane(cameraOf(70, 50, 1.2), glm::normalize(glm::dvec3(0.2, 0.3, 1)), 2);
    const CutScene cutScene = cut({image});
    const EyeImage drawn = drawOnce(GpuScene(testDevice(), cutScene.blocks()), {image.camera, {}}, kMesh);
    EXPECT_EQ(drawn.colour, image.colour);
    EXPECT_EQ(coverage(drawn), 1.0) << "the fat edges reach the centres of the outermost samples";
}

/// Tiles meet at every third sample, at any scale, turned and tilted.
TEST_F(MeshTest, AMagnifiedPlaneHasNeitherPinholesNorCracks) {
    std::mt19937 random(43);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int i = 0; i < 40; ++i) {
        const glm::dvec3 normal = glm::normalize(glm::dvec3(0.45 * unit(random), 0.45 * unit(random), 1));
        const CutScene plane = cut({takePlane(cameraOf(160, 160, 1.6), normal, 2)}, 3);
        const GpuScene scene(testDevice(), plane.blocks());
        scene::View view{cameraOf(600, 450, 0.5 + 0.3 * unit(random)),
                         poseAt({0.2 * unit(random), 0.2 * unit(random), 0.6 * unit(random)}, 0.3 * unit(random),
                                0.3 * unit(random))};
        EXPECT_EQ(coverage(drawOnce(scene, view, kMesh)), 1.0) << "view " << i;
    }
}

TEST_F(MeshTest, SkinsAreCutOut) {
    scene::DepthImage image = takePlane(cameraOf(64, 64, 1.0), {0, 0, 1}, 2);
    for (int y = 0; y < 64; ++y) {
        image.flags(20, y) |= scene::kSkinUpper | scene::kSkinLower;
        for (int x = 21; x < 64; ++x)
            image.disparity(x, y) = 1;
    }
    const CutScene cutScene = cut({image});
    const GpuScene scene(testDevice(), cutScene.blocks());
    // From the left the gap between the near right half and the far left half opens to... nothing that was
    // measured.
    const EyeImage drawn = drawOnce(scene, {image.camera, poseAt({0.2, 0, 0}, 0, 0)}, kMesh);
    int gaps = 0;
    for (int x = 0; x < 56; ++x)
        gaps += drawn.pixelClass(x, 32) == 0;
    EXPECT_GE(gaps, 3);
}

TEST_F(MeshTest, WhatIsInNoSquareIsPointsWhereAskedFor) {
    const LoneSamples lone{40, 60};
    const CutScene plane = cut({withLone(takePlane(cameraOf(100, 100, 1.5), {0, 0, 1}, 2), lone)});
    const GpuScene scene(testDevice(), plane.blocks());
    const scene::View view{cameraOf(150, 150, 1.5), {glm::dmat3(1.0), {0, 0, 0.2}}};
    const EyeImage samples = drawOnce(scene, view, {});
    for (const Warp warp : {Warp::mesh, Warp::adaptive}) {
        const EyeImage mesh = drawOnce(scene, view, {.warp = warp});
        expectMeshAndLone(drawOnce(scene, view, {.warp = warp, .drawsLone = true}), mesh, samples, lone);
    }
}

TEST_F(MeshTest, TilesWithoutAnySquareArePointsWhereAskedFor) {
    const CutScene plane = cut({withLone(takePlane(cameraOf(100, 100, 1.5), {0, 0, 1}, 2), {1, 100})});
    const GpuScene scene(testDevice(), plane.blocks());
    const scene::View view{cameraOf(150, 150, 1.5), {glm::dmat3(1.0), {0, 0, 0.2}}};
    const EyeImage samples = drawOnce(scene, view, {});
    EXPECT_GT(coverage(samples), 0.9);
    for (const Warp warp : {Warp::mesh, Warp::adaptive}) {
        EXPECT_EQ(coverage(drawOnce(scene, view, {.warp = warp})), 0);
        const EyeImage drawn = drawOnce(scene, view, {.warp = warp, .drawsLone = true});
        EXPECT_EQ(drawn.pixelClass, samples.pixelClass);
        EXPECT_EQ(drawn.colour, samples.colour);
    }
}

TEST_F(MeshTest, AWallOneCentimetreBeforeTheEyeFillsTheScreen) {
    const CutScene plane = cut({takePlane(cameraOf(64, 64, 1.5), {0, 0, 1}, 2)});
    const GpuScene scene(testDevice(), plane.blocks());
    const EyeImage drawn = drawOnce(scene, {cameraOf(640, 480, 1.5), {glm::dmat3(1.0), {0.013, 0.007, 1.99}}}, kMesh);
    EXPECT_EQ(coverage(drawn), 1.0);
    for (const float depth : drawn.depthMetres.pixels())
        ASSERT_NEAR(depth, 0.01, 1e-5);
}

TEST_F(MeshTest, ASurfaceIsSeenFromBehind) {
    const CutScene plane = cut({takePlane(cameraOf(64, 64, 1.5), {0, 0, 1}, 2)});
    const GpuScene scene(testDevice(), plane.blocks());
    const double half = std::acos(-1.0);
    EXPECT_EQ(coverage(drawOnce(scene, {cameraOf(200, 150, 1.0), poseAt({0, 0, 3}, half, 0)}, kMesh)), 1.0);
}

TEST_F(MeshTest, TheSameBytesEveryTimeAndOnAnyNumberOfThreads) {
    const CutScene room = roomFromWithin(100, 16);
    const GpuScene scene(testDevice(), room.blocks());
    const auto [left, right] = scene::eyesOf(cameraOf(200, 150, 1.5), poseAt({0.5, 0, 0.2}, 0.4, 0.1), 0.06);
    std::vector<std::vector<EyeImage>> drawn;
    for (const std::size_t threads : {1u, 2u, 2u}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        drawn.push_back(drawOnce(scene, std::array{left, right}, kMesh));
    }
    for (const std::vector<EyeImage>& images : drawn)
        for (std::size_t eye = 0; eye < 2; ++eye)
            EXPECT_TRUE(isSame(images[eye], drawn[0][eye]));
    EXPECT_FALSE(isSame(drawn[0][0], drawn[0][1]));
}

} // namespace
} // namespace render
