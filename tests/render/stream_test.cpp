// Scenes larger than what they may take: what is chosen, what stands in for what is not there, and that it shows.

#include "render/range_allocator.h"
#include "render/residency.h"
#include "scene/errors.h"
#include "scene/pyramid.h"
#include "tests/render/test_device.h"
#include "tests/render/test_scenes.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <random>
#include <set>

namespace render {
namespace {

TEST(RangeAllocator, GivesEachPlaceToOneAloneAndJoinsWhatIsFree) {
    constexpr std::uint32_t kSize = 4000;
    std::mt19937 random(11);
    RangeAllocator ranges(kSize);
    std::vector<std::pair<std::uint32_t, std::uint32_t>> taken;
    std::vector<bool> isTaken(kSize, false);
    std::uint32_t refused = 0;
    for (int i = 0; i < 20000; ++i) {
        if (random() % 2 == 0 && !taken.empty()) {
            const std::size_t which = random() % taken.size();
            const auto [first, count] = taken[which];
            ranges.give(first, count);
            std::fill_n(isTaken.begin() + first, count, false);
            taken.erase(taken.begin() + static_cast<std::ptrdiff_t>(which));
        } else {
            const auto count = static_cast<std::uint32_t>(1 + random() % 300);
            const auto first = ranges.take(count);
            refused += !first;
            if (!first) {
                EXPECT_LT(ranges.longest(), count);
                continue;
            }
            ASSERT_LE(*first + count, kSize);
            ASSERT_EQ(std::count(isTaken.begin() + *first, isTaken.begin() + *first + count, true), 0);
            std::fill_n(isTaken.begin() + *first, count, true);
            taken.emplace_back(*first, count);
        }
        ASSERT_EQ(ranges.free(), std::count(isTaken.begin(), isTaken.end(), false));
    }
    EXPECT_GT(refused, 100u) << "it was full now and then";
    for (const auto& [first, count] : taken)
        ranges.give(first, count);
    EXPECT_EQ(ranges.longest(), kSize);
}

const scene::Camera kStreamEye = cameraOf(160, 120, 1.4);

/// Four rooms side by side, 10 m apart, each taken from within in six faces, with coarser levels.
class StreamTest : public RenderTest {
  protected:
    static void SetUpTestSuite() {
        rooms_ = new CutScene;
        for (int room = 0; room < 4; ++room)
            for (const scene::DepthImage& face : roomFromWithin(224).images) {
                rooms_->images.push_back(face);
                rooms_->images.back().worldFromCamera.translation.x += 10.0 * room;
                rooms_->sets.push_back(scene::cutIntoLevels(rooms_->images.back(), {}));
            }
    }
    static void TearDownTestSuite() {
        delete rooms_;
        rooms_ = nullptr;
    }

    static scene::View eyeIn(int room, double yaw) {
        return {kStreamEye, poseAt({10.0 * room + 0.2, 0.1, 0.1}, yaw, 0.1)};
    }
    static std::size_t allBytes() { return GpuScene(testDevice(), rooms_->blocks()).bytesResident(); }

    /// Pixels that show nothing although the whole scene would show something there.
    static std::size_t holesOf(const EyeImage& part, const EyeImage& whole) {
        std::size_t holes = 0;
        for (std::size_t i = 0; i < part.pixelClass.size(); ++i)
            holes += part.pixelClass.pixels()[i] == 0 && whole.pixelClass.pixels()[i] != 0;
        return holes;
    }

