#include "app/drawn_scene.h"

#include "app/coverage_on_device.h"

#include "render/device.h"
#include "scene/import/polygons.h"

#include <algorithm>
#include <cstdio>

#include <glm/matrix.hpp>

namespace app {

DrawnScene::DrawnScene(const scene::Scene& given, const DrawOptions& options) : scene(given) {
    // All of --memory is for the device; what of the file lies in the system's cache can be taken back at any time.
    memory.budgetBytes = options.memoryBytes;
    mayShowUnseen = !options.hideUnseen;
    leastCoverageCellMetres = options.coverageCellMetres;
    if (options.polygons.empty()) return;
    polygons = scene::readPolygons(options.polygons);
    for (const std::string& remark : polygons->remarks)
        std::fprintf(stderr, "note: %s\n", remark.c_str());
}

DeviceScene bringTo(const render::Device& device, const DrawnScene& drawn) {
    DeviceScene brought;
    if (drawn.polygons) {
        const glm::dvec3 up = glm::transpose(drawn.scene.walkFromWorld.rotation) * glm::dvec3(0, 1, 0);
        brought.polygons = std::make_unique<render::GpuPolygons>(device, *drawn.polygons, up);
    }
    // Coverage and images take what is left; pictures, z-buffers and what a headset's runtime needs have their place
    // beside them.
    render::SceneMemory memory = drawn.memory;
    memory.budgetBytes = std::min(memory.budgetBytes, device.roomBytes() / 4 * 3);
    std::optional<CoverageForm> form;
    if (drawn.mayShowUnseen && drawn.scene.coverage) {
        const std::size_t share = memory.budgetBytes / 4;
        form = formOf(*drawn.scene.coverage, device,
                      {.leastCellMetres = drawn.leastCoverageCellMetres, .mostBytes = share});
        // Its coarsest form may be more than that; images shall not have to go for it.
        memory.budgetBytes -= std::min(form->bytes, share);
    }
    brought.images = std::make_unique<render::GpuScene>(device, drawn.scene.blocks, memory);
    if (form) brought.coverage = bringCoverage(device, *drawn.scene.coverage, *form);
    return brought;
}

} // namespace app
