// The blended warp: the mean of all samples at the front surface.
#include "render/shaders/shared/blend.h"

#include "scene/blend.h"
#include "tests/render/test_device.h"
#include "tests/render/test_scenes.h"

#include <tbb/global_control.h>

#include <cmath>
#include <random>

namespace render {
namespace {

class BlendTest : public RenderTest {};

constexpr Quality kBlended{.warp = Warp::mesh, .preference = {.nearBaseline = 0.2f}, .isBlended = true};

TEST(BlendMath, TheMeanOfWhatWasAdded) {
    const uint colours[2] = {0x1020ffu, 0xff6010u};
    const uint counts[2] = {30000u, 10000u};
    uvec2 redGreen(0), blueWeight(0);
    for (int i = 0; i < 2; ++i) {
        redGreen += redGreenOf(colours[i], counts[i]);
        blueWeight += blueWeightOf(colours[i], counts[i]);
    }
    const uint mean = meanColourOf(redGreen, blueWeight);
    EXPECT_EQ(mean & 255u, 195u); // (3 * 255 + 16) / 4
    EXPECT_EQ(mean >> 8 & 255u, 48u);
    EXPECT_EQ(mean >> 16, 76u); // (3 * 16 + 255) / 4 = 75.75
}

TEST(BlendMath, ASpotFallsOffFromItsCentreAndEnds) {
    const vec4 spot(0.25f, 0.0f, 1.0f, 10000.0f); // 2 pixels to the sides, 1 up and down
    EXPECT_EQ(countOf(spot, vec2(0, 0)), 10000u);
    EXPECT_EQ(countOf(spot, vec2(1, 0)), 5625u);
    EXPECT_EQ(countOf(spot, vec2(1, 0)), countOf(spot, vec2(0, 0.5f)));
    EXPECT_EQ(countOf(spot, vec2(2.1f, 0)), 0u);
    EXPECT_EQ(countOf(spot, vec2(0, -1.1f)), 0u);
}

TEST(BlendMath, EveryPixelThatASpotReachesIsTouched) {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> place(-5, 25), reach(0, 6);
    for (int i = 0; i < 2000; ++i) {
        const float position = place(random), r = reach(random);
        const ivec2 touched = touchedBy(position, r, 20.0f);
        for (int x = 0; x < 20; ++x)
            if (std::abs(static_cast<float>(x) + 0.5f - position) < r - 1e-5f) {
                ASSERT_TRUE(x >= touched.x && x < touched.y) << x << " of " << position << " +- " << r;
            }
        ASSERT_GE(touched.x, 0);
        ASSERT_LE(touched.y, 20);
    }
}

TEST(BlendMath, OnlyTheFrontSurfaceOfItsClass) {
    const float scale = 1.0f + 21.0f / 63.0f;
    const uvec2 key = packKey(0.5f / scale, 0, (21u << 2) | kClassSeen); // 2 m, pushed back by level 21
    EXPECT_NEAR(eyeDisparityOf(key), 0.5f, 1e-6f);
    EXPECT_TRUE(isAtFront(0.52f, kClassSeen, key, 0.05f));
    EXPECT_FALSE(isAtFront(0.53f, kClassSeen, key, 0.05f));
    EXPECT_FALSE(isAtFront(0.47f, kClassSeen, key, 0.05f));
    EXPECT_FALSE(isAtFront(0.5f, kClassFilled, key, 0.05f));
    EXPECT_TRUE(isAtFront(0.0f, kClassSeen, packKey(0.0f, 0, kClassSeen), 0.05f)) << "sky means sky";
    EXPECT_FALSE(isAtFront(0.01f, kClassSeen, packKey(0.0f, 0, kClassSeen), 0.05f));
}

/// Share of the covered pixels that differ from the processor's by class, or by more than a step of a channel.
double differenceFromProcessor(const CutScene& room, const scene::View& eye, const Quality& quality) {
    const auto blocks = room.blocks();
    const scene::WarpOptions options{.preference = quality.preference, .maxFootprint = quality.maxFootprint};
    scene::ZBuffer zBuffer(eye.camera.width, eye.camera.height, 0);
    (quality.warp == Warp::points ? scene::warpPoints : scene::warpMesh)(blocks, eye, options, zBuffer);
    const scene::EyeImage truth = scene::resolve(zBuffer, scene::warpBlend(blocks, eye, quality.blend, zBuffer));
    const EyeImage drawn = drawOnce(GpuScene(testDevice(), blocks), eye, quality);
    double different = 0, covered = 0;
    for (std::size_t i = 0; i < drawn.colour.size(); ++i) {
        const scene::Rgb8 a = drawn.colour.pixels()[i], b = truth.colour.pixels()[i];
        covered += truth.pixelClass.pixels()[i] != 0;
        different += std::abs(a.r - b.r) > 1 || std::abs(a.g - b.g) > 1 || std::abs(a.b - b.b) > 1 ||
                     drawn.pixelClass.pixels()[i] != truth.pixelClass.pixels()[i];
    }
    EXPECT_GT(covered, 0.9 * static_cast<double>(drawn.colour.size()));
    return different / covered;
}

TEST_F(BlendTest, PicturesAreThoseOfTheProcessor) {
    const CutScene tiers = roomInAllTiers(), base = cut(roomFromThreePlaces());
    for (const double x : {-0.2, 0.1, 0.3}) {
        const scene::View eye{cameraOf(220, 160, 1.3), poseAt({x, 0.02, 0.15}, 0.3 * x, 0.1)};
        Quality quality = kBlended;
        // The processor's mesh and ours may choose differently between tiers that mean one depth.
        EXPECT_LE(differenceFromProcessor(base, eye, quality), 0.001) << "mesh, eye at " << x;
        quality.warp = Warp::points;
        quality.maxFootprint = 3;
        EXPECT_LE(differenceFromProcessor(tiers, eye, quality), 0.001) << "points, eye at " << x;
    }
}

TEST_F(BlendTest, DepthAndClassStayThoseOfTheFrontSurface) {
    const CutScene room = roomInAllTiers();
    const GpuScene scene(testDevice(), room.blocks());
    const scene::View eye{cameraOf(220, 160, 1.3), poseAt({0.1, 0.02, 0.15}, 0.1, 0.1)};
    Quality quality = kBlended;
    const EyeImage blended = drawOnce(scene, eye, quality);
    quality.isBlended = false;
    const EyeImage plain = drawOnce(scene, eye, quality);
    EXPECT_EQ(blended.depthMetres, plain.depthMetres);
    EXPECT_EQ(blended.pixelClass, plain.pixelClass);
    EXPECT_NE(blended.colour, plain.colour);
}

TEST_F(BlendTest, FromItsOwnCameraAnImageComesBackExactly) {
    const scene::DepthImage image = takeRoom(cameraOf(150, 110, 1.2), poseAt({0.4, -0.2, 0.3}, 0.7, 0.1));
    const CutScene cutScene = cut({image});
    Quality quality = kBlended;
    quality.warp = Warp::points;
    const EyeImage drawn =
        drawOnce(GpuScene(testDevice(), cutScene.blocks()), {image.camera, image.worldFromCamera}, quality);
    EXPECT_EQ(drawn.colour, image.colour);
}

TEST_F(BlendTest, NoiseOfManyImagesAveragesOut) {
    constexpr int kGrey = 120, kNoise = 30;
    std::mt19937 random(17);
    std::uniform_int_distribution<int> noise(-kNoise, kNoise);
    std::vector<scene::DepthImage> images;
    for (int i = 0; i < 12; ++i) {
        scene::DepthImage image = takePlane(cameraOf(100, 80, 1.2), {0, 0, 1}, 2);
        image.worldFromCamera.translation.x = 0.003 * i;
        for (scene::Rgb8& colour : image.colour.pixels()) {
            const auto grey = static_cast<std::uint8_t>(kGrey + noise(random));
            colour = {grey, grey, grey};
        }
        images.push_back(std::move(image));
    }
    const CutScene planes = cut(std::move(images));
    const GpuScene scene(testDevice(), planes.blocks());
    const scene::View eye{cameraOf(80, 60, 1.0), poseAt({0.0165, 0, 0}, 0, 0)};
    const auto errorOf = [&](bool isBlended) {
        Quality quality = kBlended;
        quality.isBlended = isBlended;
        const EyeImage drawn = drawOnce(scene, eye, quality);
        double sum = 0;
        for (const scene::Rgb8& colour : drawn.colour.pixels())
            sum += std::pow(colour.r - kGrey, 2);
        return std::sqrt(sum / static_cast<double>(drawn.colour.size()));
    };
    EXPECT_GT(errorOf(false), 7.0) << "what one image's mesh leaves of a deviation of 17";
    EXPECT_LT(errorOf(true), 0.5 * errorOf(false));
}

/// A red wall before a blue one; an image taken from far aside sees the blue one where the eye sees the red.
TEST_F(BlendTest, SurfacesBehindTheFrontOneDoNotShineThrough) {
    const scene::Camera camera = cameraOf(120, 90, 1.2);
    const auto wall = [&](double metres, double aside, const scene::Rgb8& colour) {
        scene::DepthImage image = takePlane(camera, {0, 0, 1}, metres);
        image.worldFromCamera.translation.x = aside;
        for (scene::Rgb8& pixel : image.colour.pixels())
            pixel = colour;
        return image;
    };
    const CutScene walls = cut({wall(2, 0, {200, 0, 0}), wall(3, 0.5, {0, 0, 200})});
    const GpuScene scene(testDevice(), walls.blocks());
    const scene::View eye{cameraOf(100, 70, 0.8), poseAt({0.02, 0, 0}, 0, 0)};
    const EyeImage drawn = drawOnce(scene, eye, kBlended);
    for (const scene::Rgb8& colour : drawn.colour.pixels())
        ASSERT_EQ(colour, (scene::Rgb8{200, 0, 0}));
}

TEST_F(BlendTest, TheSameBytesEveryTimeAndOnAnyNumberOfThreads) {
    const CutScene room = roomInAllTiers();
    const GpuScene scene(testDevice(), room.blocks());
    const auto [left, right] = scene::eyesOf(cameraOf(220, 160, 1.3), poseAt({0.1, 0.02, 0.15}, 0.1, 0.1), 0.063);
    const std::array views{left, right};
    std::vector<std::vector<EyeImage>> drawn;
    for (const std::size_t threads : {1u, 2u, 2u}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        drawn.push_back(drawOnce(scene, views, kBlended));
        for (int eye = 0; eye < 2; ++eye)
            EXPECT_TRUE(isSame(drawn.back()[static_cast<std::size_t>(eye)], drawn[0][static_cast<std::size_t>(eye)]))
                << threads << " threads, eye " << eye;
    }
}

} // namespace
} // namespace render