    std::vector<scene::TileBlock> blocks_ = rooms_->blocks();
    static CutScene* rooms_;
};
CutScene* StreamTest::rooms_ = nullptr;

TEST_F(StreamTest, EyesThatHardlyMoveAskForNothingNew) {
    const Quality quality;
    const scene::View eye = eyeIn(1, 0.5);
    const auto wantTheSame = [&](const scene::View& other, const Quality& otherwise) {
        return wantAboutTheSame({{&eye, 1}, quality, {}}, {{&other, 1}, otherwise, {}});
    };
    scene::View other = eye;
    EXPECT_TRUE(wantTheSame(other, quality));
    other.worldFromEye.translation.x += 0.002;
    EXPECT_TRUE(wantTheSame(other, quality)) << "a head that is held still";
    other.worldFromEye.translation.x += 0.05;
    EXPECT_FALSE(wantTheSame(other, quality)) << "a step";
    EXPECT_FALSE(wantTheSame(eyeIn(1, 0.52), quality)) << "a turn by a degree";
    Quality coarser;
    coarser.samplePixels = 1;
    EXPECT_FALSE(wantTheSame(eye, coarser));
    other = eye;
    other.camera.fx *= 2;
    EXPECT_FALSE(wantTheSame(other, quality));
    const std::array<scene::View, 2> both{eye, eye};
    EXPECT_FALSE(wantAboutTheSame({{&eye, 1}, quality, {}}, {both, quality, {}}));
    const std::vector<float> shares{1, 0};
    EXPECT_FALSE(wantAboutTheSame({{&eye, 1}, quality, {}}, {{&eye, 1}, quality, shares}));
}

TEST_F(StreamTest, WhatStandsForAChunkIsWantedBeforeIt) {
    SceneIndex index(blocks_, 40000);
    index.findFiner();
    const CoarserChunks coarser = coarserChunksOf(index);
    Quality quality;
    quality.preference.nearBaseline = 0.07f;
    const scene::View eye = eyeIn(1, 0.5);
    const std::vector<std::uint32_t> wanted = chunksWanted(index, coarser, {{&eye, 1}, quality, {}});
    std::vector<std::size_t> rank(index.chunks.size(), wanted.size());
    for (std::size_t i = 0; i < wanted.size(); ++i)
        rank[wanted[i]] = i;
    std::size_t links = 0;
    for (std::uint32_t chunk = 0; chunk < index.chunks.size(); ++chunk) {
        for (const std::uint32_t standIn : coarser.of(chunk)) {
            ++links;
            EXPECT_EQ(index.chunks[standIn].chunk.level, index.chunks[chunk].chunk.level + 1);
            EXPECT_TRUE(rank[chunk] == wanted.size() || rank[standIn] < rank[chunk]);
        }
    }
    EXPECT_GT(links, index.chunks.size() / 2);
    // The room one stands in comes before the one next door, at the same level.
    const auto firstOf = [&](std::uint32_t firstImage, std::uint32_t endImage) {
        return *std::find_if(wanted.begin(), wanted.end(), [&](std::uint32_t c) {
            const IndexedChunk& chunk = index.chunks[c];
            return chunk.chunk.level == 0 && chunk.captured >= firstImage && chunk.captured < endImage;
        });
    };
    EXPECT_LT(rank[firstOf(6, 12)], rank[firstOf(12, 18)]);
    EXPECT_LT(rank[firstOf(12, 18)], rank[firstOf(18, 24)]);

    quality.samplePixels = 1;
    EXPECT_LT(chunksWanted(index, coarser, {{&eye, 1}, quality, {}}).size(), wanted.size())
        << "where coarse samples suffice, finer ones are not asked for";
    const auto wantedBy = [&](const Quality& asking) { return chunksWanted(index, coarser, {{&eye, 1}, asking, {}}); };
    Quality mesh = quality, sharper = quality;
    mesh.warp = Warp::mesh;
    EXPECT_EQ(wantedBy(mesh), wanted) << "the mesh is all of what was sampled";
    sharper.resolutionScale = 4;
    EXPECT_GT(wantedBy(sharper).size(), wantedBy(quality).size()) << "pixels of what is warped";
}

TEST_F(StreamTest, TheCoarsestOfEverythingIsKept) {
    const SceneIndex index(blocks_, 40000);
    const std::vector<std::uint32_t> least = chunksToKeep(index, 0), more = chunksToKeep(index, allBytes() / 10);
    EXPECT_TRUE(std::includes(more.begin(), more.end(), least.begin(), least.end()));
    std::set<std::uint32_t> images;
    std::size_t bytes = 0;
    for (const std::uint32_t chunk : more) {
        images.insert(index.chunks[chunk].captured);
        bytes += index.chunks[chunk].chunk.bytes();
    }
    EXPECT_EQ(images.size(), blocks_.size());
    EXPECT_LE(static_cast<double>(bytes), kKeptShare * static_cast<double>(allBytes() / 10));
}

TEST_F(StreamTest, WhereAllThatIsSeenFitsItShowsWhatTheWholeSceneShows) {
    GpuScene whole(testDevice(), blocks_);
    for (const bool isStaged : {false, true}) {
        GpuScene part(testDevice(), blocks_, {.budgetBytes = 3 * allBytes() / 4, .isStaged = isStaged});
        ASSERT_TRUE(part.isStreamed());
        Painter paintPart(part, kStreamEye), paintWhole(whole, kStreamEye);
        EXPECT_LT(part.bytesResident(), whole.bytesResident());
        for (const Warp warp : {Warp::points, Warp::mesh, Warp::adaptive, Warp::splats})
            for (const double samplePixels : {0.0, 1.5})
                for (const int room : {0, 3, 1}) {
                    const scene::View eye = eyeIn(room, 0.7 * room);
                    Quality quality;
                    quality.warp = warp, quality.samplePixels = samplePixels;
                    part.settle({&eye, 1}, quality);
                    // The walls of one's own room hide all others.
                    EXPECT_TRUE(isSame(paintPart(eye, quality), paintWhole(eye, quality)))
                        << room << " staged " << isStaged << " sample_pixels " << samplePixels;
                }
        EXPECT_GT(part.streamCounts().left, 0u) << "rooms have come and gone";
    }
}

TEST_F(StreamTest, WhatIsShownDependsOnTheEyesAlone) {
    GpuScene part(testDevice(), blocks_, {.budgetBytes = allBytes() / 10});
    const auto drawIn = [&](int room, double yaw) {
        const scene::View eye = eyeIn(room, yaw);
        part.settle({&eye, 1}, {});
        return drawOnce(part, eye, {});
    };
    const EyeImage first = drawIn(0, 0.3);
    for (int room = 1; room < 4; ++room)
        drawIn(room, 2.0 * room);
    EXPECT_TRUE(isSame(drawIn(0, 0.3), first));
}

TEST_F(StreamTest, NoFrameOfAFastPathShowsAHoleThatTheWholeSceneDoesNot) {
    const GpuScene whole(testDevice(), blocks_);
    Renderer wholeRenderer(testDevice(), whole, kStreamEye.width, kStreamEye.height, 1);
    for (const Warp warp : {Warp::points, Warp::mesh, Warp::adaptive, Warp::splats})
        for (const bool hasArrivals : {false, true}) { // at worst, nothing ever arrives in time
            GpuScene part(testDevice(), blocks_, {.budgetBytes = allBytes() / 10});
            Quality quality;
            quality.warp = warp;
            quality.holes.radius = 4; // as all presets have it
            Renderer renderer(testDevice(), part, kStreamEye.width, kStreamEye.height, 1);
            std::size_t holes = 0, pixels = 0;
            for (int frame = 0; frame < 48; ++frame) {
                // Through all rooms in half a second at 90 frames a second, turning round and round.
                const double x = 30.0 * frame / 47;
                if (std::abs(std::remainder(x - 5, 10.0)) < 1.3) continue; // within a wall there is nothing to compare
                const scene::View eye{kStreamEye, poseAt({x, 0.1, 0.1}, 0.4 * frame, 0.1)};
                if (hasArrivals) part.follow({&eye, 1}, quality); // never waits for what is to come
                renderer.draw({&eye, 1}, quality);
                wholeRenderer.draw({&eye, 1}, quality);
                holes += holesOf(renderer.readBack()[0], wholeRenderer.readBack()[0]);
                pixels += kStreamEye.width * kStreamEye.height;
            }
            EXPECT_LE(static_cast<double>(holes), 1e-5 * static_cast<double>(pixels))
                << static_cast<int>(warp) << ": " << holes;
        }
}

TEST_F(StreamTest, AfterASettledPictureAllThatIsThereIsShownAgain) {
    const scene::View first = eyeIn(0, 0), next = eyeIn(3, 0);
    for (const bool isStaged : {false, true}) {
        GpuScene part(testDevice(), blocks_, {.budgetBytes = 3 * allBytes() / 4, .isStaged = isStaged});
        const auto there = [&] {
            return std::count_if(part.places().begin(), part.places().end(),
                                 [](const ChunkPlace& p) { return p.isThere(); });
        };
        part.settle({&first, 1}, {});
        const auto settled = there();
        Quality near; // directional samples are wanted only with it; here it changes what is desired
        near.samplePixels = 40;
        part.settle({&next, 1}, near);
        EXPECT_LT(there(), settled) << "little is wanted so";
        part.follow({&next, 1}, near);
        EXPECT_GE(there(), settled) << "but nothing had to go";
    }
}

// Eyes that come back to where all was there want it again: some of it had to leave meanwhile.
TEST_F(StreamTest, WhatHadToLeaveForAGlanceAsideComesBack) {
    const scene::View here = eyeIn(0, 0), aside = eyeIn(3, 0);
    for (const bool isStaged : {false, true}) {
        GpuScene part(testDevice(), blocks_, {.budgetBytes = allBytes() / 2, .isStaged = isStaged});
        part.settle({&here, 1}, {});
        std::vector<std::size_t> wanted;
        for (std::size_t i = 0; i < part.places().size(); ++i)
            if (part.places()[i].isThere()) wanted.push_back(i);
        const auto goOn = [&](const scene::View& eye, const auto& isDone) {
            const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(30);
            while (!isDone() && std::chrono::steady_clock::now() < patience)
                part.follow({&eye, 1}, {});
            return isDone();
        };
        const auto areThere = [&] {
            return std::ranges::all_of(wanted, [&](std::size_t i) { return part.places()[i].isThere(); });
        };
        ASSERT_TRUE(goOn(aside, [&] { return !areThere(); }));
        EXPECT_TRUE(goOn(here, areThere)) << "staged " << isStaged;
    }
}

// Renderer::letFramesStand: a walker who stands still sees what arrives.
TEST_F(StreamTest, FramesStandOnceAllHasArrived) {
    const scene::View before = eyeIn(0, 0), eye = eyeIn(3, 1);
    for (const bool isStaged : {false, true}) {
        GpuScene part(testDevice(), blocks_, {.budgetBytes = allBytes() / 2, .isStaged = isStaged});
        Renderer renderer(testDevice(), part, kStreamEye.width, kStreamEye.height, 1);
        renderer.letFramesStand(true);
        part.settle({&before, 1}, {});
        std::uint64_t changes = part.changes();
        int standing = 0;
        const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(30);
        for (int frame = 0; standing < 50 && std::chrono::steady_clock::now() < patience; ++frame) {
            part.follow({&eye, 1}, {});
            const bool isStanding = renderer.draw({&eye, 1}, {}).isStanding;
            EXPECT_EQ(isStanding, frame > 0 && part.changes() == changes) << "staged " << isStaged << ", " << frame;
            standing = isStanding ? standing + 1 : 0;
            changes = part.changes();
        }
        EXPECT_EQ(standing, 50) << "staged " << isStaged;
        EXPECT_TRUE(isSame(renderer.readBack()[0], drawOnce(part, eye, {}))) << "staged " << isStaged;
    }
}

/// Where surfaces stand in for what is not there, eyes are drawn one by one, in a frame that was asked for in one pass.
TEST_F(StreamTest, InOnePassTheSameIsSeenOfWhatIsThere) {
    std::size_t inOnePass = 0, eyeByEye = 0;
    for (const std::size_t budget : {allBytes() / 10, 3 * allBytes() / 4}) {
        GpuScene part(testDevice(), blocks_, {.budgetBytes = budget});
        Renderer renderer(testDevice(), part, kStreamEye.width, kStreamEye.height, 2);
        for (const Warp warp : {Warp::points, Warp::splats})
            for (int i = 0; i < 4; ++i) {
                const std::array eyes{eyeIn(i, 1.5 * i), eyeIn(i, 1.5 * i + 0.3)};
                Quality quality;
                quality.warp = warp;
                if (i % 2 == 0) part.settle(eyes, quality);
                part.follow(eyes, quality);
                renderer.draw(eyes, quality);
                const std::vector<EyeImage> expected = renderer.readBack();
                quality.isOnePass = true;
                ++(renderer.draw(eyes, quality).isOnePass ? inOnePass : eyeByEye);
                for (std::size_t eye = 0; eye < 2; ++eye)
                    EXPECT_TRUE(isSame(renderer.readBack()[eye], expected[eye])) << budget << " " << i;
            }
    }
    EXPECT_GT(inOnePass, 0u);
    EXPECT_GT(eyeByEye, 0u);
}

TEST_F(StreamTest, ABudgetTooSmallForTheCoarsestIsRefused) {
    EXPECT_THROW(GpuScene(testDevice(), blocks_, {.budgetBytes = 100000}), scene::Failure);
}

TEST_F(StreamTest, WhatIsDamagedIsDrawnAsUnseenAndToldOnce) {
    const GpuScene whole(testDevice(), blocks_);
    std::vector<std::uint64_t> sums;
    for (const scene::TileChunk& chunk : scene::chunksOf(blocks_[0]))
        sums.push_back(scene::checksumOf(blocks_[0], chunk));
    sums[0] ^= 1; // of the first face's own samples
    blocks_[0].chunkSums = sums;
    const scene::View ahead{kStreamEye, rooms_->images[0].worldFromCamera},
        behind{kStreamEye, rooms_->images[2].worldFromCamera};
    for (const std::size_t budget : {std::numeric_limits<std::size_t>::max(), 3 * allBytes() / 4}) {
        GpuScene scene(testDevice(), blocks_, {.budgetBytes = budget});
        for (const Warp warp : {Warp::points, Warp::mesh, Warp::adaptive, Warp::splats}) {
            Quality quality;
            quality.warp = warp;
            const auto unseenOf = [&](const scene::View& eye) {
                scene.settle({&eye, 1}, quality);
                const EyeImage drawn = drawOnce(scene, eye, quality);
                EXPECT_GE(coverage(drawn), coverage(drawOnce(whole, eye, quality)) - 0.005) << "neither emptiness";
                const auto classes = drawn.pixelClass.pixels();
                return static_cast<double>(std::count(classes.begin(), classes.end(), 3)) /
                       static_cast<double>(classes.size());
            };
            EXPECT_GT(unseenOf(ahead), 0.05) << static_cast<int>(warp);
            EXPECT_EQ(unseenOf(behind), 0.0);
        }
        EXPECT_EQ(scene.takeDamaged(), std::vector<std::uint32_t>{0});
        EXPECT_TRUE(scene.takeDamaged().empty());
    }
}

} // namespace
} // namespace render
