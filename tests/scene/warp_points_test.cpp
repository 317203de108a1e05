// The points' vectors against one sample at a time, bit by bit, with every instruction set that the processor has.

#include "scene/footprint.h"
#include "scene/warp.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <random>
#include <set>

#include <gtest/gtest.h>
#include <hwy/highway.h>
#include <tbb/global_control.h>

namespace scene {
namespace {

/// warpPoints as its header describes it, sample by sample.
void warpOneByOne(std::span<const TileBlock> blocks, const View& eye, const WarpOptions& options, ZBuffer& zBuffer) {
    for (const TileBlock& block : blocks) {
        const glm::dmat4 c = eyeImageFromSourceImage(eye, block.camera, block.worldFromCamera);
        for (const Tile& tile : block.tiles) {
            const auto level = orderLevelOf(tile, block.camera, block.worldFromCamera, eye, options.preference);
            if (!level) continue;
            const int pixels = footprintOf(typicalInEye(c, boxOf(tile, block.camera), tile.placeBits).sampleWidth,
                                           static_cast<double>(options.footprintScale), options.maxFootprint);
            const float half = 0.5f * static_cast<float>(pixels - 1);
            const double perScale = 1.0 / static_cast<double>(orderScale(*level));
            const double step = (static_cast<double>(tile.maxDisparity) - tile.minDisparity) / maxQuantisedOf(tile);
            const glm::dvec4 origin =
                c * glm::dvec4(tile.x0 + 0.5, tile.y0 + 0.5, 1.0, static_cast<double>(tile.minDisparity));
            for (const TileVertex& vertex : block.vertices.subspan(tile.firstVertex, tile.pointCount)) {
                const std::uint32_t side = 1u << tile.placeBits;
                const auto x = static_cast<float>(vertex.place % side);
                const auto y = static_cast<float>(vertex.place / side % side);
                const auto q = static_cast<float>(vertex.place / side / side);
                float h[3];
                for (int i = 0; i < 3; ++i) {
                    h[i] = static_cast<float>(origin[i]) + x * static_cast<float>(c[0][i]);
                    h[i] = h[i] + y * static_cast<float>(c[1][i]);
                    h[i] = h[i] + q * static_cast<float>(c[3][i] * step);
                }
                if (!(h[2] > 0)) continue;
                const float perW = 1 / h[2];
                const float disparity =
                    (static_cast<float>(tile.minDisparity * perScale) + q * static_cast<float>(step * perScale)) * perW;
                if (!(disparity >= 0 && disparity <= 1 / kNearMetres)) continue;
                const float left = std::floor(h[0] * perW - half), top = std::floor(h[1] * perW - half);
                const std::uint32_t low =
                    (vertex.colour & 0xffffffu) << 8 | static_cast<std::uint32_t>(*level) << 2 | 1u;
                // The last bit tells a rim, a hundredth less near; the five before it where the sample stands.
                const auto rounded = [](float d) { return (std::bit_cast<std::uint32_t>(d) + 32) / 64 * 64; };
                const std::uint32_t order = rounded(disparity);
                const std::uint32_t behind = rounded(disparity * 0.99f) == 0 ? 0 : rounded(disparity * 0.99f) + 1;
                const auto keyAt = [&](int u, int v, bool isOwn) {
                    const std::uint32_t disparityAndRim = isOwn ? order : behind;
                    // Quarters of a pixel from its centre, or halves, at most two, modulo 5.
                    const float perPixel = isOwn ? 4 : 2;
                    const auto steps = [&](int pixel, float at) {
                        const float offset = static_cast<float>(pixel) + 0.5f - at;
                        return (static_cast<int>(std::clamp(std::floor(0.5f - offset * perPixel), -2.f, 2.f)) + 5) % 5;
                    };
                    const auto place = static_cast<std::uint32_t>(5 * steps(u, h[0] * perW) + steps(v, h[1] * perW));
                    return std::uint64_t{disparityAndRim == 0 ? 0 : disparityAndRim + 2 * place} << 32 | low;
                };
                const float ownX = std::floor(h[0] * perW), ownY = std::floor(h[1] * perW);
                for (int v = 0; v < zBuffer.height(); ++v)
                    for (int u = 0; u < zBuffer.width(); ++u)
                        if (static_cast<float>(u) >= left &&
                            static_cast<float>(u) < left + static_cast<float>(pixels) && static_cast<float>(v) >= top &&
                            static_cast<float>(v) < top + static_cast<float>(pixels))
                            zBuffer(u, v) =
                                std::max(zBuffer(u, v),
                                         keyAt(u, v, static_cast<float>(u) == ownX && static_cast<float>(v) == ownY));
            }
        }
    }
}

/// Tiles of up to maxPoints samples anywhere in them, each followed by border.
struct RandomTiles {
    TileSet set;
    Camera camera{300, 200, 150, 160, 149.5, 100.25};
    Pose worldFromCamera;

