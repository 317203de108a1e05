// How fast drawing is, each figure beside the one it is to be compared with, taken in turns in the same run.
// Where others use the machine too, the best of many runs says what the code does: counters are made of the
// bests.

#include "render/renderer.h"
#include "tests/bench/bare_scatter.h"
#include "tests/bench/device_time.h"
#include "tests/render/test_scenes.h"

#include <benchmark/benchmark.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstring>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace render {
namespace {

Device& benchDevice() {
    static Device device;
    return device;
}

template <class Work>
double millisecondsOf(Work&& work) {
    std::vector<StepTime> times;
    timed(times, "", kWholeFrame, work);
    return times[0].milliseconds;
}

constexpr double kNever = std::numeric_limits<double>::max();

double warpTime(const FrameStats& stats) {
    return deviceTimeOf(stats, "warp");
}

/// Two million samples in 2000 tiles; the eye sees about a third.
const CutScene& room() {
    static const CutScene scene = roomFromWithin(577);
    return scene;
}
const scene::View& wideView() {
    static const scene::View view{cameraOf(640, 480, 2.0), poseAt({0.3, 0, -0.8}, 0.3, 0.1)};
    return view;
}

/// All samples of one image, which the eye sees entirely, against the bare scatter of the same samples.
void pointsAgainstBareScatter(benchmark::State& state) {
    const CutScene scene = cut({takeRoom(cameraOf(2048, 2048, 1.5), poseAt({0, 0, -1}, 0.2, 0))});
    const auto blocks = scene.blocks();
    const GpuScene gpuScene(benchDevice(), blocks);
    const scene::View view{cameraOf(1024, 1024, 1.7), poseAt({0.05, 0.02, -1.2}, 0.22, 0.01)};
    BareScatter bare(benchDevice(), blocks, 1024, 1024);
    Renderer renderer(benchDevice(), gpuScene, 1024, 1024, 1);
    const Quality onePixel{.maxFootprint = 1};
    double bareBest = kNever, ourBest = kNever;
    FrameStats stats;
    for (auto _ : state) {
        bareBest = std::min(bareBest, bare.run(view));
        renderer.draw(std::span(&view, 1), onePixel);
        stats = renderer.finish();
        ourBest = std::min(ourBest, warpTime(stats));
    }
    const double ours = static_cast<double>(stats.eyes[0].samplesDrawn) / ourBest / 1e3;
    const double bares = static_cast<double>(bare.samples()) / bareBest / 1e3;
    state.counters["points_M_per_s"] = ours;
    state.counters["bare_M_per_s"] = bares;
    state.counters["ratio"] = ours / bares;
}
BENCHMARK(pointsAgainstBareScatter)->Iterations(20)->Unit(benchmark::kMillisecond);

void rateOfWarp(benchmark::State& state, const Quality& quality) {
    const GpuScene gpuScene(benchDevice(), room().blocks());
    Renderer renderer(benchDevice(), gpuScene, 640, 480, 1);
    double best = kNever;
    FrameStats stats;
    for (auto _ : state) {
        renderer.draw(std::span(&wideView(), 1), quality);
        stats = renderer.finish();
        best = std::min(best, warpTime(stats));
    }
    state.counters["M_per_s"] = static_cast<double>(stats.eyes[0].samplesDrawn) / best / 1e3;
    state.counters["warp_ms"] = best;
}
BENCHMARK_CAPTURE(rateOfWarp, points1, Quality{.maxFootprint = 1})->Iterations(40)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(rateOfWarp, points4, Quality{.maxFootprint = 4})->Iterations(40)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(rateOfWarp, splats, Quality{.warp = Warp::splats})->Iterations(40)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(rateOfWarp, mesh, Quality{.warp = Warp::mesh})->Iterations(40)->Unit(benchmark::kMillisecond);

/// What a walker gets: two eyes, frames overlapping, resolved pictures.
void stereoFrames(benchmark::State& state, const Quality& quality) {
    const GpuScene gpuScene(benchDevice(), room().blocks());
    Renderer renderer(benchDevice(), gpuScene, 640, 480, 2);
    const auto [left, right] = scene::eyesOf(wideView().camera, wideView().worldFromEye, 0.063);
    const std::array views{left, right};
    double best = kNever;
    for (auto _ : state) {
        const double time = millisecondsOf([&] {
            for (int i = 0; i < 10; ++i)
                renderer.draw(views, quality);
            renderer.finish();
        });
        best = std::min(best, time / 10);
    }
    const FrameStats stats = renderer.finish();
    state.counters["frames_per_s"] = 1000 / best;
    state.counters["visible_share"] =
        static_cast<double>(stats.eyes[0].samplesDrawn) / static_cast<double>(pointsOf(room()));
}
BENCHMARK_CAPTURE(stereoFrames, points1, Quality{.maxFootprint = 1})->Iterations(10)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(stereoFrames, points4, Quality{.maxFootprint = 4})->Iterations(10)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(stereoFrames, splats, Quality{.warp = Warp::splats})->Iterations(10)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(stereoFrames, mesh, Quality{.warp = Warp::mesh})->Iterations(10)->Unit(benchmark::kMillisecond);

double quantileOf(std::vector<double> values, double share) {
    std::sort(values.begin(), values.end());
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

/// Both eyes in one pass against a pass for each, frame by frame in turns: how long the warps of a frame take.
void onePassAgainstOneEach(benchmark::State& state, Quality quality) {
    const GpuScene gpuScene(benchDevice(), room().blocks());
    Renderer renderer(benchDevice(), gpuScene, 640, 480, 2);
    const auto [left, right] = scene::eyesOf(wideView().camera, wideView().worldFromEye, 0.063);
    const std::array views{left, right};
    std::array<std::vector<double>, 2> times; // of one each, of one pass
    for (auto _ : state)
        for (const bool isOnePass : {false, true}) {
            quality.isOnePass = isOnePass;
            renderer.draw(views, quality);
            times[isOnePass ? 1 : 0].push_back(warpTime(renderer.finish()));
        }
    for (const auto& [name, share] : {std::pair{"best", 0.0}, {"median", 0.5}, {"p99", 0.99}}) {
        const double each = quantileOf(times[0], share), together = quantileOf(times[1], share);
        state.counters[std::string("one_each_ms_") + name] = each;
        state.counters[std::string("one_pass_ms_") + name] = together;
        state.counters[std::string("ratio_") + name] = together / each;
    }
}
BENCHMARK_CAPTURE(onePassAgainstOneEach, points1, Quality{.maxFootprint = 1})
    ->Iterations(100)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(onePassAgainstOneEach, points4, Quality{.maxFootprint = 4})
    ->Iterations(100)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(onePassAgainstOneEach, splats, Quality{.warp = Warp::splats})
    ->Iterations(100)
    ->Unit(benchmark::kMillisecond);

/// A test of one tile after the other, as one writes it without vectors.
std::size_t findVisibleOneByOne(const TileBounds& b, const ImagePlanes& planes, std::uint32_t* visible) {
    std::size_t found = 0;
    for (std::size_t i = 0; i < b.size(); ++i) {
        bool isVisible = true;
        for (const glm::vec4& p : planes.inside) {
            const float x = p.x > 0 ? b.xMax[i] : b.xMin[i], y = p.y > 0 ? b.yMax[i] : b.yMin[i],
                        d = p.w > 0 ? b.dMax[i] : b.dMin[i];
            if (p.x * x + p.y * y + p.w * d + p.z < 0) {
                isVisible = false;
                break;
            }
        }
        if (isVisible) visible[found++] = static_cast<std::uint32_t>(i);
    }
    return found;
}

void cullingAgainstOneByOne(benchmark::State& state) {
    const GpuScene gpuScene(benchDevice(), room().blocks());
    TileBounds bounds;
    for (std::size_t i = 0; bounds.size() < 20000; ++i) {
        const ResidentTile& t = gpuScene.tiles()[i % gpuScene.tiles().size()];
        scene::Tile tile;
        tile.x0 = t.x0, tile.y0 = t.y0, tile.width = tile.height = 32;
        tile.minDisparity = t.minDisparity, tile.maxDisparity = t.maxDisparity;
        bounds.append(tile, room().images[0].camera);
    }
    const glm::dmat4 c =
        scene::eyeImageFromSourceImage(wideView(), room().images[0].camera, room().images[0].worldFromCamera);
    const ImagePlanes planes = planesOf(c, 640, 480, 1, bounds.extentOf(0, bounds.size()));
    std::vector<std::uint32_t> visible(bounds.size());
    double vectors = kNever, oneByOne = kNever;
    for (auto _ : state) {
        vectors = std::min(vectors, millisecondsOf([&] {
                               benchmark::DoNotOptimize(findVisible(bounds, 0, bounds.size(), planes, visible.data()));
                           }));
        oneByOne = std::min(oneByOne, millisecondsOf([&] {
                                benchmark::DoNotOptimize(findVisibleOneByOne(bounds, planes, visible.data()));
                            }));
    }
    const double tests = static_cast<double>(bounds.size());
    state.counters["tiles_per_us_core"] = tests / vectors / 1e3;
    state.counters["one_by_one_tiles_per_us_core"] = tests / oneByOne / 1e3;
    state.counters["speedup"] = oneByOne / vectors;
}
BENCHMARK(cullingAgainstOneByOne)->Iterations(500)->Unit(benchmark::kMicrosecond);

/// Everything a frame does on the processor before it submits.
struct EyeWork {
    std::vector<SourceView> sources;
    std::vector<ImagePlanes> planes;
    VisibleTiles visible;
    DrawList list;
    EyeTarget target;
};

void eyesAtOnceAgainstInTurn(benchmark::State& state) {
    // 140 x 140 tiles of 4 x 4 samples in each of six images: more than 100,000.
    const CutScene fine = roomFromWithin(560, 4);
    const GpuScene scene(benchDevice(), fine.blocks());
    const VkDescriptorSetLayout eyeLayout = makeEyeLayout(benchDevice());
    const auto passOf = [&](Warp warp) {
        const WarpPass pass = makeWarpPass(benchDevice(), warp, scene.pageLayout(), eyeLayout);
        compile(pass); // that is not what is timed
        return pass;
    };
    const WarpPasses warps{passOf(Warp::points), passOf(Warp::mesh), passOf(Warp::adaptive), passOf(Warp::splats)};
    CommandStreams streams(benchDevice(), 2);
    const auto [left, right] = scene::eyesOf(wideView().camera, wideView().worldFromEye, 0.063);
    const std::array views{left, right};
    std::array<EyeWork, 2> eyes;
    for (EyeWork& eye : eyes)
        eye.target = makeEyeTarget(benchDevice(), eyeLayout, 640, 480);
    for (EyeWork& eye : eyes)
        makeRoomForDraws(benchDevice(), eye.target, scene.tiles().size());

    const auto work = [&](std::size_t i) {
        EyeWork& eye = eyes[i];
        eye.sources = sourceViewsOf(scene.images(), views[i], {});
        eye.planes.clear();
        for (std::size_t k = 0; k < eye.sources.size(); ++k)
            eye.planes.push_back(planesOf(eye.sources[k].eyeImageFromSource, 640, 480, 3, scene.images()[k].extent));
        eye.visible.pieces = numbersOf(scene.pieces());
        cull(
            scene.bounds(), scene.pieces(), [&](const TilePiece& piece) { return eye.planes[piece.image]; },
            eye.visible);
        chooseDraws(scene.index(), scene.places(), eye.sources, eye.visible, {}, eye.list);
        writeDraws(scene.index(), scene.places(), eye.sources, eye.list, eye.target.draws[0].as<TileDraw>());
        const VkCommandBuffer commands = streams.begin(0, static_cast<int>(i));
        recordWarp(commands, warps, scene, eye.target.sets[0], eye.list.runs, 640, 480);
        vkEndCommandBuffer(commands);
    };
    tbb::task_arena one(1);
    double atOnce = kNever, inTurn = kNever;
    for (auto _ : state) {
        one.execute([&] { inTurn = std::min(inTurn, millisecondsOf([&] { work(0), work(1); })); });
        atOnce = std::min(atOnce, millisecondsOf([&] { tbb::parallel_for(std::size_t{0}, std::size_t{2}, work); }));
    }
    state.counters["tiles"] = static_cast<double>(scene.tiles().size());
    state.counters["drawn"] = eyes[0].list.tiles;
    state.counters["in_turn_ms"] = inTurn;
    state.counters["at_once_ms"] = atOnce;
    state.counters["ratio"] = atOnce / inTurn;
}
BENCHMARK(eyesAtOnceAgainstInTurn)->Iterations(60)->Unit(benchmark::kMillisecond);

} // namespace
} // namespace render
