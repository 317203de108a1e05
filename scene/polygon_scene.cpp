#include "scene/polygon_scene.h"

#include <limits>

#include <glm/common.hpp>

namespace scene {

std::int64_t countTriangles(const PolygonScene& scene) {
    std::int64_t count = 0;
    for (const PolygonInstance& instance : scene.instances)
        count += std::ssize(scene.meshes[instance.mesh].triangles);
    return count;
}

PolygonBounds boundsOf(const PolygonScene& scene) {
    constexpr double kFar = std::numeric_limits<double>::infinity();
    PolygonBounds bounds{glm::dvec3(kFar), glm::dvec3(-kFar)};
    for (const PolygonInstance& instance : scene.instances) {
        const PolygonMesh& mesh = scene.meshes[instance.mesh];
        for (const auto& triangle : mesh.triangles)
            for (const std::uint32_t corner : triangle) {
                const glm::dvec3 p(instance.worldFromMesh * glm::dvec4(glm::dvec3(mesh.positions[corner]), 1.0));
                bounds.low = glm::min(bounds.low, p), bounds.high = glm::max(bounds.high, p);
            }
    }
    return bounds;
}

} // namespace scene
