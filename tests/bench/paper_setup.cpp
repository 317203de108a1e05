// The set-up of the article on Delaunay cells (section 7), in stereo: four positions, each with six images of 400x400,
// drawn at 640x480 over 20 degrees, beside the polygons themselves, rasterised on the same device and ray-traced on the
// processor; and all of it again with each triangle divided into 4 and into 16, which look the same. A JSON and a
// table.
//
//   revisit_paper_setup OUT.json SCENE.obj [FRAMES]

#include "tests/bench/captured_cube.h"

#include "render/renderer.h"
#include "scene/capture/polygon_view.h"
#include "scene/capture/spread_positions.h"
#include "scene/errors.h"
#include "scene/import/polygons.h"
#include "scene/plan/sight_search.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <numbers>
#include <random>

#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

namespace {

using nlohmann::json;

constexpr int kPositions = 4, kFaceSize = 400, kWidth = 640, kHeight = 480;
constexpr double kFieldOfView = 20 * std::numbers::pi / 180, kEyeDistance = 0.063;
constexpr std::array kDivisions{0, 1, 2};

/// Each triangle in four, by the middles of its edges; corners stay shared.
scene::PolygonMesh divided(const scene::PolygonMesh& mesh) {
    scene::PolygonMesh fine = mesh;
    fine.triangles.clear();
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middleOf = [&](std::uint32_t a, std::uint32_t b) {
        const auto [there, isNew] = middles.try_emplace(std::minmax(a, b), fine.positions.size());
        if (isNew) {
            const auto append = [&](auto& values) {
                if (!values.empty()) values.push_back((values[a] + values[b]) * 0.5f);
            };
            append(fine.positions), append(fine.normals), append(fine.texturePlaces), append(fine.colours);
        }
        return there->second;
    };
    for (const auto& [a, b, c] : mesh.triangles) {
        const std::uint32_t ab = middleOf(a, b), bc = middleOf(b, c), ca = middleOf(c, a);
        fine.triangles.push_back({a, ab, ca});
        fine.triangles.push_back({ab, b, bc});
        fine.triangles.push_back({ca, bc, c});
        fine.triangles.push_back({ab, bc, ca});
    }
    return fine;
}

/// One number of triangles: what there is of it on the device and off.
class Variant {
  public:
    Variant(const render::Device& device, scene::PolygonScene given, const std::vector<glm::dvec3>& positions)
        : polygons_(std::move(given)), tracer_(polygons_), light_(tracer_, {}), none_(device, {}),
          gpuPolygons_(device, polygons_, {0, 1, 0}),
          rasteriser_(device, none_, kWidth, kHeight, 2, nullptr, &gpuPolygons_) {
        std::vector<scene::TileBlock> blocks;
        for (const glm::dvec3& position : positions)
            cubes_.push_back(captureForWarp(tracer_, light_, position, kFaceSize));
        for (const std::vector<CapturedFace>& cube : cubes_)
            addBlocks(cube, blocks);
        images_ = std::make_unique<render::GpuScene>(device, blocks);
        warper_ = std::make_unique<render::Renderer>(device, *images_, kWidth, kHeight, 2);
    }

    std::int64_t triangles() const { return countTriangles(polygons_); }

    void warp(std::span<const scene::View> eyes, render::Warp warp) {
        render::Quality quality;
        quality.warp = warp;
        quality.walksByCells = false; // the walker is in the one cell
        warper_->draw(eyes, quality);
        warper_->finish();
    }
    void rasterise(std::span<const scene::View> eyes) {
        rasteriser_.draw(eyes, {});
        rasteriser_.finish();
    }
    void trace(std::span<const scene::View> eyes) const {
        scene::PolygonViewOptions options;
        options.raysAcross = 1;
        for (const scene::View& eye : eyes)
            renderPolygons(tracer_, light_, eye, options);
    }