    RandomTiles(std::mt19937& random, int count, int maxPoints, float maxDisparity) {
        std::uniform_real_distribution<float> unit(0, 1);
        std::uniform_int_distribution<std::uint32_t> word;
        for (int i = 0; i < count; ++i) {
            Tile tile;
            tile.x0 = static_cast<int>(random() % 300), tile.y0 = static_cast<int>(random() % 200);
            tile.width = tile.height = 63;
            const float a = maxDisparity * unit(random), b = maxDisparity * unit(random);
            tile.minDisparity = i % 5 == 0 ? 0 : std::min(a, b);
            tile.maxDisparity = i % 7 == 0 ? tile.minDisparity : std::max(a, b);
            tile.firstVertex = static_cast<std::uint32_t>(set.vertices.size());
            tile.pointCount = word(random) % static_cast<unsigned>(maxPoints + 1);
            tile.vertexCount = tile.pointCount + word(random) % 9;
            tile.tier = i % 3 == 0 ? Tier::directional : Tier::base;
            for (std::uint32_t v = 0; v < tile.vertexCount; ++v)
                set.vertices.push_back({word(random), word(random)});
            set.tiles.push_back(tile);
        }
    }
    TileBlock block() const { return lend(set, camera, worldFromCamera); }
};

class WarpPointsTest : public testing::TestWithParam<std::int64_t> {
  protected:
    void SetUp() override { choose(GetParam()); }
    void TearDown() override { choose(0); }

    /// 0: all of them again.
    static void choose(std::int64_t targets) {
        hwy::SetSupportedTargetsForTest(targets);
        hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    }

    /// How many pixels were drawn on, of all that were compared.
    static std::size_t expectSame(std::span<const TileBlock> blocks, const View& eye, const WarpOptions& options) {
        ZBuffer truth(eye.camera.width, eye.camera.height, 0);
        truth(0, 0) = 5; // what stands there already counts, too
        const ZBuffer start = truth;
        warpOneByOne(blocks, eye, options, truth);
        for (const std::size_t threads : {1u, 2u}) {
            const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
            ZBuffer drawn = start;
            warpPoints(blocks, eye, options, drawn);
            EXPECT_TRUE(drawn == truth) << threads << " threads, footprint " << options.maxFootprint;
        }
        return truth.size() - static_cast<std::size_t>(std::count(truth.pixels().begin(), truth.pixels().end(), 0u));
    }

