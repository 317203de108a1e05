// What the mesh of each sample costs when it is drawn as the article drew it (Nyland et al. 1999, section 5): two
// triangles a sample, by the device's own rasteriser; beside the ways in which it is drawn here, from the scene's own
// places, without coarser levels. The triangles are of base tiles alone; the others draw directional ones, too.
// The scene is the one that ./dev demo builds, or another that REVISIT_BENCH_SCENE names.

#include "render/gpu_polygons.h"
#include "render/renderer.h"
#include "scene/median.h"
#include "scene/srgb.h"
#include "tests/bench/device_time.h"
#include "tests/bench/given_scene.h"
#include "tests/render/test_scenes.h"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace render {
namespace {

/// Adds the triangles of a tile's squares; camera coordinates.
void addSquares(scene::PolygonMesh& mesh, const scene::TileBlock& block, const scene::Tile& tile) {
    const auto base = static_cast<std::uint32_t>(mesh.positions.size());
    for (const scene::TileVertex& vertex : block.vertices.subspan(tile.firstVertex, tile.vertexCount)) {
        const scene::VertexPlace place = scene::placeOf(tile, vertex);
        const glm::dvec3 ray = scene::rayThrough(block.camera, tile.x0 + place.x + 0.5, tile.y0 + place.y + 0.5);
        mesh.positions.emplace_back(ray / std::max(1e-6, static_cast<double>(scene::disparityOf(tile, vertex))));
        const auto linear = [&](int shift) {
            return scene::linearFromSrgb(static_cast<std::uint8_t>(vertex.colour >> shift));
        };
        mesh.colours.emplace_back(linear(0), linear(8), linear(16));
    }
    for (const scene::TileQuad& quad : block.quads.subspan(tile.firstQuad, tile.quadCount)) {
        const auto corner = [&](std::uint32_t half) { return base + (half & scene::kQuadIndexMask); };
        const std::uint32_t i00 = corner(quad.top), i10 = corner(quad.top >> 16), i01 = corner(quad.bottom),
                            i11 = corner(quad.bottom >> 16);
        if ((quad.top & scene::kDrawUpper) != 0) mesh.triangles.push_back({i00, i10, i01});
        if ((quad.bottom & scene::kDrawLower) != 0) mesh.triangles.push_back({i10, i11, i01});
    }
}

/// Of base tiles of the finest level; some tiles of an image together, so that those out of view are passed over.
scene::PolygonScene trianglesOf(std::span<const scene::TileBlock> blocks) {
    constexpr std::size_t kTilesTogether = 16;
    scene::PolygonScene scene;
    scene.materials.push_back({"samples", glm::vec3(1)});
    for (const scene::TileBlock& block : blocks) {
        for (std::size_t first = 0; first < block.tiles.size(); first += kTilesTogether) {
            scene::PolygonMesh mesh;
            for (std::size_t i = first; i < std::min(first + kTilesTogether, block.tiles.size()); ++i)
                if (scene::isForAllEyes(block.tiles[i].tier)) addSquares(mesh, block, block.tiles[i]);
            if (mesh.triangles.empty()) continue;
            scene.instances.push_back(
                {static_cast<std::uint32_t>(scene.meshes.size()), toMatrix(block.worldFromCamera)});
            scene.meshes.push_back(std::move(mesh));
        }
    }
    return scene;
}

constexpr int kPlaces = 24; ///< along the capture

void trianglesOfEverySample(benchmark::State& state) {
    const scene::Scene* const part = givenScene(state);
    if (part == nullptr) return;
    // A device each: once a device has rasterised, lavapipe's steps of compute shaders no longer begin and end where
    // they are timed.
    static const Device device, rasterising;
    const GpuScene samples(device, part->blocks), nothing(rasterising, {});
    const GpuPolygons triangles(rasterising, trianglesOf(part->blocks), {0, -1, 0});
    Renderer ofSamples(device, samples, 640, 480, 2);
    Renderer ofTriangles(rasterising, nothing, 640, 480, 2, nullptr, &triangles);
    constexpr std::array kWays{std::pair{"points", Warp::points}, std::pair{"splats", Warp::splats},
                               std::pair{"mesh", Warp::mesh}, std::pair{"adaptive", Warp::adaptive}};
    std::map<std::string, std::vector<double>> times;
    std::uint64_t drawn = 0, frames = 0;
    for (auto _ : state) {
        const std::size_t place = frames++ * part->images.size() / kPlaces;
        const auto [left, right] = scene::eyesOf(cameraOf(640, 480, 1.2), part->images[place].worldFromCamera, 0.063);
        const std::array views{left, right};
        Quality quality;
        quality.samplePixels = 0;
        for (const auto& [name, warp] : kWays) {
            quality.warp = warp;
            ofSamples.draw(views, quality);
            times[name].push_back(deviceTimeOf(ofSamples.finish(), "warp"));
        }
        ofTriangles.draw(views, quality);
        const FrameStats stats = ofTriangles.finish();
        times["triangles"].push_back(deviceTimeOf(stats, "polygons"));
        drawn += stats.eyes[0].trianglesDrawn + stats.eyes[1].trianglesDrawn;
    }
    // Place by place, so that what else the machine does meets all alike.
    for (const auto& [name, warp] : kWays) {
        std::vector<double> ratios;
        for (std::size_t i = 0; i < times[name].size(); ++i)
            ratios.push_back(times[name][i] / times["triangles"][i]);
        state.counters[std::string(name) + "_of_triangles"] = scene::medianOf(ratios);
    }
    for (auto& [name, milliseconds] : times)
        state.counters["ms_" + name] = scene::medianOf(milliseconds);
    state.counters["triangles"] = static_cast<double>(drawn) / static_cast<double>(frames);
}
BENCHMARK(trianglesOfEverySample)->Iterations(kPlaces)->Unit(benchmark::kMillisecond);

} // namespace
} // namespace render
