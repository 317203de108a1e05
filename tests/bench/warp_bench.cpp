// The warp on the processor: samples a second, and what share of the bare loop's speed that is. Both are timed in turn,
// so that what else the machine does meets both; clearing, drawing and joining the threads' z-buffers count.

#include "scene/warp.h"
#include "tests/bench/bare_warp.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <vector>

#include <benchmark/benchmark.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>

namespace scene {
namespace {

constexpr int kSourceSize = 2048, kEyeSize = 1024;
constexpr std::size_t kPixels = std::size_t{kEyeSize} * kEyeSize;

/// Waves and steps, seen with a field of view of 90 degrees; the eye stands 23 cm away and looks 3 degrees to the side.
const DepthImage& source() {
    static const DepthImage image = [] {
        const Camera camera{kSourceSize,       kSourceSize,       kSourceSize / 2.0,
                            kSourceSize / 2.0, kSourceSize / 2.0, kSourceSize / 2.0};
        DepthImage made{
            "waves", camera, {}, {kSourceSize, kSourceSize}, {kSourceSize, kSourceSize}, {kSourceSize, kSourceSize}};
        for (int y = 0; y < kSourceSize; ++y)
            for (int x = 0; x < kSourceSize; ++x) {
                const glm::dvec3 ray = rayThrough(camera, x + 0.5, y + 0.5);
                const double step = (x / 64 + y / 64) % 7 == 0 ? -0.8 : 0.0;
                const double z = 3 + std::sin(7 * ray.x) * 0.5 + std::cos(5 * ray.y) * 0.5 + step;
                made.disparity(x, y) = static_cast<float>(1 / z);
                made.colour(x, y) = {static_cast<std::uint8_t>(x), static_cast<std::uint8_t>(y),
                                     static_cast<std::uint8_t>(x ^ y)};
            }
        return made;
    }();
    return image;
}

View eye() {
    const Pose worldFromEye = poseFromQuaternion({0.1, 0.05, 0.2}, 0, std::sin(0.025), 0, std::cos(0.025));
    return {{kEyeSize, kEyeSize, kEyeSize / 2.0, kEyeSize / 2.0, kEyeSize / 2.0, kEyeSize / 2.0}, worldFromEye};
}

double secondsOf(const auto& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double medianOf(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/// Calls resolve(i) for each pixel of the eye, in parallel.
void resolvePixels(const auto& resolve) {
    constexpr std::size_t kPiece = 1 << 14;
    tbb::parallel_for(std::size_t{0}, kPixels / kPiece, [&](std::size_t piece) {
        for (std::size_t i = piece * kPiece; i < (piece + 1) * kPiece; ++i)
            resolve(i);
    });
}

/// The samples as points, and a z-buffer a thread, allocated before anything is timed.
class BareWarp {
  public:
    explicit BareWarp(std::size_t threads) : joined_(kPixels) {
        const DepthImage& image = source();
        for (int y = 0; y < kSourceSize; ++y)
            for (int x = 0; x < kSourceSize; ++x) {
                const glm::dvec3 point =
                    rayThrough(image.camera, x + 0.5, y + 0.5) / static_cast<double>(image.disparity(x, y));
                const Rgb8 c = image.colour(x, y);
                samples_.push_back({static_cast<float>(point.x), static_cast<float>(point.y),
                                    static_cast<float>(point.z),
                                    static_cast<std::uint32_t>(c.r | c.g << 8 | c.b << 16)});
            }
        // (u w, v w, w, w - 0.1 m): depth grows from 0 at 10 cm to 1.
        const glm::dmat4 seen =
            eyeImageFromSourceImage(eye(), image.camera, image.worldFromCamera) * imageFromCamera(image.camera);
        for (int c = 0; c < 4; ++c)
            imageFromPoint_[c] = glm::vec4(seen[c].x, seen[c].y, seen[c].z - (c == 3 ? 0.1 : 0.0), seen[c].z);
        for (std::size_t i = 0; i < threads; ++i)
            buffers_.emplace_back(kPixels + 1);
    }

    void draw() {
        const std::size_t share = samples_.size() / buffers_.size();
        tbb::parallel_for(
            std::size_t{0}, buffers_.size(),
            [&](std::size_t i) {
                std::memset(buffers_[i].data(), 0xff, buffers_[i].size() * sizeof(std::uint64_t));
                warpBare(std::span(samples_).subspan(i * share, share), imageFromPoint_,
                         {kEyeSize, kEyeSize, buffers_[i].data()});
            },
            tbb::static_partitioner());
        resolvePixels([&](std::size_t i) {
            std::uint64_t least = buffers_[0][i];
            for (std::size_t b = 1; b < buffers_.size(); ++b)
                least = std::min(least, buffers_[b][i]);
            joined_[i] = static_cast<std::uint32_t>(least);
        });
        benchmark::DoNotOptimize(joined_.data());
    }

  private:
    std::vector<BareSample> samples_;
    std::vector<std::vector<std::uint64_t>> buffers_;
    std::vector<std::uint32_t> joined_;
    glm::mat4 imageFromPoint_{0};
};

void pointsAndBareLoop(benchmark::State& state) {
    const auto threads = static_cast<std::size_t>(state.range(0));
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    BareWarp bare(threads);
    const TileSet tiles = cutIntoTiles(source());
    const TileBlock block = lend(tiles, source().camera, source().worldFromCamera);
    const View view = eye();
    ZBuffer zBuffer(kEyeSize, kEyeSize);
    std::vector<std::uint32_t> colours(kPixels);

    const auto drawPoints = [&] {
        std::fill(zBuffer.pixels().begin(), zBuffer.pixels().end(), 0);
        warpPoints({&block, 1}, view, {}, zBuffer);
        resolvePixels([&](std::size_t i) { colours[i] = static_cast<std::uint32_t>(zBuffer.pixels()[i]) >> 8; });
        benchmark::DoNotOptimize(colours.data());
    };
    bare.draw(), drawPoints();
    std::vector<double> bareSeconds, seconds;
    for (auto _ : state) {
        bareSeconds.push_back(secondsOf([&] { bare.draw(); }));
        seconds.push_back(secondsOf(drawPoints));
        state.SetIterationTime(seconds.back());
    }
    const double samples = static_cast<double>(tiles.vertices.size());
    const double bareRate = kSourceSize * kSourceSize / medianOf(bareSeconds), rate = samples / medianOf(seconds);
    state.counters["bareSamples/s"] = bareRate;
    state.counters["samples/s"] = rate;
    state.counters["ofBareLoop"] = rate / bareRate;
}
BENCHMARK(pointsAndBareLoop)
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2)
    ->Iterations(30)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

template <auto kWarp>
void warpTiles(benchmark::State& state) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(state.range(0)));
    const TileSet tiles = cutIntoTiles(source());
    TileBlock block = lend(tiles, source().camera, source().worldFromCamera);
    block.tiles = block.tiles.first(std::min(block.tiles.size(), static_cast<std::size_t>(state.range(1))));
    WarpOptions options;
    options.maxFootprint = static_cast<int>(state.range(2));
    options.footprintScale = static_cast<float>(kSourceSize) / kEyeSize * static_cast<float>(options.maxFootprint);
    const View view = eye();
    ZBuffer zBuffer(kEyeSize, kEyeSize);
    double samples = 0;
    for (const Tile& tile : block.tiles)
        samples += tile.pointCount;
    for (auto _ : state) {
        state.PauseTiming();
        std::fill(zBuffer.pixels().begin(), zBuffer.pixels().end(), 0);
        state.ResumeTiming();
        kWarp({&block, 1}, view, options, zBuffer);
    }
    state.counters["samples/s"] = benchmark::Counter(samples, benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(warpTiles<warpPoints>)
    ->ArgNames({"threads", "tiles", "footprint"})
    ->ArgsProduct({{1, 2}, {1, 16, 256, 4096}, {1}})
    ->ArgsProduct({{1, 2}, {4096}, {2, 3}})
    ->UseRealTime()
    ->Unit(benchmark::kMicrosecond);
BENCHMARK(warpTiles<warpMesh>)
    ->ArgNames({"threads", "tiles", "footprint"})
    ->ArgsProduct({{1, 2}, {256, 4096}, {1}})
    ->UseRealTime()
    ->Unit(benchmark::kMicrosecond);

} // namespace
} // namespace scene
