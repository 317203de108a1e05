#pragma once
// What is drawn, by whichever command: a scene, and polygons that stand in it besides.

#include "app/draw_options.h"

#include "render/gpu_polygons.h"
#include "render/gpu_scene.h"
#include "render/post/unseen.h"
#include "scene/polygon_scene.h"
#include "scene/scene.h"

#include <memory>
#include <optional>

namespace app {

/// Lent the scene.
struct DrawnScene {
    const scene::Scene& scene;
    std::optional<scene::PolygonScene> polygons; ///< world coordinates
    render::SceneMemory memory;
    bool mayShowUnseen = true;
    double leastCoverageCellMetres = 0; ///< CoverageWish

    /// Reads the polygons, and tells what was left out of them. Throws scene::Failure.
    DrawnScene(const scene::Scene& scene, const DrawOptions& options);
    /// Without any, and all of the scene.
    explicit DrawnScene(const scene::Scene& given) : scene(given) {}
};

/// The same on a device, which must outlive it.
struct DeviceScene {
    std::unique_ptr<render::GpuScene> images;
    std::unique_ptr<render::GpuCoverage> coverage; ///< null if the scene has none, or the device no room for it
    std::unique_ptr<render::GpuPolygons> polygons; ///< null if there are none

    /// By which unseen space hides what is brought last; null where it is not shown, or not as it was found.
    const scene::Coverage* hidingCoverage() const { return coverage ? coverage->lent() : nullptr; }
};

/// Throws scene::Failure, render::OutOfMemory or render::DeviceLost.
DeviceScene bringTo(const render::Device& device, const DrawnScene& drawn);

} // namespace app
