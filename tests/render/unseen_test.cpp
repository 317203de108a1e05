// Rays through the unseen: the device against the shared code on the processor.

#include "render/post/coverage_texels.h"
#include "render/post/unseen.h"
#include "scene/coverage.h"
#include "scene/coverage_levels.h"
#include "tests/render/test_device.h"
#include "tests/render/test_scenes.h"
#include "tests/render/tree_texels.h"

#include <array>
#include <cmath>

namespace render {
namespace {

/// Half of the room of takeRoom, as if nobody had looked behind x = 0.6, nor into a corner above.
scene::Coverage roomCoverage(const glm::dvec3& offset = glm::dvec3(0)) {
    scene::Coverage coverage;
    coverage.cornerInWorld = offset - glm::dvec3(8);
    coverage.edgeMetres = 16;
    const auto kindAt = [](const glm::dvec3& least, double edge) {
        const auto isIn = [&](const glm::dvec3& p) { return p.x >= 0.6 || (p.y < -0.3 && p.z > 1.1); };
        int inside = 0;
        for (int corner = 0; corner < 8; ++corner)
            inside += isIn(least + edge * glm::dvec3(corner & 1, corner / 2 & 1, corner / 4)) ? 1 : 0;
        return inside;
    };
    struct Open {
        std::size_t index;
        glm::dvec3 least;
        double edge;
        int level;
    };
    coverage.nodes.resize(1);
    std::vector<Open> open{{0, glm::dvec3(-8), 16, 1}};
    for (std::size_t i = 0; i < open.size(); ++i) {
        const Open at = open[i];
        scene::CoverageNode node;
        node.firstChild = static_cast<std::uint32_t>(coverage.nodes.size());
        const double cell = at.edge / 4;
        for (int bit = 0; bit < 64; ++bit) {
            const glm::dvec3 least = at.least + cell * glm::dvec3(bit % 4, bit / 4 % 4, bit / 16);
            const int inside = kindAt(least, cell);
            // The finest cells in a part of it alone: there would be too many.
            const bool isFine = glm::all(glm::lessThan(glm::abs(least - glm::dvec3(0.6, 0, 0.8)), glm::dvec3(0.5)));
            if (inside != 0 && inside != 8 && at.level < (isFine ? 7 : 5)) {
                node.children |= scene::coverageMask(bit);
                open.push_back({coverage.nodes.size(), least, cell, at.level + 1});
                coverage.nodes.emplace_back();
            } else if (inside > 4) {
                node.unseen |= scene::coverageMask(bit);
            }
        }
        if (node.children == 0) node.firstChild = 0;
        coverage.nodes[at.index] = node;
    }
    return coverage;
}

class Unseen : public RenderTest {
  protected:
    std::vector<EyeImage> draw(std::span<const scene::View> eyes, const scene::Coverage* coverage,
                               const Quality& quality = {}, const glm::dvec3& offset = glm::dvec3(0)) {
        const scene::Camera camera = cameraOf(200, 150, 1.4);
        const CutScene room = cut({takeRoom(camera, poseAt(glm::dvec3(0), 0.1, 0), offset)});
        const auto blocks = room.blocks();
        const GpuScene scene(testDevice(), blocks);
        std::optional<GpuCoverage> onDevice;
        if (coverage != nullptr) onDevice.emplace(testDevice(), *coverage);
        Renderer renderer(testDevice(), scene, eyes[0].camera.width, eyes[0].camera.height,
                          static_cast<int>(eyes.size()), onDevice ? &*onDevice : nullptr);
        renderer.draw(eyes, quality);
        stats_ = renderer.finish();
        return renderer.readBack();
    }
    static std::array<scene::View, 2> eyesAt(const glm::dvec3& offset = glm::dvec3(0)) {
        const auto [left, right] =
            scene::eyesOf(cameraOf(160, 120, 1.2), poseAt(offset + glm::dvec3(-0.3, 0.05, 0.1), 0.2, -0.05), 0.063);
        return {left, right};
    }
    FrameStats stats_;
};

/// Of bricks within bricks, of bricks alone, and of none: shaders are made for each.
class UnseenOfLevels : public Unseen, public testing::WithParamInterface<int> {};

INSTANTIATE_TEST_SUITE_P(Levels, UnseenOfLevels, testing::Values(7, 5, 4));

TEST_P(UnseenOfLevels, PixelsAreThoseOfTheProcessor) {
    const scene::Coverage coverage = scene::coarsened(roomCoverage(), GetParam());
    ASSERT_EQ(scene::levelsOf(coverage), GetParam());
    const TreeTexels texels(coverage);
    ASSERT_EQ(texels.made.brickLevels, std::min(GetParam() - 4, 2));
    // No whole number of blocks, and not looking through the middle of the picture.
    auto eyes = eyesAt();
    for (scene::View& eye : eyes) {
        eye.camera.width = 157, eye.camera.height = 117;
        eye.camera.cx -= 21, eye.camera.cy += 13;
    }
    for (const double pocket : {0.0, 1.0}) {
        Quality quality;
        quality.unseenPocketMetres = pocket;
        const std::vector<EyeImage> drawn = draw(eyes, &coverage, quality);
        const std::vector<EyeImage> before = draw(eyes, nullptr, quality);
        for (std::size_t eye = 0; eye < 2; ++eye) {
            const UnseenConstants c =
                unseenConstants(coverage.cornerInWorld, coverage.edgeMetres, texels.grid(), eyes[eye], quality);
            int differ = 0, unseen = 0, kept = 0;
            for (int y = 0; y < 117; ++y)
                for (int x = 0; x < 157; ++x) {
                    const float end = unseenEnd(c, before[eye].pixelClass(x, y), before[eye].depthMetres(x, y));
                    const vec3 direction = rayOf(c, static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
                    const UnseenHit hit = walkToUnseen(texels, vec3(c.eye), direction, c.eye.w, end, vec2(0.0f));
                    ++(hit.isUnseen ? unseen : kept);
                    if (!hit.isUnseen) {
                        differ += drawn[eye].pixelClass(x, y) != before[eye].pixelClass(x, y) ||
                                  drawn[eye].colour(x, y) != before[eye].colour(x, y) ||
                                  drawn[eye].depthMetres(x, y) != before[eye].depthMetres(x, y);
                        continue;
                    }
                    const uint colour = unseenColour(c, direction, hit.depth);
                    const scene::Rgb8 shown = drawn[eye].colour(x, y);
                    const bool isAlike = std::abs(int(colour & 255u) - shown.r) <= 1 &&
                                         std::abs(int(colour >> 8 & 255u) - shown.g) <= 1 &&
                                         std::abs(int(colour >> 16 & 255u) - shown.b) <= 1;
                    const bool isThere = hit.depth >= kRayInfinity
                                             ? std::isinf(drawn[eye].depthMetres(x, y))
                                             : std::abs(drawn[eye].depthMetres(x, y) / hit.depth - 1) < 1e-4f;
                    differ += !isAlike || !isThere || drawn[eye].pixelClass(x, y) != 3;
                }
            EXPECT_LE(differ, 4) << "eye " << eye; // at faces of cells, by rounding
            EXPECT_GT(unseen, 3000);
            EXPECT_GT(kept, 3000);
        }
    }
}

TEST_F(Unseen, BothEyesSeeOnePatternInTheWorld) {
    const scene::Coverage coverage = roomCoverage();
    const auto eyes = eyesAt();
    const Quality quality;
    const std::vector<EyeImage> drawn = draw(eyes, &coverage, quality);
    const UnseenConstants right =
        unseenConstants(coverage.cornerInWorld, coverage.edgeMetres, coverageTexels(coverage).grid, eyes[1], quality);
    int compared = 0, worst = 0, light = 0;
    for (int y = 0; y < 120; ++y)
        for (int x = 0; x < 160; ++x) {
            if (drawn[0].pixelClass(x, y) != 3 || std::isinf(drawn[0].depthMetres(x, y))) continue;
            const double z = double{drawn[0].depthMetres(x, y)};
            const glm::dvec3 p = eyes[0].worldFromEye * (z * scene::rayThrough(eyes[0].camera, x + 0.5, y + 0.5));
            const glm::dvec3 inRight = inverse(eyes[1].worldFromEye) * p;
            const glm::dvec2 at = project(eyes[1].camera, inRight);
            const uint there = unseenColour(right, rayOf(right, static_cast<float>(at.x), static_cast<float>(at.y)),
                                            static_cast<float>(inRight.z));
            worst = std::max(worst, std::abs(int(there & 255u) - drawn[0].colour(x, y).r));
            light += drawn[0].colour(x, y).r > 42 ? 1 : 0;
            ++compared;
        }
    EXPECT_GT(compared, 3000);
    EXPECT_LE(worst, 2);
    EXPECT_GT(light, compared / 4);
    EXPECT_LT(light, 3 * compared / 4);
}

TEST_F(Unseen, HiddenItIsAsIfNothingWereKnown) {
    const scene::Coverage coverage = roomCoverage();
    Quality quality;
    quality.showUnseen = false;
    const auto eyes = eyesAt();
    const std::vector<EyeImage> hidden = draw(eyes, &coverage, quality);
    for (const StepTime& time : stats_.gpu)
        EXPECT_STRNE(time.step, "unseen");
    const std::vector<EyeImage> without = draw(eyes, nullptr);
    for (std::size_t eye = 0; eye < 2; ++eye)
        EXPECT_TRUE(isSame(hidden[eye], without[eye]));
}

TEST_F(Unseen, FarFromTheOriginItLooksTheSame) {
    const glm::dvec3 offset(1 << 23, -(1 << 24), 1 << 22);
    const scene::Coverage here = roomCoverage(), there = roomCoverage(offset);
    const auto near = draw(eyesAt(), &here);
    const auto far = draw(eyesAt(offset), &there, {}, offset);
    for (std::size_t eye = 0; eye < 2; ++eye) {
        int differ = 0;
        for (std::size_t i = 0; i < near[eye].pixelClass.size(); ++i)
            differ += near[eye].pixelClass.pixels()[i] != far[eye].pixelClass.pixels()[i] ||
                      std::abs(near[eye].colour.pixels()[i].r - far[eye].colour.pixels()[i].r) > 1;
        EXPECT_LE(differ, 20);
    }
}

} // namespace
} // namespace render
