#include "app/drawn_scene.h"

#include "app/device_trouble.h"

#include "render/device.h"
#include "scene/import/polygons.h"

#include <algorithm>
#include <cstdio>

#include <glm/matrix.hpp>

namespace app {

DrawnScene::DrawnScene(const scene::Scene& given, const DrawOptions& options) : scene(given) {
    // All of --memory is for what the tiles hold; what of the file lies in the system's cache can be taken back at any
    // time.
    memory.budgetBytes = options.memoryBytes;
    mayShowUnseen = !options.hideUnseen;
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
    // Images take what is left; pictures, z-buffers and what a headset's runtime needs have their place beside them.
    render::SceneMemory memory = drawn.memory;
    memory.budgetBytes = std::min(memory.budgetBytes, device.roomBytes() / 4 * 3);
    brought.images = std::make_unique<render::GpuScene>(device, drawn.scene.blocks, memory);
    if (drawn.mayShowUnseen) brought.coverage = makeCoverage(device, drawn.scene);
    return brought;
}

} // namespace app
