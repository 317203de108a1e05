// Images that unseen space hides are not drawn, and nobody can tell.

#include "render/post/unseen.h"
#include "render/shaders/shared/z_key.h"
#include "scene/refine/cover.h"
#include "tests/render/test_device.h"
#include "tests/render/test_scenes.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <functional>
#include <memory>
#include <numbers>

namespace render {
namespace {

/// Two rooms with nothing between them, and what was observed from the middle of each.
struct TwoRooms {
    CutScene room = roomFromWithin(96);
    std::vector<scene::TileBlock> blocks;
    scene::Coverage coverage;
    glm::dvec3 other{0}; ///< the middle of the second, from that of the first
};

std::vector<scene::TileBlock> twice(std::vector<scene::TileBlock> blocks, const glm::dvec3& other) {
    const std::size_t count = blocks.size();
    for (std::size_t i = 0; i < count; ++i) {
        scene::TileBlock block = blocks[i];
        block.worldFromCamera.translation += other;
        block.samplesInWorld.least += other, block.samplesInWorld.most += other;
        blocks.push_back(block);
    }
    return blocks;
}

/// cubes: of coverage, from one room to the other.
TwoRooms twoRooms(int cubes) {
    TwoRooms rooms;
    scene::ImageStore store(rooms.room.images);
    scene::CoverFigures figures;
    const scene::Coverage part = scene::cover(store, {}, figures);
    rooms.other = glm::dvec3(cubes * part.edgeMetres, 0, 0);
    rooms.coverage =
        coverageManyTimes(part, {{0, 1, 1}, {cubes, 1, 1}}, part.cornerInWorld - part.edgeMetres * glm::dvec3(0, 1, 1));
    rooms.blocks = twice(rooms.room.blocks(), rooms.other);
    return rooms;
}

class BehindUnseen : public RenderTest {
  protected:
    struct Drawn {
        std::vector<EyeImage> images;
        std::uint32_t tiles = 0; ///< of both eyes
    };
    Drawn draw(Renderer& renderer, std::span<const scene::View> eyes, const Quality& quality) {
        renderer.draw(eyes, quality);
        const FrameStats stats = renderer.finish();
        return {renderer.readBack(), stats.eyes[0].tilesDrawn + stats.eyes[1].tilesDrawn};
    }
    static void expectSame(const std::vector<EyeImage>& a, const std::vector<EyeImage>& b, const std::string& where) {
        EXPECT_EQ(differing(a, b, where), 0) << where;
    }
    /// Pixels that are not the same. A crack within a surface through which hidden samples were drawn is one that
    /// nobody saw through; if they are left out, it is filled: no pixel may be another in another way.
    static int differing(const std::vector<EyeImage>& kept, const std::vector<EyeImage>& all,
                         const std::string& where) {
        int count = 0;
        for (std::size_t eye = 0; eye < kept.size(); ++eye)
            for (int y = 0; y < kept[eye].colour.height(); ++y)
                for (int x = 0; x < kept[eye].colour.width(); ++x) {
                    const EyeImage &a = kept[eye], &b = all[eye];
                    if (a.colour(x, y) == b.colour(x, y) && a.depthMetres(x, y) == b.depthMetres(x, y) &&
                        a.pixelClass(x, y) == b.pixelClass(x, y))
                        continue;
                    ++count;
                    EXPECT_EQ(a.pixelClass(x, y), kClassFilled) << where << ", eye " << eye << " " << x << " " << y;
                    EXPECT_EQ(b.pixelClass(x, y), kClassUnseen) << where << ", eye " << eye << " " << x << " " << y;
                }
        return count;
    }
    static int changed(const std::vector<EyeImage>& a, const std::vector<EyeImage>& b) {
        int count = 0;
        for (std::size_t eye = 0; eye < a.size(); ++eye)
            for (std::size_t i = 0; i < a[eye].colour.size(); ++i)
                count += a[eye].colour.pixels()[i] == b[eye].colour.pixels()[i] &&
                                 a[eye].depthMetres.pixels()[i] == b[eye].depthMetres.pixels()[i] &&
                                 a[eye].pixelClass.pixels()[i] == b[eye].pixelClass.pixels()[i]
                             ? 0
                             : 1;
        return count;
    }
    explicit BehindUnseen(int cubes = 2) : rooms_(twoRooms(cubes)) {}
    TwoRooms rooms_;
    GpuScene scene_{testDevice(), rooms_.blocks};
    GpuCoverage coverage_{testDevice(), rooms_.coverage};
    Renderer renderer_{testDevice(), scene_, 160, 120, 2, &coverage_};
};

TEST_F(BehindUnseen, WhatUnseenSpaceHidesIsLeftOutAndPicturesStayTheSame) {
    std::uint32_t kept = 0, all = 0;
    int filled = 0, unfilled = 0;
    for (const Warp warp : {Warp::points, Warp::splats, Warp::mesh, Warp::adaptive})
        for (const int radius : {0, 4}) {
            Quality quality, whole;
            quality.warp = warp, quality.holes.radius = radius;
            whole = quality;
            whole.leavesOutHidden = false;
            // In the first room, before its walls, in the second, and where nobody ever looked.
            const std::array<glm::dvec3, 5> places{glm::dvec3(0.2, 0.1, -0.1),
                                                   {3.6, 0.5, 2},
                                                   {-3.7, -0.9, -2.5},
                                                   rooms_.other + glm::dvec3(-1, 0, 0.4),
                                                   0.5 * rooms_.other};
            for (const glm::dvec3& place : places)
                for (int turn = 0; turn < 4; ++turn) {
                    const auto [left, right] = scene::eyesOf(
                        cameraOf(160, 120, 1.4), poseAt(place, 0.3 + turn * std::numbers::pi / 2, 0.1), 0.063);
                    const std::array eyes{left, right};
                    const Drawn drawn = draw(renderer_, eyes, quality), everything = draw(renderer_, eyes, whole);
                    const std::string where = std::to_string(static_cast<int>(warp)) + ", radius " +
                                              std::to_string(radius) + ", at " + std::to_string(place.x) + ", turned " +
                                              std::to_string(turn);
                    const int others = differing(drawn.images, everything.images, where);
                    (radius > 0 ? filled : unfilled) += others;
                    EXPECT_LE(drawn.tiles, everything.tiles);
                    kept += drawn.tiles, all += everything.tiles;
                }
        }
    EXPECT_EQ(unfilled, 0) << "where nothing is filled pictures are the same to the byte";
    EXPECT_LE(filled, 4 * 5 * 4) << "of three million pixels";
    EXPECT_LT(kept, 0.85 * all) << "nothing was hidden: this tests nothing";
}

/// The rooms' cubes side by side: the wall is as thick as their rims.
class BehindThinWalls : public BehindUnseen {
  protected:
    BehindThinWalls() : BehindUnseen(1) {}
};

TEST_F(BehindThinWalls, BlendingAndInterpolatingTakeNothingFromTheOtherRoom) {
    Quality interpolated, blended;
    interpolated.warp = Warp::points, interpolated.interpolatesSamples = true, interpolated.holes.radius = 4;
    interpolated.drawsSquaresNear = true, interpolated.samplePixels = 1;
    blended.warp = Warp::mesh, blended.isBlended = true, blended.holes.radius = 4;
    std::uint32_t kept = 0, all = 0;
    int others = 0;
    for (const Quality& quality : {interpolated, blended})
        for (const double scale : {1.0, 0.5}) {
            Quality hidden = quality, whole = quality;
            hidden.resolutionScale = whole.resolutionScale = scale;
            whole.leavesOutHidden = false;
            for (const glm::dvec3& place : {glm::dvec3(-2.5, 0.1, -0.1), {3.6, 0.5, 2}, {0.3, -0.9, -2.5}})
                for (int turn = 0; turn < 4; ++turn) {
                    const auto [left, right] = scene::eyesOf(
                        cameraOf(160, 120, 1.4), poseAt(place, 0.3 + turn * std::numbers::pi / 2, 0.1), 0.063);
                    const std::array eyes{left, right};
                    const Drawn drawn = draw(renderer_, eyes, hidden), everything = draw(renderer_, eyes, whole);
                    others += changed(drawn.images, everything.images);
                    kept += drawn.tiles, all += everything.tiles;
                }
        }
    EXPECT_EQ(others, 0);
    EXPECT_LT(kept, 0.85 * all) << "nothing was hidden: this tests nothing";
}

TEST_F(BehindUnseen, TheStreamBringsItLast) {
    const CutScene inLevels = cutInLevels(rooms_.room.images);
    const std::vector<scene::TileBlock> blocks = twice(inLevels.blocks(), rooms_.other);
    // Towards the other room, with the wall between; of one's own room nearly all is beside the picture.
    const scene::View eye{cameraOf(160, 120, 0.6), poseAt({-1, 0.1, 0.1}, std::numbers::pi / 2, 0)};
    SceneIndex index(blocks, 40000);
    index.findFiner();
    const CoarserChunks coarser = coarserChunksOf(index);
    scene::OpenWays ways;
    ASSERT_TRUE(ways.standAt(coverage_.openGrid(), std::array{eye.worldFromEye.translation}));
    const Quality quality;
    const std::vector<std::uint32_t> all = chunksWanted(index, coarser, {{&eye, 1}, quality, {}}),
                                     ordered = chunksWanted(index, coarser, {{&eye, 1}, quality, {}, &ways});
    const auto isOfOther = [&](std::uint32_t chunk) { return index.chunks[chunk].captured >= blocks.size() / 2; };
    EXPECT_EQ(ordered.size(), all.size()) << "nothing is forgotten";
    EXPECT_TRUE(std::is_partitioned(ordered.begin(), ordered.end(), std::not_fn(isOfOther)));
    EXPECT_FALSE(std::is_partitioned(all.begin(), all.end(), std::not_fn(isOfOther))) << "else this tests nothing";
    for (const auto& wanted : {all, ordered}) {
        std::vector<std::size_t> rank(index.chunks.size(), wanted.size());
        for (std::size_t i = 0; i < wanted.size(); ++i)
            rank[wanted[i]] = i;
        for (std::uint32_t chunk = 0; chunk < index.chunks.size(); ++chunk)
            for (const std::uint32_t standIn : coarser.of(chunk))
                EXPECT_TRUE(rank[chunk] == wanted.size() || rank[standIn] < rank[chunk]);
    }
}

TEST_F(BehindUnseen, TheStreamHasRoomForOnesOwnRoom) {
    const CutScene inLevels = cutInLevels(roomFromWithin(224).images);
    const std::vector<scene::TileBlock> blocks = twice(inLevels.blocks(), rooms_.other);
    const std::size_t bytes = GpuScene(testDevice(), blocks).bytesResident();
    const scene::View eye{cameraOf(160, 120, 0.6), poseAt({-1, 0.1, 0.1}, std::numbers::pi / 2, 0)},
        elsewhere{eye.camera, poseAt(rooms_.other, 1, 0)};
    const auto missingOf = [&](const GpuScene& part) {
        std::size_t missing = 0;
        for (std::size_t i = 0; i < part.places().size(); ++i)
            missing += part.index().chunks[i].captured < blocks.size() / 2 && !part.places()[i].isThere() ? 1 : 0;
        return missing;
    };
    for (const bool isStaged : {false, true}) {
        // With room for little more than the eye's own room.
        std::unique_ptr<GpuScene> part;
        for (std::size_t share = 16; share < 32; ++share) {
            part = std::make_unique<GpuScene>(testDevice(), blocks,
                                              SceneMemory{.budgetBytes = share * bytes / 32, .isStaged = isStaged});
            part->settle({&eye, 1}, {}, &rooms_.coverage);
            if (missingOf(*part) == 0) break;
        }
        ASSERT_EQ(missingOf(*part), 0u) << "whichever way one turns, all of this room is there";
        const EyeImage first = drawOnce(*part, eye, {});
        part->settle({&eye, 1}, {});
        EXPECT_GT(missingOf(*part), 0u) << "where nothing is known of the unseen, it hides nothing";
        // What was looked at before makes no difference, not even from a step aside.
        part->settle({&elsewhere, 1}, {}, &rooms_.coverage);
        EXPECT_GT(missingOf(*part), 0u);
        part->settle({&eye, 1}, {}, &rooms_.coverage);
        EXPECT_EQ(missingOf(*part), 0u);
        EXPECT_TRUE(isSame(drawOnce(*part, eye, {}), first));
        Quality hidden;
        hidden.showUnseen = false;
        part->settle({&eye, 1}, hidden, &rooms_.coverage);
        EXPECT_GT(missingOf(*part), 0u) << "where the unseen is not shown it hides nothing";
        // Over there, right before a wall, nothing is known of what can be seen: not what could be seen from here.
        scene::View beside = elsewhere;
        while (scene::OpenWays::standClear(coverage_.openGrid(), std::array{beside.worldFromEye.translation}))
            beside.worldFromEye.translation.y += 0.05;
        const auto thereOfOther = [&] {
            std::size_t there = 0;
            for (std::size_t i = 0; i < part->places().size(); ++i)
                there += part->index().chunks[i].captured >= blocks.size() / 2 && part->places()[i].isThere() ? 1 : 0;
            return there;
        };
        part->settle({&beside, 1}, {});
        const std::size_t expected = thereOfOther();
        part->settle({&eye, 1}, {}, &rooms_.coverage);
        const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(30);
        part->follow({&eye, 1}, {}, &rooms_.coverage);
        EXPECT_LT(thereOfOther(), expected) << "else this tests nothing";
        while (thereOfOther() < expected && std::chrono::steady_clock::now() < patience)
            part->follow({&beside, 1}, {}, &rooms_.coverage);
        EXPECT_GE(thereOfOther(), expected);
    }
}

TEST_F(BehindUnseen, FramesThatStandAreDrawnAnewWhenWhatHidTheRestIsGone) {
    const auto [left, right] =
        scene::eyesOf(cameraOf(160, 120, 1.0), poseAt(glm::dvec3(0), std::numbers::pi / 2, 0), 0.063);
    const std::array eyes{left, right};
    renderer_.letFramesStand(true);
    const Drawn before = draw(renderer_, eyes, {});
    renderer_.useCoverage(nullptr);
    const Drawn after = draw(renderer_, eyes, {});
    Renderer another(testDevice(), scene_, 160, 120, 2);
    const Drawn expected = draw(another, eyes, {});
    expectSame(after.images, expected.images, "without coverage");
    EXPECT_EQ(after.tiles, expected.tiles);
    EXPECT_LT(before.tiles, after.tiles) << "else nothing was hidden";
}

TEST_F(BehindUnseen, BoxesThatCannotBeAreNotBelieved) {
    std::vector<scene::TileBlock> blocks = rooms_.blocks;
    const SceneIndex asTheyAre(blocks, scene::kChunkBytes);
    for (const ImageSphere& sphere : asTheyAre.spheres)
        EXPECT_TRUE(sphere.box.isFinite());
    blocks[0].samplesInWorld.least.x -= 100, blocks[1].samplesInWorld = {};
    const SceneIndex changed(blocks, scene::kChunkBytes);
    EXPECT_FALSE(changed.spheres[0].box.isFinite());
    EXPECT_FALSE(changed.spheres[1].box.isFinite());
    EXPECT_TRUE(changed.spheres[2].box.isFinite());
}

TEST_F(BehindUnseen, WhereTheUnseenIsHiddenWhatStandsBehindItIsDrawn) {
    const auto [left, right] =
        scene::eyesOf(cameraOf(160, 120, 1.0), poseAt(glm::dvec3(0), std::numbers::pi / 2, 0), 0.063);
    const std::array eyes{left, right};
    Quality shown, hidden, hiddenWhole;
    hidden.showUnseen = hiddenWhole.showUnseen = false;
    hiddenWhole.leavesOutHidden = false;
    const Drawn first = draw(renderer_, eyes, shown), second = draw(renderer_, eyes, hidden);
    EXPECT_LT(first.tiles, second.tiles) << "the other room stands behind the wall";
    expectSame(second.images, draw(renderer_, eyes, hiddenWhole).images, "hidden");
    expectSame(first.images, draw(renderer_, eyes, shown).images, "shown again");
    renderer_.useCoverage(nullptr);
    EXPECT_EQ(draw(renderer_, eyes, shown).tiles, second.tiles) << "of what nothing is known, nothing is left out";
    renderer_.useCoverage(&coverage_);
    expectSame(first.images, draw(renderer_, eyes, shown).images, "known again");
}

} // namespace
} // namespace render
