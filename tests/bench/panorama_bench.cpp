// What culling is worth where scanners leave one: amid panoramic scans of a room, one head's turn all round. Scans are
// made as `revisit build` makes them tiles: cube faces, skins cut, each surface kept where it was sampled best.

#include "render/renderer.h"
#include "scene/image_store.h"
#include "scene/median.h"
#include "scene/overlap.h"
#include "scene/project/cube_faces.h"
#include "scene/refine/redundancy.h"
#include "scene/refine/skins.h"
#include "scene/synthetic.h"
#include "tests/render/test_scenes.h"

#include <benchmark/benchmark.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <vector>

namespace render {
namespace {

constexpr int kColumns = 2400, kRows = 1000; ///< 2.6 mm between samples for each metre of range
constexpr int kDirections = 40;
constexpr double kFieldOfView = 1.92; ///< 110 degrees, as a head-mounted display has

struct Panoramas {
    CutScene scene;
    glm::dvec3 middle{0}; ///< of where the scanners stood
};

Panoramas scanRoom() {
    const scene::SyntheticScene room = scene::makeRoom();
    Panoramas result;
    const std::vector<scene::Pose> scanners = scene::scanPositions(room);
    for (std::size_t i = 0; i < scanners.size(); ++i) {
        result.middle += scanners[i].translation / static_cast<double>(scanners.size());
        scene::Scan scan = scene::simulateScan(room, scanners[i], kColumns, kRows);
        scan.name = "scan" + std::to_string(i);
        for (scene::DepthImage& face : scene::projectToCubeFaces(scan).faces)
            result.scene.images.push_back(std::move(face));
    }
    std::vector<scene::DepthImage>& images = result.scene.images;
    std::vector<scene::ImageOutline> outlines;
    for (const scene::DepthImage& image : images)
        outlines.push_back(scene::outlineOf(image));
    const auto partners = scene::findPartners(outlines);
    scene::ImageStore taken(images);
    tbb::parallel_for(std::size_t{0}, images.size(), [&](std::size_t i) {
        scene::SkinFigures figures;
        images[i].flags = scene::markSkins(taken, i, partners[i], {}, figures);
    });
    scene::ImageStore marked(images);
    scene::RedundancyFigures figures;
    const std::vector<scene::KeepMap> kept = scene::findKept(marked, partners, {}, figures);
    for (std::size_t i = 0; i < images.size(); ++i)
        for (int y = 0; y < images[i].flags.height(); ++y)
            for (int x = 0; x < images[i].flags.width(); ++x)
                if (!kept[i].has(x, y)) images[i].flags(x, y) |= scene::kRedundant;
    result.scene = cut(std::move(images));
    return result;
}

double sumOf(const std::vector<StepTime>& times, const char* step) {
    double sum = 0;
    for (const StepTime& time : times)
        if (std::strcmp(time.step, step) == 0) sum += time.milliseconds;
    return sum;
}

/// Shares of the tiles that are rejected, and of the time of warping that it takes to find them, over all directions.
void cullingAmidPanoramas(benchmark::State& state, Warp warp) {
    static const Device device;
    static const Panoramas place = scanRoom();
    const auto blocks = place.scene.blocks();
    const GpuScene gpuScene(device, blocks);
    Renderer renderer(device, gpuScene, 640, 480, 1);
    const Quality quality{.warp = warp};
    // The room's height is z; poseAt looks along a level world whose y is down.
    const scene::Pose zUp{glm::dmat3(1, 0, 0, 0, 0, -1, 0, 1, 0), place.middle};
    std::vector<double> rejected, culls, warps;
    FrameStats stats;
    for (auto _ : state)
        for (int i = 0; i < kDirections; ++i) {
            const scene::View view{cameraOf(640, 480, kFieldOfView),
                                   zUp * poseAt(glm::dvec3(0), 2 * 3.14159265358979 * i / kDirections, 0.1)};
            renderer.draw(std::span(&view, 1), quality);
            stats = renderer.finish();
            rejected.push_back(static_cast<double>(stats.eyes[0].tilesRejected) / stats.eyes[0].tilesTested);
            culls.push_back(sumOf(stats.cpu, "cull"));
            warps.push_back(sumOf(stats.gpu, "warp"));
        }
    state.counters["tiles"] = stats.eyes[0].tilesTested;
    state.counters["rejected_share"] = scene::medianOf(rejected);
    state.counters["rejected_share_least"] = *std::min_element(rejected.begin(), rejected.end());
    state.counters["rejected_share_most"] = *std::max_element(rejected.begin(), rejected.end());
    state.counters["cull_ms"] = scene::medianOf(culls);
    state.counters["warp_ms"] = scene::medianOf(warps);
    state.counters["cull_of_warp"] = scene::medianOf(culls) / scene::medianOf(warps);
}
BENCHMARK_CAPTURE(cullingAmidPanoramas, points, Warp::points)->Iterations(5)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(cullingAmidPanoramas, mesh, Warp::mesh)->Iterations(5)->Unit(benchmark::kMillisecond);

} // namespace
} // namespace render
