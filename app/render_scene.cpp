#include "app/render_scene.h"

#include "app/frame_pictures.h"
#include "app/frame_report.h"
#include "app/progress.h"
#include "app/scene_memory.h"
#include "app/stage_store.h"
#include "app/view_files.h"

#include "render/renderer.h"
#include "scene/errors.h"
#include "scene/scene_file.h"
#include "scene/view.h"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <optional>

namespace app {

namespace {

constexpr int kDefaultWidth = 640, kDefaultHeight = 480;
constexpr double kDefaultFieldOfViewRadians =
    1.2; ///< across, for paths: about what a headset's eye sees of a 4:3 picture

scene::Camera pathCamera(const RenderOptions& o) {
    const int width = o.width > 0 ? o.width : kDefaultWidth, height = o.height > 0 ? o.height : kDefaultHeight;
    const double focal = width / (2 * std::tan(kDefaultFieldOfViewRadians / 2));
    return {width, height, focal, focal, width / 2.0, height / 2.0};
}

std::vector<NamedView> listViews(const RenderOptions& o, const scene::Scene& scene) {
    if (!o.path.empty()) return readPathFile(o.path, scene.walkFromWorld, pathCamera(o));
    std::vector<NamedView> views = o.cameras.empty() ? heldOutViews(scene) : readCamerasFile(o.cameras);
    if (views.empty())
        throw scene::Failure("has no held-out cameras to draw", o.scene, "give --path FILE or --cameras FILE");
    for (NamedView& view : views)
        if (o.width > 0) view.camera = scene::resized(view.camera, o.width, o.height);
    return views;
}

} // namespace

void renderScene(const RenderOptions& options) {
    const scene::Scene scene = scene::openScene(options.scene);
    const std::vector<NamedView> views = listViews(options, scene);
    const int eyes = options.eyes > 0 ? options.eyes : options.path.empty() ? 1 : 2;
    const render::Quality quality = qualityOf(options.draw);
    const render::Device device;
    render::GpuScene gpuScene(device, scene.blocks, memoryFor(options.draw));
    DamageTeller damage;

    std::optional<render::GpuCoverage> coverage;
    if (scene.coverage && quality.showUnseen) coverage.emplace(device, *scene.coverage);

    std::error_code error;
    std::filesystem::create_directories(options.out, error);
    if (error)
        throw scene::Failure("cannot be made (" + error.message() + ")", options.out,
                             "check that the folder may be written");

    FrameReport report;
    std::optional<render::Renderer> renderer;
    scene::Camera drawn;
    Progress progress("render", views.size());
    for (const NamedView& view : views) {
        if (!renderer || view.camera.width != drawn.width || view.camera.height != drawn.height) {
            renderer.reset();
            renderer.emplace(device, gpuScene, view.camera.width, view.camera.height, eyes,
                             coverage ? &*coverage : nullptr);
        }
        drawn = view.camera;
        std::vector<scene::View> eyeViews{{view.camera, view.worldFromCamera}};
        if (eyes == 2) {
            const auto [left, right] = scene::eyesOf(view.camera, view.worldFromCamera, options.draw.eyeDistanceMetres);
            eyeViews = {left, right};
        }
        gpuScene.settle(eyeViews, quality);
        for (const std::string& sentence : damage.news(gpuScene, scene))
            std::fprintf(stderr, "revisit: %s\n", sentence.c_str());
        const auto start = std::chrono::steady_clock::now();
        renderer->draw(eyeViews, quality);
        const render::FrameStats stats = renderer->finish();
        const std::chrono::duration<double, std::milli> passed = std::chrono::steady_clock::now() - start;
        report.add(stats, passed.count());

        const std::vector<render::EyeImage> images = renderer->readBack();
        for (std::size_t eye = 0; eye < images.size(); ++eye)
            writePictures(images[eye], options.out,
                          view.name + (eyes == 1  ? ""
                                       : eye == 0 ? "-left"
                                                  : "-right"),
                          options.aux);
        progress.advance();
    }
    nlohmann::json settings{{"scene", options.scene.string()},
                            {"width", drawn.width},
                            {"height", drawn.height},
                            {"eyes", eyes},
                            {"ipd_m", options.draw.eyeDistanceMetres}};
    settings.update(toJson(quality));
    settings["shows_unseen"] = coverage.has_value();
    settings["damaged_chunks"] = damage.chunks();
    writeWhole(options.out / "report.json",
               report.summarise(device, gpuScene, settings)
                       .dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + // paths need not be UTF-8
                   "\n");
}

} // namespace app