    std::mt19937 random_{7};
};

TEST_P(WarpPointsTest, EqualOneSampleAtATime) {
    std::uniform_real_distribution<double> unit(-1, 1);
    std::size_t drawn = 0;
    for (int round = 0; round < 24; ++round) {
        // Fewer samples than a vector has, a vector and a bit, many.
        RandomTiles near(random_, 12, round % 3 == 0 ? 5 : round % 3 == 1 ? 40 : 300, 2.f);
        RandomTiles far(random_, 5, 100, 0.1f);
        far.worldFromCamera.translation = {0.3, 0.1, -0.2};
        const std::vector<TileBlock> blocks{near.block(), far.block()};
        View eye{{40 + round, 30, 22.0, 25.0, 20.0, 14.5}, {}};
        eye.worldFromEye = poseFromQuaternion({0.2 * unit(random_), 0.2 * unit(random_), unit(random_)},
                                              0.3 * unit(random_), 0.5 * unit(random_), 0.2 * unit(random_), 1);
        WarpOptions options;
        options.maxFootprint = 1 + round % 4;
        options.footprintScale = 4;
        if (round % 5 == 4) options.preference.nearBaseline = 0;
        drawn += expectSame(blocks, eye, options);
    }
    EXPECT_GT(drawn, 2000u);
}

TEST_P(WarpPointsTest, SamplesBehindAndAtTheEye) {
    RandomTiles tiles(random_, 30, 100, 1.f);
    for (const double z : {0.5, 1.0, 3.0, 100.0, 1e6}) {
        const View within{{64, 48, 30, 30, 32, 24}, {glm::dmat3(1), {0, 0, z}}};
        const View turned{{64, 48, 30, 30, 32, 24}, poseFromQuaternion({0, 0, z}, 0, 1, 0, 0)};
        for (const int footprint : {1, 3}) {
            WarpOptions options;
            options.maxFootprint = footprint;
            const std::vector<TileBlock> blocks{tiles.block()};
            expectSame(blocks, within, options);
            expectSame(blocks, turned, options);
        }
    }
}

TEST_P(WarpPointsTest, FarOutsideTheImage) {
    RandomTiles tiles(random_, 20, 100, 2.f);
    RandomTiles huge(random_, 20, 100, 1e30f);
    RandomTiles tiny(random_, 20, 100, 1e-38f);
    const std::vector<TileBlock> blocks{tiles.block(), huge.block(), tiny.block()};
    for (const double focal : {1e-30, 20.0, 1e10, 1e30, 1e38})
        for (const double centre : {0.0, 1e10, -1e30, 1e38})
            for (int footprint = 1; footprint <= 4; ++footprint) {
                const View eye{{33, 17, focal, focal, 16 + centre, 8 - centre}, {glm::dmat3(1), {0.1, 0.2, -0.5}}};
                WarpOptions options;
                options.maxFootprint = footprint;
                expectSame(blocks, eye, options);
            }
}

TEST_P(WarpPointsTest, ImagesSmallerThanAVector) {
    RandomTiles tiles(random_, 10, 50, 1.f);
    const std::vector<TileBlock> blocks{tiles.block()};
    for (const int width : {1, 3, 20})
        for (const int height : {1, 2})
            for (int footprint = 1; footprint <= 4; ++footprint) {
                const View eye{{width, height, 2.0 * width, 2.0 * height, width / 2.0, height / 2.0}, {}};
                WarpOptions options;
                options.maxFootprint = footprint;
                expectSame(blocks, eye, options);
            }
    ZBuffer empty;
    warpPoints(blocks, {{0, 0, 1, 1, 0, 0}, {}}, {}, empty);
    EXPECT_TRUE(empty.empty());
}

TEST_P(WarpPointsTest, EveryOrderLevel) {
    RandomTiles tiles(random_, 6, 40, 1.f);
    const std::vector<TileBlock> blocks{tiles.block()};
    WarpOptions options;
    options.preference = {0.5f, kMaxOrderLevel};
    std::set<int> levels;
    for (int i = 0; i < 200; ++i) {
        options.maxFootprint = 1 + i % 2;
        const View eye{{32, 24, 16, 16, 16, 12}, {glm::dmat3(1), {0, 0, -0.01 * i}}};
        expectSame(blocks, eye, options);
        for (const Tile& tile : tiles.set.tiles)
            if (const auto level = orderLevelOf(tile, tiles.camera, {}, eye, options.preference)) levels.insert(*level);
    }
    EXPECT_EQ(levels.size(), std::size_t{kMaxOrderLevel} + 1);
}

std::vector<std::int64_t> targetsHere() {
    std::vector<std::int64_t> targets;
    for (std::int64_t rest = hwy::SupportedTargets() & HWY_TARGETS; rest != 0; rest &= rest - 1)
        targets.push_back(rest & -rest);
    return targets;
}

INSTANTIATE_TEST_SUITE_P(EveryTarget, WarpPointsTest, testing::ValuesIn(targetsHere()),
                         [](const auto& target) { return std::string(hwy::TargetName(target.param)); });

} // namespace
} // namespace scene
