// What a frame costs when the same scene stands there once and many times, as the parts of a large site would: the eye
// stands in one of them, at a place of the scene's own path, and sees all that its walls do not hide. The scene is the
// one that ./dev demo builds, or another that REVISIT_BENCH_SCENE names.

#include "render/renderer.h"
#include "scene/coverage_levels.h"
#include "scene/median.h"
#include "tests/bench/given_scene.h"
#include "tests/render/test_scenes.h"

#include <benchmark/benchmark.h>
#include <glm/glm.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <type_traits>

namespace render {
namespace {

/// On a grid, wall to wall. They share what their tiles hold.
std::vector<scene::TileBlock> manyTimes(const scene::Scene& scene, int across, int deep) {
    glm::dvec3 least(std::numeric_limits<double>::infinity()), most(-least);
    for (const IndexedChunk& chunk : SceneIndex(scene.blocks, scene::kChunkBytes).chunks) {
        if (!std::isfinite(chunk.radius)) continue;
        least = glm::min(least, chunk.least), most = glm::max(most, chunk.most);
    }
    const scene::Pose worldFromWalk = scene::inverse(scene.walkFromWorld);
    const glm::dvec3 size = most - least, alongX = worldFromWalk.rotation[0], alongZ = worldFromWalk.rotation[2];
    const double width = glm::dot(glm::abs(alongX), size), depth = glm::dot(glm::abs(alongZ), size);
    std::vector<scene::TileBlock> blocks;
    for (int z = 0; z < deep; ++z)
        for (int x = 0; x < across; ++x)
            for (scene::TileBlock block : scene.blocks) {
                // On both sides, before and behind.
                const int columns = (x + 1) / 2 * (x % 2 == 0 ? 1 : -1), rows = (z + 1) / 2 * (z % 2 == 0 ? 1 : -1);
                block.worldFromCamera.translation += columns * width * alongX + rows * depth * alongZ;
                blocks.push_back(block);
            }
    return blocks;
}

/// A scene whose unseen space is shown, and the same many times, a part's cube from the next. The eye's stands amid
/// the others.
struct PartedSite {
    PartedSite(const Device& device, const scene::Scene& part, int across, int deep, int coverageLevels)
        : blocks(blocksOf(part, across, deep)), coverage(device, coverageOf(part, across, deep, coverageLevels)),
          scene(device, blocks, {.budgetBytes = std::size_t{128} << 20}),
          renderer(device, scene, 640, 480, 2, &coverage) {}
    void settle(std::span<const scene::View> views, const Quality& quality) {
        scene.settle(views, quality, &coverage.openGrid().coverage());
    }
    std::vector<scene::TileBlock> blocks;
    GpuCoverage coverage;
    GpuScene scene;
    Renderer renderer;
    std::vector<double> milliseconds;

