// How long the root nouns of scene take: cutting an image into tiles, composing a warp, asking what a ray meets.

#include "scene/pick.h"
#include "scene/tile.h"
#include "scene/view.h"

#include <cmath>

#include <benchmark/benchmark.h>

namespace scene {
namespace {

/// A smooth wall with a few absent samples and skins, as a depth camera sees a room.
DepthImage wall(int width, int height) {
    DepthImage image;
    image.camera = {width, height, 0.8 * width, 0.8 * width, width / 2.0, height / 2.0};
    image.colour = Image<Rgb8>(width, height, {120, 110, 100});
    image.disparity = Image<float>(width, height);
    image.flags = Image<std::uint8_t>(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            image.disparity(x, y) = 0.5f + 0.2f * std::sin(0.01f * static_cast<float>(x + y));
            if (x % 50 == 0) image.flags(x, y) = kSkinUpper | kSkinLower;
            if (y % 60 == 0 && x % 3 == 0) image.flags(x, y) = kNoSurface;
        }
    return image;
}

void cutImage(benchmark::State& state) {
    const DepthImage image = wall(640, 480);
    for (auto _ : state)
        benchmark::DoNotOptimize(cutIntoTiles(image, static_cast<int>(state.range(0))));
    state.counters["samples/s"] =
        benchmark::Counter(static_cast<double>(image.flags.size()), benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(cutImage)->ArgName("tileSize")->Arg(16)->Arg(32)->Arg(63)->Unit(benchmark::kMillisecond);

void composeWarp(benchmark::State& state) {
    const Camera camera{640, 480, 500, 500, 320, 240};
    const View eye{camera, poseFromQuaternion({1e6, 2e6, 3}, 0.1, 0.2, 0.3, 0.9)};
    Pose worldFromSource = poseFromQuaternion({1e6, 2e6 + 1, 4}, 0.3, 0.2, 0.1, 0.9);
    for (auto _ : state) {
        benchmark::DoNotOptimize(worldFromSource);
        benchmark::DoNotOptimize(eyeImageFromSourceImage(eye, camera, worldFromSource));
    }
}
BENCHMARK(composeWarp);

/// Cameras on a ring that all look at walls about them; each has 1024 tiles.
void pickAmongTiles(benchmark::State& state) {
    const DepthImage image = wall(1024, 1024);
    const TileSet set = cutIntoTiles(image);
    std::vector<TileBlock> blocks;
    for (int i = 0; i < state.range(0); ++i) {
        const double half = 0.5 * 6.283185307179586 * i / static_cast<double>(state.range(0));
        blocks.push_back(lend(set, image.camera,
                              poseFromQuaternion({0.5 * std::cos(9 * half), 0, 0.5 * std::sin(9 * half)}, 0,
                                                 std::sin(half), 0, std::cos(half))));
    }
    double angle = 0;
    for (auto _ : state) {
        angle += 2.4; // by the golden angle: everywhere
        benchmark::DoNotOptimize(
            pick(blocks, {{0.1, 0, 0.2}, {std::cos(angle), 0.1 * std::sin(7 * angle), std::sin(angle)}}));
    }
    state.counters["tiles"] = static_cast<double>(set.tiles.size() * blocks.size());
}
BENCHMARK(pickAmongTiles)->ArgName("images")->Arg(1)->Arg(10)->Arg(100)->Unit(benchmark::kMillisecond);

} // namespace
} // namespace scene
