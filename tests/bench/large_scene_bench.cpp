// What a frame costs when the same room stands there once, ten and a hundred times, as the parts of a large site would:
// the eye stands in one of them and sees all that its walls do not hide.

#include "render/renderer.h"
#include "scene/pyramid.h"
#include "tests/render/test_scenes.h"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <memory>

namespace render {
namespace {

CutScene takenWithin(int size) {
    CutScene room;
    room.images = roomFromWithin(size).images;
    for (const scene::DepthImage& face : room.images)
        room.sets.push_back(scene::cutIntoLevels(face, {}));
    return room;
}

/// Rooms on a grid, 9 m by 7 m each; the first is where the eye stands. They share what their tiles hold.
std::vector<scene::TileBlock> manyTimes(const CutScene& room, int across, int deep) {
    std::vector<scene::TileBlock> blocks;
    for (int z = 0; z < deep; ++z)
        for (int x = 0; x < across; ++x)
            for (scene::TileBlock block : room.blocks()) {
                block.worldFromCamera.translation += glm::dvec3(9.0 * x, 0, 7.0 * z);
                blocks.push_back(block);
            }
    return blocks;
}

/// A site of so many rooms, of which 192 MiB may be on the device.
struct Site {
    Site(const Device& device, const CutScene& room, int across, int deep)
        : blocks(manyTimes(room, across, deep)), scene(device, blocks, {.budgetBytes = std::size_t{192} << 20}),
          renderer(device, scene, 640, 480, 2) {}
    std::vector<scene::TileBlock> blocks;
    GpuScene scene;
    Renderer renderer;
    std::vector<double> milliseconds;
};

double medianOf(std::vector<double> values) {
    std::nth_element(values.begin(), values.begin() + std::ssize(values) / 2, values.end());
    return values[values.size() / 2];
}

void areaOfScene(benchmark::State& state, Warp warp) {
    static const Device device;
    static const CutScene room = takenWithin(577);
    Quality quality;
    quality.warp = warp;
    quality.samplePixels = 1;
    quality.holes.radius = 4;
    const auto [left, right] = scene::eyesOf(cameraOf(640, 480, 1.4), poseAt({0.2, 0.1, -0.3}, 0.5, 0.1), 0.063);
    const std::array views{left, right};
    std::array<std::unique_ptr<Site>, 3> sites;
    constexpr std::array<std::array<int, 2>, 3> kSizes{{{1, 1}, {5, 2}, {10, 10}}};
    for (std::size_t i = 0; i < sites.size(); ++i) {
        sites[i] = std::make_unique<Site>(device, room, kSizes[i][0], kSizes[i][1]);
        sites[i]->scene.settle(views, quality);
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
    state.counters["ms_1x"] = medianOf(sites[0]->milliseconds);
    state.counters["ratio_10x"] = medianOf(sites[1]->milliseconds) / medianOf(sites[0]->milliseconds);
    state.counters["ratio_100x"] = medianOf(sites[2]->milliseconds) / medianOf(sites[0]->milliseconds);
    state.counters["tiles_1x"] = stats[0].eyes[0].tilesDrawn;
    state.counters["tiles_100x"] = stats[2].eyes[0].tilesDrawn;
    state.counters["samples_1x"] = static_cast<double>(stats[0].eyes[0].samplesDrawn);
    state.counters["samples_100x"] = static_cast<double>(stats[2].eyes[0].samplesDrawn);
    for (const StepTime& time : stats[2].cpu)
        state.counters[std::string("cpu_") + time.step] += time.milliseconds;
    for (const StepTime& time : stats[0].gpu)
        state.counters[std::string("gpu1_") + time.step] += time.milliseconds;
    for (const StepTime& time : stats[2].gpu)
        state.counters[std::string("gpu100_") + time.step] += time.milliseconds;
}
BENCHMARK_CAPTURE(areaOfScene, points, Warp::points)->Iterations(25)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(areaOfScene, adaptive, Warp::adaptive)->Iterations(25)->Unit(benchmark::kMillisecond);

} // namespace
} // namespace render
