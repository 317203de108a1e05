#include "app/drawn_scene.h"

#include "app/coverage_on_device.h"
#include "app/say.h"
#include "render/device.h"
#include "scene/import/polygons.h"

#include <algorithm>

#include <glm/matrix.hpp>

namespace app {

DrawnScene::DrawnScene(const scene::Scene& given, const DrawOptions& options) : scene(given) {
    // All of --memory is for the device; what of the file lies in the system's cache can be taken back at any time.
    memory.budgetBytes = options.memoryBytes;
    mayShowUnseen = !options.hideUnseen;
    leastCoverageCellMetres = options.coverageCellMetres;
    if (leastCoverageCellMetres > 0 && !scene.coverage)
        sayNote("--coverage-cell changes nothing: the scene does not say what was never observed; build it again with "
                "'revisit build --coverage'");
    if (options.polygons.empty()) return;
    polygons = scene::readPolygons(options.polygons);
    for (const std::string& remark : polygons->remarks)
        sayNote(remark);
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
    const std::size_t room = device.roomBytes() / 4 * 3;
    const bool isAsAsked = memory.budgetBytes <= room;
    memory.budgetBytes = std::min(memory.budgetBytes, room);
    if (!drawn.mayShowUnseen || !drawn.scene.coverage) {
        brought.images = std::make_unique<render::GpuScene>(device, drawn.scene.blocks, memory);
        return brought;
    }
    CoverageWish wish{.leastCellMetres = drawn.leastCoverageCellMetres,
                      .mostBytes = memory.budgetBytes / 4,
                      .whyNoMore = isAsAsked ? "it may take a quarter of --memory"
                                             : "it may take a quarter of what the device has free for the scene"};
    const std::size_t mostTexels = device.limits().maxTexelBufferElements;
    CoverageForm form = formOf(*drawn.scene.coverage, mostTexels, wish);
    while (brought.images == nullptr) {
        // Its coarsest form may be more than its share. Images shall not have to go for it.
        const std::size_t reserved = std::min(form.bytes, wish.mostBytes);
        try {
            brought.images = std::make_unique<render::GpuScene>(
                device, drawn.scene.blocks,
                render::SceneMemory{memory.budgetBytes - reserved, memory.pageBytes, memory.isStaged});
        } catch (const render::OutOfMemory& failure) {
            if (reserved == 0) throw;
            wish.mostBytes = 0, wish.whyNoMore = failure.what();
            form = formOf(*drawn.scene.coverage, mostTexels, wish);
        }
    }
    brought.coverage = bringCoverage(device, *drawn.scene.coverage, form);
    return brought;
}

} // namespace app
