// Frames that stand: what is not warped again looks as if it were.

#include "tests/render/studio.h"
#include "tests/scene/random_coverage.h"

#include "render/gpu_polygons.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace render {
namespace {

constexpr int kStandingWidth = 160, kStandingHeight = 120;

scene::View eyeAt(double x, double yaw) {
    return {cameraOf(kStandingWidth, kStandingHeight, 1.5), poseAt({x, 0.1, 0}, yaw, 0)};
}

scene::Coverage halfUnseen(std::uint32_t seed) {
    scene::Coverage coverage = scene::randomCoverage(seed, 4);
    coverage.cornerInWorld = glm::dvec3(-4);
    coverage.edgeMetres = 8;
    return coverage;
}

bool hasWarped(const FrameStats& stats) {
    return std::ranges::any_of(stats.gpu, [](const StepTime& time) { return std::string_view(time.step) == "warp"; });
}

class Standing : public RenderTest {
  protected:
    CutScene cut_ = roomAllAround();
    GpuScene scene_{testDevice(), cut_.blocks()};
    GpuCoverage coverage_{testDevice(), halfUnseen(1)}, other_{testDevice(), halfUnseen(2)};
    /// In the middle of the room, before some of it.
    GpuPolygons polygons_{
        testDevice(), rectangle({-0.6f, -0.3f, 1}, {0.8f, 0, 0}, {0, 0.6f, 0}, {0.7f, 0.2f, 0.1f}), {0, -1, 0}};