  private:
    scene::PolygonScene polygons_;
    scene::PolygonTracer tracer_;
    scene::SurfaceLight light_;
    std::vector<std::vector<CapturedFace>> cubes_;
    render::GpuScene none_;
    render::GpuPolygons gpuPolygons_;
    render::Renderer rasteriser_;
    std::unique_ptr<render::GpuScene> images_;
    std::unique_ptr<render::Renderer> warper_;
};

/// Between the positions, to all sides.
std::vector<std::array<scene::View, 2>> viewsBetween(const std::vector<glm::dvec3>& positions, int count) {
    std::mt19937 generator(1998);
    std::uniform_real_distribution<double> unit(0, 1);
    const double focal = kWidth / 2.0 / std::tan(kFieldOfView / 2);
    const scene::Camera camera{kWidth, kHeight, focal, focal, kWidth / 2.0, kHeight / 2.0};
    std::vector<std::array<scene::View, 2>> views;
    for (int i = 0; i < count; ++i) {
        glm::dvec3 sum(0);
        double weights = 0;
        for (const glm::dvec3& position : positions) {
            const double weight = unit(generator);
            sum += weight * position, weights += weight;
        }
        const double yaw = 2 * std::numbers::pi * unit(generator);
        const glm::dvec3 ahead(std::sin(yaw), 0, -std::cos(yaw)), right(std::cos(yaw), 0, std::sin(yaw));
        const auto [left, other] =
            scene::eyesOf(camera, {glm::dmat3(right, glm::cross(ahead, right), ahead), sum / weights}, kEyeDistance);
        views.push_back({left, other});
    }
    return views;
}

/// What the machine does beside meets all numbers of triangles at a place alike: the median of the ratios of times at
/// each place tells less of it than the ratio of the medians.
double ratioOf(const std::vector<double>& milliseconds, const std::vector<double>& toThese) {
    std::vector<double> ratios;
    for (std::size_t i = 0; i < milliseconds.size(); ++i)
        ratios.push_back(milliseconds[i] / toThese[i]);
    std::sort(ratios.begin(), ratios.end());
    return ratios[ratios.size() / 2];
}

struct Times {
    std::vector<double> milliseconds; ///< place by place
    json toJson(const Times& first) const {
        const double ratio = ratioOf(milliseconds, first.milliseconds);
        std::vector<double> sorted = milliseconds;
        std::sort(sorted.begin(), sorted.end());
        const auto at = [&](double share) {
            return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
        };
        return {{"median_ms", at(0.5)},
                {"p99_ms", at(0.99)},
                {"frames_per_second", 1000 / at(0.5)},
                {"times_the_first", ratio}};
    }
};

json measure(const std::filesystem::path& file, int frames) {
    const render::Device device;
    scene::PolygonScene polygons = scene::readPolygons(file);
    std::vector<glm::dvec3> positions;
    {
        const scene::PolygonTracer tracer(polygons);
        scene::SightSearchOptions options;
        options.count = kPositions;
        positions = searchBySight(standingPlaces(tracer), sightLinesOf(tracer), options).positions;
    }
    std::vector<std::unique_ptr<Variant>> variants;
    for (std::size_t i = 0; i < kDivisions.size(); ++i) {
        if (i > 0)
            for (scene::PolygonMesh& mesh : polygons.meshes)
                mesh = divided(mesh);
        variants.push_back(std::make_unique<Variant>(device, polygons, positions));
        std::printf("%lld triangles captured\n", static_cast<long long>(variants.back()->triangles()));
        std::fflush(stdout);
    }
    using Draw = std::function<void(Variant&, std::span<const scene::View>)>;
    const std::vector<std::pair<std::string, Draw>> ways{
        {"points", [](Variant& v, auto eyes) { v.warp(eyes, render::Warp::points); }},
        {"splats", [](Variant& v, auto eyes) { v.warp(eyes, render::Warp::splats); }},
        {"mesh", [](Variant& v, auto eyes) { v.warp(eyes, render::Warp::mesh); }},
        {"polygons", [](Variant& v, auto eyes) { v.rasterise(eyes); }},
        {"ray tracer", [](Variant& v, auto eyes) { v.trace(eyes); }}};
    std::map<std::string, std::array<Times, kDivisions.size()>> times;
    // Every way and number of triangles at every place in turn. The second of two looks is timed: in the first the ray
    // tracer finds its light, and what another way left in the processor's caches goes.
    std::size_t view = 0;
    for (const auto& eyes : viewsBetween(positions, frames)) {
        ++view;
        for (const auto& [name, draw] : ways)
            for (std::size_t turn = 0; turn < variants.size(); ++turn) {
                const std::size_t i = (view + turn) % variants.size(); // none is always the first
                draw(*variants[i], eyes);
                const auto start = std::chrono::steady_clock::now();
                draw(*variants[i], eyes);
                const std::chrono::duration<double, std::milli> passed = std::chrono::steady_clock::now() - start;
                times[name][i].milliseconds.push_back(passed.count());
            }
    }
    json result{{"scene", file.filename().string()}, {"device", device.name()}, {"frames", frames}};
    for (const auto& variant : variants)
        result["triangles"].push_back(variant->triangles());
    for (const auto& [name, draw] : ways)
        for (const Times& one : times[name])
            result["ways"][name].push_back(one.toJson(times[name].front()));
    return result;
}

} // namespace

int main(int argc, char** argv) {
    if (argc < 3) {
        std::fprintf(stderr, "usage: revisit_paper_setup OUT.json SCENE.obj [FRAMES]\n");
        return 2;
    }
    try {
        const json result = measure(argv[2], argc > 3 ? std::max(2, std::atoi(argv[3])) : 40);
        std::ofstream(argv[1]) << result.dump(1) << "\n";
        std::printf("\n| frames a second, median |");
        for (const json& triangles : result["triangles"])
            std::printf(" %lld triangles |", triangles.get<long long>());
        std::printf("\n|---|---|---|---|\n");
        for (const auto& [name, spreads] : result["ways"].items()) {
            std::printf("| %s |", name.c_str());
            for (const json& spread : spreads)
                std::printf(" %.1f (%.1f ms, p99 %.1f; x%.3f) |", spread["frames_per_second"].get<double>(),
                            spread["median_ms"].get<double>(), spread["p99_ms"].get<double>(),
                            spread["times_the_first"].get<double>());
            std::printf("\n");
        }
    } catch (const scene::Failure& failure) {
        std::fprintf(stderr, "revisit_paper_setup: %s\n", failure.what());
        return 1;
    }
}
