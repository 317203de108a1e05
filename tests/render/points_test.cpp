#include "tests/render/lone_samples.h"
#include "tests/render/reference.h"
#include "tests/render/test_device.h"
#include "tests/render/test_scenes.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

namespace render {
namespace {

class PointsTest : public RenderTest {};

scene::View eyeAt(const glm::dvec3& p, double yaw, double pitch) {
    return {cameraOf(200, 150, 1.5), poseAt(p, yaw, pitch)};
}

struct Agreement {
    double coverage = 0, colour = 0,
           depth = 0; ///< shares of pixels: covered alike; same colour and depth where covered
};

Agreement compare(const EyeImage& image, const ReferenceImage& truth) {
    double covered = 0, alike = 0, sameColour = 0, sameDepth = 0;
    for (int y = 0; y < image.colour.height(); ++y)
        for (int x = 0; x < image.colour.width(); ++x) {
            const bool isCovered = image.pixelClass(x, y) != 0, shouldBe = truth.disparity(x, y) >= 0;
            alike += isCovered == shouldBe;
            if (!isCovered || !shouldBe) continue;
            ++covered;
            sameColour += image.colour(x, y) == truth.colour(x, y);
            sameDepth += std::abs(image.depthMetres(x, y) * truth.disparity(x, y) - 1) < 1e-5;
        }
    return {alike / double(image.colour.size()), sameColour / covered, sameDepth / covered};
}

TEST_F(PointsTest, AgreeWithTheReference) {
    const CutScene room = roomFromWithin(160);
    const auto blocks = room.blocks();
    const GpuScene scene(testDevice(), blocks);
    std::mt19937 random(31);
    std::uniform_real_distribution<double> unit(-1, 1);
    Painter paint(scene, eyeAt({}, 0, 0).camera);
    for (int i = 0; i < 6; ++i)
        for (const int maxFootprint : {1, 4}) {
            const scene::View view =
                eyeAt({unit(random), 0.5 * unit(random), unit(random)}, 3 * unit(random), 0.5 * unit(random));
            Quality quality;
            quality.maxFootprint = maxFootprint;
            const Agreement agreement = compare(paint(view, quality), referencePoints(blocks, view, maxFootprint));
            EXPECT_GE(agreement.coverage, 0.999) << "view " << i << " footprint " << maxFootprint;
            EXPECT_GE(agreement.colour, 0.999) << "view " << i << " footprint " << maxFootprint;
            EXPECT_GE(agreement.depth, 0.999) << "view " << i << " footprint " << maxFootprint;
        }
}

TEST_F(PointsTest, FromItsOwnCameraAnImageComesBackExactly) {
    scene::DepthImage image = takeRoom(cameraOf(150, 110, 1.2), poseAt({0.4, -0.2, 0.3}, 0.7, 0.1));
    const CutScene cutScene = cut({image});
    const GpuScene scene(testDevice(), cutScene.blocks());
    for (const int maxFootprint : {1, 4}) {
        Quality quality;
        quality.maxFootprint = maxFootprint;
        const EyeImage drawn = drawOnce(scene, {image.camera, image.worldFromCamera}, quality);
        EXPECT_EQ(drawn.colour, image.colour);
        EXPECT_EQ(coverage(drawn), 1.0);
        for (std::size_t i = 0; i < image.disparity.size(); ++i)
            ASSERT_NEAR(drawn.depthMetres.pixels()[i] * image.disparity.pixels()[i], 1, 6e-6);
    }
}

TEST_F(PointsTest, OnlyKeptSamplesAreDrawn) {
    scene::DepthImage image = takePlane(cameraOf(64, 64, 1.0), {0, 0, 1}, 2);
    for (int x = 0; x < 64; ++x) {
        image.flags(x, 10) |= scene::kNoSurface;
        image.flags(x, 20) |= scene::kRedundant;
        image.flags(x, 30) |= scene::kFloating;
    }
    const CutScene cutScene = cut({image});
    const EyeImage drawn = drawOnce(GpuScene(testDevice(), cutScene.blocks()), {image.camera, {}}, {});
    for (int y = 0; y < 64; ++y)
        EXPECT_EQ(drawn.pixelClass(5, y), y == 10 || y == 20 || y == 30 ? 0 : 1) << y;
}

TEST_F(PointsTest, FootprintsCloseTheHolesOfAMagnifiedPlane) {
    const CutScene plane = cut({takePlane(cameraOf(100, 100, 1.5), {0, 0, 1}, 2)});
    const GpuScene scene(testDevice(), plane.blocks());
    const scene::View nearer{cameraOf(200, 200, 1.5), {glm::dmat3(1.0), {0, 0, 0.7}}};
    Quality quality;
    quality.maxFootprint = 1;
    EXPECT_LT(coverage(drawOnce(scene, nearer, quality)), 0.5);
    quality.maxFootprint = 8;
    EXPECT_EQ(coverage(drawOnce(scene, nearer, quality)), 1.0);
    quality.footprintScale = 0.25;
    EXPECT_LT(coverage(drawOnce(scene, nearer, quality)), 0.5);
}

/// Of wide squares that lie over one another each pixel shows the sample that stands in it: not the one beside it that
/// is nearer to the eye.
TEST_F(PointsTest, SquaresOfASlantedSurfaceGiveWayToThePixelsOfOthers) {
    const CutScene plane = cut({takePlane(cameraOf(100, 100, 1.5), {0.15, 0.06, 1}, 2)});
    const GpuScene scene(testDevice(), plane.blocks());
    const scene::View own{cameraOf(100, 100, 1.5), {}};
    const EyeImage narrow = drawOnce(scene, own, {.maxFootprint = 1});
    const EyeImage wide = drawOnce(scene, own, {.maxFootprint = 4, .footprintScale = 4});
    EXPECT_EQ(coverage(wide), 1.0);
    EXPECT_TRUE(wide.colour == narrow.colour && wide.depthMetres == narrow.depthMetres);
}

TEST_F(PointsTest, SquaresCloseWhatIsTooNearForPoints) {
    const CutScene plane = cut({takePlane(cameraOf(100, 100, 1.5), {0.2, 0, 1}, 2)});
    const GpuScene scene(testDevice(), plane.blocks());
    const scene::View nearer{cameraOf(300, 300, 1.5), {glm::dmat3(1.0), {0, 0, 1.3}}};
    for (const Warp warp : {Warp::points, Warp::splats}) {
        Quality quality{.warp = warp, .maxFootprint = 4, .maxSplat = 2};
        EXPECT_LT(coverage(drawOnce(scene, nearer, quality)), 0.9);
        quality.drawsSquaresNear = true;
        const EyeImage closed = drawOnce(scene, nearer, quality);
        EXPECT_EQ(coverage(closed), 1.0);
        // Surfaces stand where the mesh has them, or within a sample's width of it.
        const EyeImage mesh = drawOnce(scene, nearer, {.warp = Warp::mesh});
        for (int y = 0; y < 300; ++y)
            for (int x = 0; x < 300; ++x)
                ASSERT_NEAR(closed.depthMetres(x, y) / mesh.depthMetres(x, y), 1, 0.01) << x << " " << y;
        // Where they are narrow enough, nothing is drawn besides.
        const scene::View afar{cameraOf(300, 300, 1.5), {glm::dmat3(1.0), {0, 0, -0.5}}};
        Quality without = quality;
        without.drawsSquaresNear = false;
        const EyeImage a = drawOnce(scene, afar, quality), b = drawOnce(scene, afar, without);
        EXPECT_TRUE(a.colour == b.colour && a.depthMetres == b.depthMetres);
    }
}

/// Of a tile that holds three columns a difference in disparity over all its width says little.
TEST_F(PointsTest, SquaresCloseTheFewColumnsThatAreKeptOfAGlance) {
    const glm::dvec3 normal = glm::normalize(glm::dvec3(0.98, 0, 0.2));
    scene::DepthImage image = takePlane(cameraOf(200, 200, 1.5), normal, 1);
    for (int y = 0; y < 200; ++y)
        for (int x = 0; x < 200; ++x)
            if (x < 100 || x > 102) image.flags(x, y) |= scene::kRedundant;
    const CutScene plane = cut({image});
    const GpuScene scene(testDevice(), plane.blocks());
    // Three metres squarely before the middle of what was seen there.
    const glm::dvec3 middle = glm::dvec3(0, 0, 1 / normal.z);
    const scene::View square{cameraOf(300, 300, 1.5), poseAt(middle - 3.0 * normal, std::atan2(normal.x, normal.z), 0)};
    for (const Warp warp : {Warp::points, Warp::splats}) {
        Quality quality{.warp = warp, .maxFootprint = 4, .maxSplat = 2};
        const auto gapsInTheMiddleRow = [&] {
            const EyeImage drawn = drawOnce(scene, square, quality);
            const auto row = drawn.pixelClass.row(150);
            const auto isDrawn = [](std::uint8_t pixelClass) { return pixelClass != 0; };
            const auto first = std::find_if(row.begin(), row.end(), isDrawn);
            const auto last = std::find_if(row.rbegin(), row.rend(), isDrawn).base();
            EXPECT_GT(last - first, 20) << "columns stand a dozen pixels apart";
            return std::count(first, last, 0);
        };
        EXPECT_GT(gapsInTheMiddleRow(), 10);
        quality.drawsSquaresNear = true;
        EXPECT_EQ(gapsInTheMiddleRow(), 0);
    }
}

TEST_F(PointsTest, WhatIsInNoSquareIsStillThereWhereSquaresAreDrawn) {
    const LoneSamples lone{40, 60};
    const CutScene plane = cut({withLone(takePlane(cameraOf(100, 100, 1.5), {0, 0, 1}, 2), lone)});
    const GpuScene scene(testDevice(), plane.blocks());
    const scene::View nearer{cameraOf(300, 300, 1.5), {glm::dmat3(1.0), {0, 0, 1.3}}};
    const EyeImage mesh = drawOnce(scene, nearer, {.warp = Warp::mesh});
    for (const Warp warp : {Warp::points, Warp::splats}) {
        Quality quality{.warp = warp, .maxFootprint = 4, .maxSplat = 2};
        const EyeImage samples = drawOnce(scene, nearer, quality);
        quality.drawsSquaresNear = true;
        expectMeshAndLone(drawOnce(scene, nearer, quality), mesh, samples, lone);
    }
}

/// Turned by any angle, at any distance: what stands across the camera's axis has no holes.
TEST_F(PointsTest, NoHolesOpenInATurnedPlane) {
    const CutScene plane = cut({takePlane(cameraOf(300, 300, 2.0), {0, 0, 1}, 2)});
    const GpuScene scene(testDevice(), plane.blocks());
    std::mt19937 random(51);
    std::uniform_real_distribution<double> unit(-1, 1);
    Painter paint(scene, cameraOf(120, 120, 1.0));
    for (int i = 0; i < 20; ++i) {
        const double roll = 3 * unit(random);
        const glm::dmat3 rolled(glm::dvec3(std::cos(roll), std::sin(roll), 0),
                                glm::dvec3(-std::sin(roll), std::cos(roll), 0), glm::dvec3(0, 0, 1));
        const scene::View view{
            cameraOf(120, 120, 1.0),
            {poseAt({}, 0.2 * unit(random), 0.2 * unit(random)).rotation * rolled, {0, 0, 0.5 * unit(random)}}};
        EXPECT_EQ(coverage(paint(view, {.maxFootprint = 8})), 1.0) << i;
    }
}

TEST_F(PointsTest, TheSameBytesEveryTimeAndOnAnyNumberOfThreads) {
    const CutScene room = roomFromWithin(160, 16);
    const GpuScene scene(testDevice(), room.blocks());
    const std::array views{eyeAt({0.5, 0, 0.2}, 0.4, 0.1), eyeAt({0.56, 0, 0.2}, 0.4, 0.1)};
    std::vector<std::vector<EyeImage>> drawn;
    for (const std::size_t threads : {1u, 2u, 2u}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        drawn.push_back(drawOnce(scene, views, {}));
    }
    for (const std::vector<EyeImage>& images : drawn)
        for (std::size_t eye = 0; eye < 2; ++eye)
            EXPECT_TRUE(isSame(images[eye], drawn[0][eye]));
}

TEST_F(PointsTest, EyesSeeAPlaneWithTheRightParallax) {
    // Disparity times the focal length in pixels times the distance of the eyes: 96 px . m / 4 m . 0.25 m = 6
    // px.
    const scene::Camera camera{160, 120, 96, 96, 80, 60};
    const CutScene plane = cut({takePlane(camera, {0, 0, 1}, 4)});
    const GpuScene scene(testDevice(), plane.blocks());
    const auto [left, right] = scene::eyesOf(camera, {}, 0.25);
    const std::vector<EyeImage> drawn = drawOnce(scene, std::array{left, right}, {});
    for (int y = 0; y < 120; ++y)
        for (int x = 3; x + 3 < 160; ++x) {
            ASSERT_EQ(drawn[0].colour(x, y).r, x - 3);
            ASSERT_EQ(drawn[1].colour(x - 3, y).r, x);
            ASSERT_NEAR(drawn[1].depthMetres(x - 3, y), 4, 1e-5);
        }
}

TEST_F(PointsTest, FramesFollowOneAnotherWithoutATrace) {
    const CutScene room = roomFromWithin(100);
    const GpuScene scene(testDevice(), room.blocks());
    const scene::View first = eyeAt({0, 0, 0}, 0, 0), second = eyeAt({0.5, 0.2, 0}, 2, 0.2);
    Renderer renderer(testDevice(), scene, 200, 150, 1);
    for (int i = 0; i < 5; ++i)
        renderer.draw(std::span(i % 2 == 0 ? &second : &first, 1), {});
    renderer.draw(std::span(&first, 1), {});
    EXPECT_TRUE(isSame(renderer.readBack()[0], drawOnce(scene, first, {})));
    EXPECT_TRUE(isSame(renderer.readBack()[0], drawOnce(scene, first, {}))) << "reading back twice";
    renderer.draw(std::span(&second, 1), {});
    EXPECT_TRUE(isSame(renderer.readBack()[0], drawOnce(scene, second, {})));
}

TEST_F(PointsTest, StatisticsAddUp) {
    const CutScene room = roomFromWithin(100, 16);
    const GpuScene scene(testDevice(), room.blocks());
    const std::array views{eyeAt({0, 0, 0}, 0.4, 0), eyeAt({0.06, 0, 0}, 0.4, 0)};
    Renderer renderer(testDevice(), scene, 200, 150, 2);
    const FrameStats first = renderer.draw(views, {});
    EXPECT_EQ(first.frame, 0u);
    EXPECT_TRUE(first.gpu.empty());
    for (const EyeCounts& eye : first.eyes) {
        EXPECT_EQ(eye.tilesTested, scene.tiles().size());
        EXPECT_EQ(eye.tilesRejected + eye.tilesDrawn, eye.tilesTested);
        EXPECT_GT(eye.tilesRejected, eye.tilesTested / 2);
        EXPECT_LE(eye.samplesDrawn, pointsOf(room) / 2);
        EXPECT_GT(eye.samplesDrawn, pointsOf(room) / 10);
    }
    const FrameStats finished = renderer.finish();
    EXPECT_EQ(finished.gpuFrame, finished.frame);
    // clear, warp and resolve of two eyes
    EXPECT_EQ(finished.gpu.size(), testDevice().hasTimestamps() ? 6u : 0u);
    renderer.draw(views, {});
    EXPECT_EQ(renderer.draw(views, {}).gpuFrame, 0u);
}

} // namespace
} // namespace render