  private:
    /// Amid the cube: at its rim, beyond which nothing is known, no capture's own parts stand.
    static std::vector<std::array<int, 3>> placesOf(const scene::Scene& part, int across, int deep) {
        const glm::dvec3 up = glm::abs(scene::inverse(part.walkFromWorld).rotation[1]);
        std::vector<std::array<int, 3>> places;
        for (int row = 0; row < deep; ++row)
            for (int column = 0; column < across; ++column) {
                if (up.x > up.y && up.x > up.z)
                    places.push_back({5, column + 3, row + 3});
                else if (up.y > up.z)
                    places.push_back({column + 3, 5, row + 3});
                else
                    places.push_back({column + 3, row + 3, 5});
            }
        return places;
    }
    static glm::dvec3 offsetOf(const std::vector<std::array<int, 3>>& places, std::size_t i, double edgeMetres) {
        const std::array<int, 3>&p = places[i], &own = places[places.size() / 2];
        return edgeMetres * glm::dvec3(p[0] - own[0], p[1] - own[1], p[2] - own[2]);
    }
    static std::vector<scene::TileBlock> blocksOf(const scene::Scene& part, int across, int deep) {
        const std::vector<std::array<int, 3>> places = placesOf(part, across, deep);
        std::vector<scene::TileBlock> blocks;
        for (std::size_t i = 0; i < places.size(); ++i)
            for (scene::TileBlock block : part.blocks) {
                const glm::dvec3 offset = offsetOf(places, i, part.coverage->edgeMetres);
                block.worldFromCamera.translation += offset;
                block.samplesInWorld.least += offset, block.samplesInWorld.most += offset;
                blocks.push_back(block);
            }
        return blocks;
    }
    static scene::Coverage coverageOf(const scene::Scene& part, int across, int deep, int levels) {
        const std::vector<std::array<int, 3>> places = placesOf(part, across, deep);
        const scene::Coverage one = scene::coarsened(*part.coverage, levels);
        if (places.size() == 1) return one;
        const std::array<int, 3>& own = places[places.size() / 2];
        return coverageManyTimes(one, places, one.cornerInWorld - one.edgeMetres * glm::dvec3(own[0], own[1], own[2]),
                                 2);
    }
};

/// Of which 128 MiB may be on the device.
struct Site {
    Site(const Device& device, const scene::Scene& part, int across, int deep, int /*coverageLevels*/)
        : blocks(manyTimes(part, across, deep)), scene(device, blocks, {.budgetBytes = std::size_t{128} << 20}),
          renderer(device, scene, 640, 480, 2) {}
    void settle(std::span<const scene::View> views, const Quality& quality) { scene.settle(views, quality); }
    std::vector<scene::TileBlock> blocks;
    GpuScene scene;
    Renderer renderer;
    std::vector<double> milliseconds;
};

/// How many of the scene stand side by side, and one behind the other.
using Sizes = std::array<std::array<int, 2>, 3>;
constexpr Sizes kHundred{{{1, 1}, {5, 2}, {10, 10}}}, kTwentyFive{{{1, 1}, {5, 2}, {5, 5}}};
constexpr int kAllLevels = scene::kMaxCoverageLevels;

template <class Site>
void measureArea(benchmark::State& state, Warp warp, const Sizes& sizes, int coverageLevels) {
    static const Device device;
    const scene::Scene* const given = givenScene(state);
    if (given == nullptr) return;
    const scene::Scene& part = *given;
    if (std::is_same_v<Site, PartedSite> && !part.coverage)
        return state.SkipWithError("the scene does not say what was never observed");
    Quality quality;
    quality.warp = warp;
    quality.samplePixels = 1;
    quality.holes.radius = 4;
    const auto [left, right] =
        scene::eyesOf(cameraOf(640, 480, 1.2), part.images[part.images.size() / 2].worldFromCamera, 0.063);
    const std::array views{left, right};
    std::array<std::unique_ptr<Site>, 3> sites;
    for (std::size_t i = 0; i < sites.size(); ++i) {
        sites[i] = std::make_unique<Site>(device, part, sizes[i][0], sizes[i][1], coverageLevels);
        sites[i]->settle(views, quality);
    }
    std::array<FrameStats, 3> stats;
    for (auto _ : state)
        for (std::size_t i = 0; i < sites.size(); ++i) {
            const auto start = std::chrono::steady_clock::now();
            sites[i]->renderer.draw(views, quality);
            stats[i] = sites[i]->renderer.finish();
            const std::chrono::duration<double, std::milli> passed = std::chrono::steady_clock::now() - start;
            sites[i]->milliseconds.push_back(passed.count());
        }
    state.counters["ms_1x"] = scene::medianOf(sites[0]->milliseconds);
    state.counters["ratio_middle"] = scene::medianOf(sites[1]->milliseconds) / scene::medianOf(sites[0]->milliseconds);
    state.counters["ratio_large"] = scene::medianOf(sites[2]->milliseconds) / scene::medianOf(sites[0]->milliseconds);
    state.counters["tiles_1x"] = stats[0].eyes[0].tilesDrawn;
    state.counters["tiles_middle"] = stats[1].eyes[0].tilesDrawn;
    state.counters["tiles_large"] = stats[2].eyes[0].tilesDrawn;
    state.counters["samples_1x"] = static_cast<double>(stats[0].eyes[0].samplesDrawn);
    state.counters["samples_middle"] = static_cast<double>(stats[1].eyes[0].samplesDrawn);
    state.counters["samples_large"] = static_cast<double>(stats[2].eyes[0].samplesDrawn);
    for (const StepTime& time : stats[2].cpu)
        state.counters[std::string("cpu_") + time.step] += time.milliseconds;
    for (const StepTime& time : stats[0].gpu)
        state.counters[std::string("gpu_1x_") + time.step] += time.milliseconds;
    for (const StepTime& time : stats[1].gpu)
        state.counters[std::string("gpu_middle_") + time.step] += time.milliseconds;
    for (const StepTime& time : stats[2].gpu)
        state.counters[std::string("gpu_large_") + time.step] += time.milliseconds;
}
/// Ten and a hundred, wall to wall, with nothing known of what nobody saw.
void areaOfScene(benchmark::State& state, Warp warp) {
    measureArea<Site>(state, warp, kHundred, 0);
}
/// Ten and a hundred, with the unseen shown between them: what it hides need not be drawn. Of so many levels, as many
/// as what `build` would keep of a hundred; and ten and twenty-five as exactly as the scene has them, which no tree has
/// that `build` makes.
void areaOfSceneBehindUnseen(benchmark::State& state, Warp warp) {
    measureArea<PartedSite>(state, warp, kHundred, 4);
}
void areaOfSceneBehindFineUnseen(benchmark::State& state, Warp warp) {
    measureArea<PartedSite>(state, warp, kTwentyFive, kAllLevels);
}
BENCHMARK_CAPTURE(areaOfScene, points, Warp::points)->Iterations(25)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(areaOfScene, adaptive, Warp::adaptive)->Iterations(25)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(areaOfSceneBehindUnseen, points, Warp::points)->Iterations(25)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(areaOfSceneBehindUnseen, adaptive, Warp::adaptive)->Iterations(25)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(areaOfSceneBehindFineUnseen, points, Warp::points)->Iterations(25)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(areaOfSceneBehindFineUnseen, adaptive, Warp::adaptive)->Iterations(25)->Unit(benchmark::kMillisecond);

} // namespace
} // namespace render
