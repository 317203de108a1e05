#pragma once
// Polygon scenes whose every surface is known.

#include "scene/capture/light.h"
#include "scene/view.h"

#include <glm/geometric.hpp>

namespace scene {

/// A rectangle from `corner` along two edges, seen counter-clockwise from where across x up points; texture coordinates
/// run from 0 to 1 along the edges.
inline void addRectangle(PolygonMesh& mesh, const glm::vec3& corner, const glm::vec3& across, const glm::vec3& up) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const glm::vec2& place : {glm::vec2(0, 0), glm::vec2(1, 0), glm::vec2(1, 1), glm::vec2(0, 1)}) {
        mesh.positions.push_back(corner + across * place.x + up * place.y);
        mesh.texturePlaces.push_back(place);
    }
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.triangles.push_back({first, first + 2, first + 3});
}

/// Six sides that face outward, or inward as a room's do.
inline PolygonMesh boxMesh(const glm::vec3& low, const glm::vec3& high, bool isRoom) {
    PolygonMesh mesh;
    const glm::vec3 e = high - low, x(e.x, 0, 0), y(0, e.y, 0), z(0, 0, e.z);
    const auto add = [&](const glm::vec3& corner, const glm::vec3& a, const glm::vec3& b) {
        isRoom ? addRectangle(mesh, corner, b, a) : addRectangle(mesh, corner, a, b);
    };
    add(low, y, x), add(low, z, y), add(low, x, z);
    add(low + z, x, y), add(low + x, y, z), add(low + y, z, x);
    return mesh;
}

/// One mesh, one material; more may be added.
inline PolygonScene sceneOf(PolygonMesh mesh, const glm::vec3& colour = glm::vec3(0.5f)) {
    PolygonScene scene;
    PolygonMaterial material;
    material.baseColour = colour;
    scene.materials.push_back(material);
    scene.meshes.push_back(std::move(mesh));
    scene.instances.push_back({0, glm::dmat4(1.0)});
    return scene;
}

inline void addMesh(PolygonScene& scene, PolygonMesh mesh, const glm::vec3& colour) {
    PolygonMaterial material;
    material.baseColour = colour;
    mesh.material = static_cast<std::uint32_t>(scene.materials.size());
    scene.materials.push_back(material);
    scene.instances.push_back({static_cast<std::uint32_t>(scene.meshes.size()), glm::dmat4(1.0)});
    scene.meshes.push_back(std::move(mesh));
}

/// The same from everywhere, on everything: what is seen is the surfaces' own colour.
inline CaptureLight evenLight() {
    CaptureLight light;
    light.sun = glm::vec3(0);
    light.zenith = light.horizon = light.ground = light.fill = glm::vec3(1);
    light.fillReachMetres = 0;
    light.rays = 4;
    return light;
}

/// Looks from a place at another, x level; 90 degrees across.
inline View viewFrom(const glm::dvec3& eye, const glm::dvec3& at, int width, int height) {
    const glm::dvec3 forward = glm::normalize(at - eye);
    const glm::dvec3 right = glm::normalize(glm::cross(forward, glm::dvec3(0, 1, 0)));
    return {{width, height, width / 2.0, width / 2.0, width / 2.0, height / 2.0},
            {glm::dmat3(right, glm::cross(forward, right), forward), eye}};
}

} // namespace scene