    struct Drawn {
        bool isStanding = false, hasWarped = false;
        std::vector<EyeImage> pictures;
    };
    static Drawn draw(Renderer& renderer, std::span<const scene::View> eyes, const Quality& quality,
                      const Overlay* overlay = nullptr) {
        const bool isStanding = renderer.draw(eyes, quality, {}, overlay).isStanding;
        return {isStanding, hasWarped(renderer.finish()), renderer.readBack()};
    }
    /// By a renderer to which every frame is new.
    std::vector<EyeImage> warped(std::span<const scene::View> eyes, const Quality& quality, const GpuCoverage* coverage,
                                 const Overlay* overlay = nullptr) {
        Renderer renderer(testDevice(), scene_, kStandingWidth, kStandingHeight, 2, coverage, &polygons_);
        return draw(renderer, eyes, quality, overlay).pictures;
    }
    static void expectSame(const std::vector<EyeImage>& a, const std::vector<EyeImage>& b, const std::string& what) {
        for (std::size_t eye = 0; eye < 2; ++eye)
            EXPECT_TRUE(isSame(a[eye], b[eye])) << what << ", eye " << eye;
    }
};

TEST_F(Standing, FramesLookAsIfTheyHadBeenWarpedAnew) {
    const std::array eyes{eyeAt(0, 0.3), eyeAt(0.06, 0.3)};
    Overlay overlay;
    overlay.segments.push_back({{-1, 0, 2}, {1, 0.2, 2}, {255, 0, 0}});
    for (const Way& way : ways()) {
        Renderer renderer(testDevice(), scene_, kStandingWidth, kStandingHeight, 2, &coverage_, &polygons_);
        renderer.letFramesStand(true);
        const Drawn first = draw(renderer, eyes, way.quality);
        EXPECT_FALSE(first.isStanding) << way.name;
        EXPECT_TRUE(first.hasWarped) << way.name;
        const std::vector<EyeImage> expected = warped(eyes, way.quality, &coverage_);
        for (int again = 0; again < 3; ++again) {
            const Drawn next = draw(renderer, eyes, way.quality);
            EXPECT_TRUE(next.isStanding) << way.name;
            EXPECT_FALSE(next.hasWarped) << way.name;
            expectSame(next.pictures, expected, way.name);
        }
        const Drawn lined = draw(renderer, eyes, way.quality, &overlay);
        EXPECT_TRUE(lined.isStanding) << way.name;
        expectSame(lined.pictures, warped(eyes, way.quality, &coverage_, &overlay), way.name + ", lines over it");
        EXPECT_FALSE(isSame(lined.pictures[0], expected[0])) << way.name;
        expectSame(draw(renderer, eyes, way.quality).pictures, expected, way.name + ", lines gone");
        renderer.useCoverage(&other_);
        const Drawn otherwise = draw(renderer, eyes, way.quality);
        EXPECT_TRUE(otherwise.isStanding) << way.name;
        expectSame(otherwise.pictures, warped(eyes, way.quality, &other_), way.name + ", other coverage");
        EXPECT_FALSE(isSame(otherwise.pictures[0], expected[0])) << way.name;
        renderer.useCoverage(nullptr);
        expectSame(draw(renderer, eyes, way.quality).pictures, warped(eyes, way.quality, nullptr),
                   way.name + ", no coverage");
    }
}

TEST_F(Standing, WarmingUpLeavesNothingBehind) {
    const std::array eyes{eyeAt(0, 0.3), eyeAt(0.06, 0.3)};
    std::vector<Quality> qualities;
    for (const Way& way : ways())
        qualities.push_back(way.quality);
    for (const Quality& first : {qualities.front(), qualities.back()}) {
        Renderer renderer(testDevice(), scene_, kStandingWidth, kStandingHeight, 2, &coverage_, &polygons_);
        renderer.letFramesStand(true);
        renderer.warmUp(eyes, qualities);
        EXPECT_EQ(renderer.frames(), 0u);
        const FrameStats stats = renderer.draw(eyes, first);
        EXPECT_EQ(stats.frame, 0u);
        EXPECT_TRUE(stats.gpu.empty()) << "times of frames that nobody asked for";
        EXPECT_FALSE(stats.isStanding);
        expectSame(renderer.readBack(), warped(eyes, first, &coverage_), "warmed up");
    }
}

TEST_F(Standing, WhatChangesIsWarpedAnew) {
    const std::array eyes{eyeAt(0, 0.3), eyeAt(0.06, 0.3)}, moved{eyeAt(0, 0.3), eyeAt(0.0601, 0.3)};
    Renderer renderer(testDevice(), scene_, kStandingWidth, kStandingHeight, 2, &coverage_, &polygons_);
    draw(renderer, eyes, {});
    EXPECT_FALSE(draw(renderer, eyes, {}).isStanding) << "it was not let to";
    renderer.letFramesStand(true);
    EXPECT_TRUE(draw(renderer, eyes, {}).isStanding);

    const Drawn there = draw(renderer, moved, {});
    EXPECT_FALSE(there.isStanding) << "one eye has moved";
    expectSame(there.pictures, warped(moved, {}, &coverage_), "moved");
    EXPECT_FALSE(draw(renderer, eyes, {}).isStanding) << "and back";

    for (const Way& way : ways()) {
        if (way.quality == Quality{}) continue;
        const Drawn other = draw(renderer, eyes, way.quality);
        EXPECT_FALSE(other.isStanding) << way.name;
        expectSame(other.pictures, warped(eyes, way.quality, &coverage_), way.name);
    }
    Quality together;
    together.isOnePass = true;
    const std::vector<EyeImage> apart = warped(eyes, {}, &coverage_);
    for (const bool isStanding : {false, true}) {
        const Drawn inOnePass = draw(renderer, eyes, together);
        EXPECT_EQ(inOnePass.isStanding, isStanding);
        expectSame(inOnePass.pictures, apart, "in one pass");
    }

    const std::vector<float> none(scene_.capturedImages(), 0.0f);
    scene_.showOnly({none, none});
    const Drawn empty = draw(renderer, eyes, together);
    EXPECT_FALSE(empty.isStanding) << "other images are shown";
    scene_.showOnly({none, none});
    EXPECT_TRUE(draw(renderer, eyes, together).isStanding) << "none has changed";
}

} // namespace
} // namespace render
