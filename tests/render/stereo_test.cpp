// Both eyes in one pass: the pictures of a pass for each, to the byte, whatever only one of them sees.

#include "tests/render/studio.h"
#include "tests/render/test_device.h"
#include "tests/render/test_scenes.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

namespace render {
namespace {

class StereoTest : public RenderTest {};

const scene::Camera kEye = cameraOf(160, 120, 1.5);

using Eyes = std::array<scene::View, 2>;

Eyes eyesAt(const glm::dvec3& p, double yaw, double pitch, double apart = 0.063) {
    const auto [left, right] = scene::eyesOf(kEye, poseAt(p, yaw, pitch), apart);
    return {left, right};
}

/// Close together and far apart; turned outward, so that much is seen by one alone; and back to back.
std::vector<Eyes> pairsOfEyes() {
    return {eyesAt({0.3, 0, 0.2}, 0.4, 0.1),
            eyesAt({-0.5, 0.2, -0.4}, 2.5, -0.2),
            eyesAt({0, 0, 0}, -1.2, 0, 0.6),
            {{{kEye, poseAt({0.1, 0, 0}, 0.5, 0)}, {kEye, poseAt({0.2, 0, 0}, 1.4, 0.1)}}},
            {{{kEye, poseAt({0, 0, 0}, 0, 0)}, {kEye, poseAt({0.06, 0, 0}, 3.1, 0)}}}};
}

/// With tiers, levels, and the same room again behind its walls: there is something that hides and something hidden.
class Rooms {
  public:
    Rooms() : near_(roomInAllTiers()), faces_(cutInLevels(roomFromWithin(128).images)) {
        std::vector<scene::TileBlock> blocks = near_.blocks();
        for (int away = 0; away < 6; ++away)
            for (scene::TileBlock block : faces_.blocks()) {
                block.worldFromCamera.translation += glm::dvec3(3.0 * away, 0.2 * away, 7.0 * away);
                blocks.push_back(block);
            }
        // Small pages: several runs of each kind.
        scene_.emplace(testDevice(), blocks, std::size_t{1} << 20);
    }
    const GpuScene& scene() const { return *scene_; }

