// Composition by confidence: of two scans of a surface the better sampled one is shown.
#include "scene/footprint.h"
#include "scene/warp.h"

#include "tests/scene/known_scenes.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace scene {
namespace {

/// What stands painted on the wall z = 4, fine enough that a coarse image loses some of it. x and y in metres.
Rgb8 paintAt(double x, double y) {
    const auto wave = [](double phase) { return static_cast<std::uint8_t>(std::lround(128 + 100 * std::sin(phase))); };
    return {wave(40 * x), wave(40 * y), wave(25 * (x + y))};
}

/// What a camera at a place, looking straight at the wall, takes of it; the range is off by up to noise of it.
DepthImage takeWall(const Camera& camera, const glm::dvec3& at, double noise, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> off(-noise, noise);
    DepthImage image =
        imageOf(camera, {glm::dmat3(1.0), at}, [&](double, double) { return 1 / ((4 - at.z) * (1 + off(random))); });
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x)
            image.colour(x, y) = paintAt(at.x + (x + 0.5 - camera.cx) / camera.fx * (4 - at.z),
                                         at.y + (y + 0.5 - camera.cy) / camera.fy * (4 - at.z));
    return image;
}

struct Picture {
    double psnr = 0;
    int covered = 0;
};

/// The wall taken by a coarse camera from 4 m and a fine one from 1.5 m, against the wall itself.
Picture drawWall(void (*warp)(std::span<const TileBlock>, const View&, const WarpOptions&, ZBuffer&),
                 const PreferenceOptions& preference) {
    const Camera camera{240, 180, 200, 200, 120, 90};
    const DepthImage images[2] = {takeWall(camera, {0, 0, 0}, 0.003, 1), takeWall(camera, {0.1, 0, 2.5}, 0.003, 2)};
    const TileSet sets[2] = {cutIntoTiles(images[0]), cutIntoTiles(images[1])};
    std::vector<TileBlock> blocks;
    for (int i = 0; i < 2; ++i)
        blocks.push_back(lend(sets[i], camera, images[i].worldFromCamera));
    const View eye{{200, 150, 300, 300, 100, 75}, {glm::dmat3(1.0), {0.05, 0, 1.5}}};
    ZBuffer zBuffer(eye.camera.width, eye.camera.height, 0);
    warp(blocks, eye, {.preference = preference, .maxFootprint = 6, .maxSplat = 6}, zBuffer);
    const EyeImage seen = resolve(zBuffer);
    double sum = 0;
    Picture picture;
    for (int y = 0; y < eye.camera.height; ++y)
        for (int x = 0; x < eye.camera.width; ++x) {
            if (seen.pixelClass(x, y) != 1) continue;
            ++picture.covered;
            const Rgb8 truth = paintAt(0.05 + (x + 0.5 - 100) / 300 * 2.5, (y + 0.5 - 75) / 300 * 2.5);
            const Rgb8 there = seen.colour(x, y);
            sum += std::pow(there.r - truth.r, 2) + std::pow(there.g - truth.g, 2) + std::pow(there.b - truth.b, 2);
        }
    picture.psnr = 10 * std::log10(255.0 * 255.0 * 3 * picture.covered / sum);
    return picture;
}

TEST(Confidence, TheBetterSampledScanIsShownWhereTwoOverlap) {
    for (const auto warp : {warpPoints, warpMesh, warpSplats}) {
        const Picture nearest = drawWall(warp, {.nearBaseline = 0});
        const Picture best = drawWall(warp, {.nearBaseline = 0, .areaLevels = 2});
        EXPECT_EQ(best.covered, 200 * 150);
        EXPECT_EQ(nearest.covered, 200 * 150);
        if (warp == warpPoints) {
            // What points of the coarse scan cover gives way to those of the fine one in plain order, too.
            EXPECT_GT(nearest.psnr, 32) << "decibels";
            EXPECT_GT(best.psnr, nearest.psnr);
        } else {
            EXPECT_GT(best.psnr, nearest.psnr + 2) << "decibels";
        }
        std::printf("plain z %.2f dB, by confidence %.2f dB\n", nearest.psnr, best.psnr);
    }
}

TEST(Confidence, ASurfaceInFrontIsStillInFront) {
    const Camera camera = smallCamera();
    // Coarse (taken from afar) but a metre before what was taken finely.
    const DepthImage far =
        imageOf(camera, {glm::dmat3(1.0), {0, 0, -3}}, [&](double, double) { return 1 / 5.0; }, {250, 0, 0});
    const DepthImage near =
        imageOf(camera, {glm::dmat3(1.0), {0, 0, 2}}, [&](double, double) { return 1.0; }, {0, 0, 250});
    const TileSet sets[2] = {cutIntoTiles(far), cutIntoTiles(near)};
    const TileBlock blocks[2] = {lend(sets[0], camera, far.worldFromCamera),
                                 lend(sets[1], camera, near.worldFromCamera)};
    const View eye{{40, 30, 60, 60, 20, 15}, {}};
    ZBuffer zBuffer(40, 30, 0);
    warpMesh(blocks, eye, {.preference = {.nearBaseline = 0, .areaLevels = 2}}, zBuffer);
    const EyeImage seen = resolve(zBuffer);
    for (const Rgb8& colour : seen.colour.pixels())
        ASSERT_EQ(colour, (Rgb8{250, 0, 0}));
    EXPECT_NEAR(seen.depthMetres(20, 15), 2, 1e-3) << "the depth that was measured";
}

TEST(Confidence, LevelsGrowWithAreaUpToABound) {
    const PreferenceOptions options{.areaLevels = 2, .maxAreaLevels = 24};
    EXPECT_EQ(withArea(3, 0.1, options), 3);
    EXPECT_EQ(withArea(3, 1, options), 5);
    EXPECT_EQ(withArea(3, 4, options), 11);
    EXPECT_EQ(withArea(3, 1e9, options), 27);
    EXPECT_EQ(withArea(60, 1e9, options), kMaxOrderLevel);
    EXPECT_EQ(withArea(3, 1e9, {.areaLevels = 0}), 3);
}

TEST(Confidence, AreaIsThatOfAProjectedPixel) {
    const Camera source{100, 100, 80, 80, 50, 50};
    const View eye{{100, 100, 160, 160, 50, 50}, {glm::dmat3(1.0), {0, 0, 1}}};
    // 2 m before the camera and 1 m before the eye, twice as long a lens: 4 x 4 pixels.
    const glm::dmat4 c = eyeImageFromSourceImage(eye, source, Pose{});
    EXPECT_NEAR(sampleAreaInEye(c, {{50, 50, 0.5}, {50, 50, 0.5}}), 16, 1e-9);
    EXPECT_TRUE(std::isinf(sampleAreaInEye(c, {{50, 50, 2}, {50, 50, 2}}))) << "behind the eye";
}

} // namespace
} // namespace scene
