// Quadratic splats: circles whose depth falls off from their centres.
#include "render/shaders/shared/splat.h"

#include "scene/footprint.h"
#include "scene/warp.h"
#include "tests/render/test_device.h"
#include "tests/render/test_scenes.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace render {
namespace {

class SplatsTest : public RenderTest {};

TEST(SplatMath, DepthFallsOffQuadraticallyUpToTheRim) {
    const float perRadius2 = 1.0f / 9.0f;
    EXPECT_EQ(splatDisparity(0.5f, vec2(0, 0), perRadius2), 0.5f);
    EXPECT_NEAR(splatDisparity(0.5f, vec2(1.5f, 0), perRadius2), 0.5f * (1 - kSplatFalloff / 4), 1e-7f);
    EXPECT_NEAR(splatDisparity(0.5f, vec2(0, -2.999f), perRadius2), 0.5f * (1 - kSplatFalloff), 1e-5f);
    EXPECT_LT(splatDisparity(0.5f, vec2(2.2f, 2.2f), perRadius2), 0.0f);
    EXPECT_EQ(splatDisparity(0.0f, vec2(1, 0), perRadius2), 0.0f) << "sky stays sky";
}

TEST(SplatMath, TheRadiusIsThePapersWhereFocalLengthsAreAlike) {
    const scene::Camera camera = cameraOf(300, 200, 1.1);
    const scene::View eye{camera, poseAt({0.2, 0.1, 0.7}, 0.3, 0.1)};
    const glm::dmat4 c = scene::eyeImageFromSourceImage(eye, camera, poseAt({}, 0, 0));
    const glm::dvec3 sample(140, 90, 0.5);
    const glm::dvec4 h = c * glm::dvec4(sample.x, sample.y, 1, sample.z);
    const double papers = std::sqrt(0.5) * std::cbrt(std::abs(glm::determinant(glm::dmat3(c)))) / h.z;
    ASSERT_GT(papers, 0.8);
    EXPECT_NEAR(static_cast<double>(scene::splatRadiusOf(c, {sample, sample}, 1, 100)) / papers, 1, 1e-6);
}

TEST(SplatMath, TheRadiusGrowsWithTheFocalLengthWithinItsBounds) {
    const scene::Camera camera = cameraOf(300, 200, 1.1);
    scene::Camera longer = camera;
    longer.fx *= 5, longer.fy *= 5;
    const glm::dvec3 sample(140, 90, 0.5);
    const scene::SampleBox box{sample, sample};
    const glm::dmat4 same = scene::eyeImageFromSourceImage({camera, {}}, camera, {});
    const glm::dmat4 fiveTimes = scene::eyeImageFromSourceImage({longer, {}}, camera, {});
    EXPECT_EQ(scene::splatRadiusOf(same, box, 1, 9), scene::kLeastSplat);
    EXPECT_NEAR(scene::splatRadiusOf(fiveTimes, box, 1, 9), 5 * scene::kLeastSplat, 1e-5f);
    EXPECT_EQ(scene::splatRadiusOf(fiveTimes, box, 1, 2), 2.0f);
    EXPECT_EQ(scene::splatRadiusOf(fiveTimes, box, 0.01, 9), scene::kLeastSplat);
    const glm::dmat4 behind = scene::eyeImageFromSourceImage({camera, poseAt({0, 0, 3}, 0, 0)}, camera, {});
    EXPECT_EQ(scene::splatRadiusOf(behind, box, 1, 9), 9.0f);
}

TEST(SplatMath, EveryPixelOfASplatIsAmongThoseItsSideTakes) {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> place(0, 20), size(scene::kLeastSplat, 6);
    for (int i = 0; i < 5000; ++i) {
        const float position = place(random), radius = size(random);
        const auto first = static_cast<int>(firstOfSplat(position, radius));
        const int end = first + splatSideOf(radius);
        for (int x = -10; x < 30; ++x)
            ASSERT_TRUE(std::abs(static_cast<float>(x) + 0.5f - position) > radius - 1e-5f || (x >= first && x < end))
                << x << " of " << position << " +- " << radius;
    }
}

TEST(SplatMath, TheLeastSplatCoversItsPixelAndOneBesideItAtMost) {
    const float radius = scene::kLeastSplat, perRadius2 = 1 / (radius * radius);
    ASSERT_TRUE(coversTwoAtMost(radius));
    EXPECT_FALSE(coversTwoAtMost(radius * 1.0001f));
    std::mt19937 random(4);
    std::uniform_real_distribution<float> anywhere(-3, 700);
    const std::vector<float> special{0, 0.25f, 0.5f, 0.75f, 0.49999997f, 0.0001f, 0.9999f};
    int beside = 0, corners = 0;
    const auto expectTwo = [&](const vec2& position) {
        const ivec2 own(floor(position));
        const vec2 offset = vec2(own) + 0.5f - position;
        const ivec2 next = nextOfSplat(offset);
        ASSERT_EQ(std::abs(next.x) + std::abs(next.y), 1);
        ASSERT_GE(splatDisparity(1, offset, perRadius2), 0) << "its own, at " << position.x << ", " << position.y;
        for (int y = -2; y <= 2; ++y)
            for (int x = -2; x <= 2; ++x) {
                const ivec2 step(x, y);
                if (step == ivec2(0) || splatDisparity(1, offset + vec2(step), perRadius2) < 0) continue;
                if (std::min(std::abs(offset.x), std::abs(offset.y)) > 0.499f) {
                    ++corners; // where four meet any two will do
                } else {
                    ASSERT_EQ(step, next) << position.x << ", " << position.y << " covers " << x << ", " << y;
                    ++beside;
                }
            }
    };
    for (int i = 0; i < 200'000; ++i)
        ASSERT_NO_FATAL_FAILURE(expectTwo({anywhere(random), anywhere(random)}));
    for (const float x : special)
        for (const float y : special)
            for (const float whole : {0.f, 3.f, 511.f})
                ASSERT_NO_FATAL_FAILURE(expectTwo({whole + x, whole + y}));
    EXPECT_GT(beside, 100'000) << "57 of a hundred";
    EXPECT_GT(corners, 0);
}

TEST_F(SplatsTest, PicturesAreThoseOfTheProcessor) {
    const CutScene room = roomInAllTiers();
    const auto blocks = room.blocks();
    const GpuScene scene(testDevice(), blocks);
    Painter paint(scene, cameraOf(220, 160, 0.9));
    for (const auto& [nearBaseline, areaLevels] : {std::pair{0.f, 0.f}, {0.2f, 0.f}, {0.2f, 3.f}, {0.f, 3.f}})
        for (const double x : {-0.2, 0.1, 0.3}) {
            const scene::View eye{cameraOf(220, 160, 0.9), poseAt({x, 0.02, 0.6}, 0.3 * x, 0.1)};
            Quality quality{.warp = Warp::splats};
            quality.preference.nearBaseline = nearBaseline;
            quality.preference.areaLevels = areaLevels;
            const scene::WarpOptions options{.preference = quality.preference, .maxSplat = quality.maxSplat};
            scene::ZBuffer zBuffer(eye.camera.width, eye.camera.height, 0);
            scene::warpSplats(blocks, eye, options, zBuffer);
            const scene::EyeImage truth = scene::resolve(zBuffer);
            const EyeImage drawn = paint(eye, quality);
            int different = 0;
            double worstDepth = 0;
            for (std::size_t i = 0; i < drawn.colour.size(); ++i) {
                const bool isAlike = drawn.colour.pixels()[i] == truth.colour.pixels()[i] &&
                                     drawn.pixelClass.pixels()[i] == truth.pixelClass.pixels()[i];
                different += !isAlike;
                const double depth = static_cast<double>(truth.depthMetres.pixels()[i]);
                if (isAlike && depth > 0)
                    worstDepth =
                        std::max(worstDepth, std::abs(static_cast<double>(drawn.depthMetres.pixels()[i]) / depth - 1));
            }
            EXPECT_LE(different, 0.001 * static_cast<double>(drawn.colour.size()))
                << "eye at " << x << ", near baseline " << nearBaseline << ", levels " << areaLevels;
            EXPECT_LE(worstDepth, 1e-5);
        }
}

TEST_F(SplatsTest, FromItsOwnCameraAnImageComesBackExactly) {
    const scene::DepthImage image = takeRoom(cameraOf(150, 110, 1.2), poseAt({0.4, -0.2, 0.3}, 0.7, 0.1));
    const CutScene cutScene = cut({image});
    const EyeImage drawn = drawOnce(GpuScene(testDevice(), cutScene.blocks()), {image.camera, image.worldFromCamera},
                                    {.warp = Warp::splats});
    EXPECT_EQ(drawn.colour, image.colour);
}

/// Nearer, turned and with another focal length: what stands across the camera's axis has no holes.
TEST_F(SplatsTest, NoHolesOpenInAPlane) {
    const CutScene plane = cut({takePlane(cameraOf(300, 300, 2.0), {0, 0, 1}, 2)});
    const GpuScene scene(testDevice(), plane.blocks());
    std::mt19937 random(51);
    std::uniform_real_distribution<double> unit(-1, 1);
    Painter paint(scene, cameraOf(120, 120, 1.0));
    double leastCoverage = 1;
    for (int i = 0; i < 20; ++i) {
        const double roll = 3 * unit(random);
        const glm::dmat3 rolled(glm::dvec3(std::cos(roll), std::sin(roll), 0),
                                glm::dvec3(-std::sin(roll), std::cos(roll), 0), glm::dvec3(0, 0, 1));
        const scene::View view{
            cameraOf(120, 120, i % 2 == 0 ? 1.0 : 0.5),
            {poseAt({}, 0.1 * unit(random), 0.1 * unit(random)).rotation * rolled, {0, 0, 0.5 * unit(random)}}};
        EXPECT_EQ(coverage(paint(view, {.warp = Warp::splats, .maxSplat = 16, .splatScale = 1.1})), 1.0) << i;
        leastCoverage =
            std::min(leastCoverage, coverage(paint(view, {.warp = Warp::splats, .maxSplat = 1, .splatScale = 0.1})));
    }
    EXPECT_LT(leastCoverage, 0.9) << "what smaller splats leave open";
}

} // namespace
} // namespace render