  private:
    CutScene near_, faces_;
    std::optional<GpuScene> scene_;
};

std::vector<Way> waysInOnePass() {
    std::vector<Way> all;
    for (const Warp warp : {Warp::points, Warp::splats}) {
        const std::string name = warp == Warp::points ? "points" : "splats";
        const Quality plain = qualityOf(warp);
        all.push_back({name, plain});
        all.push_back({name + ", plain z order, one pixel", plain});
        all.back().quality.preference.nearBaseline = 0, all.back().quality.maxFootprint = 1;
        all.push_back({name + ", coarse", plain});
        all.back().quality.samplePixels = 1.5, all.back().quality.farSamplePixels = 3;
        all.push_back({name + ", filled", plain});
        all.back().quality.holes.radius = 4;
        all.push_back({name + ", larger, hidden ones, too", plain});
        all.back().quality.resolutionScale = 1.5, all.back().quality.leavesOutHidden = false;
        all.push_back({name + ", interpolated", plain});
        all.back().quality.interpolatesSamples = true;
        all.push_back({name + ", interpolated, smaller, filled", plain});
        all.back().quality.interpolatesSamples = true, all.back().quality.holes.radius = 4;
        all.back().quality.resolutionScale = 0.7;
        all.push_back({name + ", blended", plain});
        all.back().quality.isBlended = true;
    }
    return all;
}

Quality inOnePass(Quality quality) {
    quality.isOnePass = true;
    return quality;
}

TEST_F(StereoTest, OnePassDrawsTheSamePicturesOnAnyNumberOfThreads) {
    const Rooms rooms;
    Renderer renderer(testDevice(), rooms.scene(), kEye.width, kEye.height, 2);
    std::size_t differ = 0;
    const std::vector<Eyes> eyes = pairsOfEyes();
    for (const Way& way : waysInOnePass())
        for (std::size_t i = 0; i < eyes.size(); ++i) {
            const FrameStats apart = renderer.draw(eyes[i], way.quality);
            EXPECT_FALSE(apart.isOnePass);
            const std::vector<EyeImage> expected = renderer.readBack();
            for (const std::size_t threads : {1u, 2u}) {
                const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
                const FrameStats together = renderer.draw(eyes[i], inOnePass(way.quality));
                EXPECT_TRUE(together.isOnePass) << way.name;
                const std::vector<EyeImage> drawn = renderer.readBack();
                for (std::size_t eye = 0; eye < 2; ++eye) {
                    EXPECT_TRUE(isSame(drawn[eye], expected[eye])) << way.name << ", eyes " << i << ", eye " << eye;
                    EXPECT_EQ(together.eyes[eye].tilesDrawn, apart.eyes[eye].tilesDrawn);
                    EXPECT_GT(coverage(drawn[eye]), 0.5) << way.name << ", eyes " << i;
                }
            }
            differ += apart.eyes[0].tilesDrawn != apart.eyes[1].tilesDrawn ? 1 : 0;
        }
    EXPECT_GT(differ, 0u) << "there were tiles that one eye alone draws";
}

TEST_F(StereoTest, FramesOfBothKindsFollowOneAnother) {
    const Rooms rooms;
    Renderer renderer(testDevice(), rooms.scene(), kEye.width, kEye.height, 2);
    const std::vector<Eyes> eyes = pairsOfEyes();
    const Quality apart = qualityOf(Warp::points), together = inOnePass(apart);
    renderer.draw(eyes[1], apart);
    const std::vector<EyeImage> expected = renderer.readBack();
    for (const std::size_t frames : {1u, 2u, 3u, 4u}) {
        for (std::size_t i = 0; i < frames; ++i)
            renderer.draw(eyes[i % 3], i % 2 == 0 ? together : apart);
        renderer.draw(eyes[1], frames % 2 == 0 ? together : apart);
        const std::vector<EyeImage> drawn = renderer.readBack();
        for (std::size_t eye = 0; eye < 2; ++eye)
            EXPECT_TRUE(isSame(drawn[eye], expected[eye])) << frames << " frames before";
    }
}

TEST_F(StereoTest, WhatHasNoSuchPassIsDrawnEyeByEye) {
    const CutScene room = roomAllAround();
    const GpuScene scene(testDevice(), room.blocks());
    Renderer both(testDevice(), scene, kEye.width, kEye.height, 2),
        one(testDevice(), scene, kEye.width, kEye.height, 1);
    const Eyes eyes = eyesAt({0.3, 0, 0.2}, 0.4, 0.1);
    for (const Warp warp : {Warp::mesh, Warp::adaptive}) {
        const Quality asked = inOnePass(qualityOf(warp));
        EXPECT_NE(whyNotInOnePass(testDevice(), asked, 2), "");
        both.draw(eyes, qualityOf(warp));
        const std::vector<EyeImage> expected = both.readBack();
        EXPECT_FALSE(both.draw(eyes, asked).isOnePass);
        for (std::size_t eye = 0; eye < 2; ++eye)
            EXPECT_TRUE(isSame(both.readBack()[eye], expected[eye]));
    }
    const Quality points = inOnePass(qualityOf(Warp::points));
    EXPECT_EQ(whyNotInOnePass(testDevice(), points, 2), "");
    EXPECT_NE(whyNotInOnePass(testDevice(), points, 1), "");
    EXPECT_FALSE(one.draw({eyes.data(), 1}, points).isOnePass);
}

struct OnePass {
    DrawList list;
    std::uint32_t tileOf(std::uint32_t draw) const { return list.chosen[list.order[draw]].tile; }
};

OnePass seenBy(const GpuScene& scene, const scene::View& view, const Quality& quality) {
    const std::vector<SourceView> sources = sourceViewsOf(scene.images(), view, quality);
    std::vector<ImagePlanes> planes;
    for (std::size_t k = 0; k < sources.size(); ++k)
        planes.push_back(planesOf(sources[k].eyeImageFromSource, kEye.width, kEye.height, 4, scene.images()[k].extent));
    VisibleTiles visible{numbersOf(scene.pieces()), {}, {}};
    cull(
        scene.bounds(), scene.pieces(), [&](const TilePiece& piece) { return planes[piece.image]; }, visible);
    OnePass seen;
    chooseDraws(scene.index(), scene.places(), sources, visible, quality, seen.list, kEye.width * kEye.height, 0);
    return seen;
}

TEST_F(StereoTest, EveryDrawOfEitherEyeStandsInOnePair) {
    const Rooms rooms;
    const GpuScene& scene = rooms.scene();
    PairList pairs; // kept: nothing of one frame may be left in the next
    std::uint32_t shared = 0, alone = 0, batches = 0;
    for (const Eyes& eyes : pairsOfEyes()) {
        const OnePass left = seenBy(scene, eyes[0], qualityOf(Warp::points)),
                      right = seenBy(scene, eyes[1], qualityOf(Warp::points));
        ASSERT_TRUE(uniteDraws(scene.tiles().size(), left.list, right.list, false, pairs));
        std::vector<int> drawnLeft(left.list.tiles, 0), drawnRight(right.list.tiles, 0);
        std::uint32_t next = 0, batch = 0, run = 0;
        for (const DrawRun& of : pairs.runs) {
            EXPECT_EQ(of.first, next);
            EXPECT_GE(of.batch, batch);
            run = of.batch != batch ? 0 : run;
            for (; next < of.first + of.count; ++next) {
                const PairDraw& pair = pairs.pairs[next];
                EXPECT_EQ(pair.run, run);
                const bool drawsLeft = pair.left != kNoDraw, drawsRight = pair.right != kNoDraw;
                ASSERT_TRUE(drawsLeft || drawsRight);
                if (drawsLeft) {
                    ++drawnLeft[pair.left];
                    EXPECT_EQ(left.list.chosen[left.list.order[pair.left]].batch, of.batch);
                    EXPECT_EQ(scene.places()[scene.tiles()[left.tileOf(pair.left)].chunk].page, of.page);
                }
                if (drawsRight) {
                    ++drawnRight[pair.right];
                    EXPECT_EQ(right.list.chosen[right.list.order[pair.right]].batch, of.batch);
                }
                if (drawsLeft && drawsRight) {
                    EXPECT_EQ(left.tileOf(pair.left), right.tileOf(pair.right));
                }
                ++(drawsLeft && drawsRight ? shared : alone);
            }
            batch = of.batch, ++run;
            batches = std::max(batches, batch + 1);
        }
        EXPECT_EQ(next, pairs.pairs.size());
        for (const std::vector<int>& drawn : {drawnLeft, drawnRight})
            EXPECT_TRUE(std::all_of(drawn.begin(), drawn.end(), [](int times) { return times == 1; }));
    }
    EXPECT_GT(shared, 0u);
    EXPECT_GT(alone, 0u);
    EXPECT_GT(batches, 1u);

    const OnePass surfaces = seenBy(scene, pairsOfEyes()[0][0], qualityOf(Warp::mesh));
    EXPECT_FALSE(uniteDraws(scene.tiles().size(), surfaces.list, surfaces.list, true, pairs));
    const scene::View nearby{kEye, poseAt({0, 0, 1.8}, 0, 0)};
    Quality widest = qualityOf(Warp::points);
    widest.maxFootprint = 64;
    const OnePass wide = seenBy(scene, nearby, widest);
    EXPECT_TRUE(uniteDraws(scene.tiles().size(), wide.list, wide.list, true, pairs));
    EXPECT_FALSE(uniteDraws(scene.tiles().size(), wide.list, wide.list, false, pairs)) << "processors deal them out";
}

} // namespace
} // namespace render
