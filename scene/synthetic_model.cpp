#include "scene/synthetic_model.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace scene {

namespace {

Patch& addOutline(SyntheticModel& model, Patch patch) {
    patch.extent = {patch.outline.front(), patch.outline.front()};
    for (const glm::dvec2& corner : patch.outline) {
        patch.extent.low = glm::min(patch.extent.low, corner);
        patch.extent.high = glm::max(patch.extent.high, corner);
    }
    model.patches.push_back(std::move(patch));
    return model.patches.back();
}

Round& addRound(SyntheticModel& model, RoundKind kind, const glm::dvec3& origin, const glm::dvec3& axis, double radius,
                double length, int material) {
    assert(radius > 0);
    Round round;
    round.kind = kind;
    round.origin = origin;
    round.axis = glm::normalize(axis);
    const glm::dvec3 across = std::abs(round.axis.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(0, 1, 0);
    round.side = glm::normalize(glm::cross(across, round.axis));
    round.up = glm::cross(round.axis, round.side);
    round.radius = radius;
    round.length = length;
    round.material = material;
    model.rounds.push_back(std::move(round));
    return model.rounds.back();
}

} // namespace

int addMaterial(SyntheticModel& model, const Material& material) {
    model.materials.push_back(material);
    return static_cast<int>(model.materials.size()) - 1;
}

Patch& addRectangle(SyntheticModel& model, const glm::dvec3& origin, const glm::dvec3& edgeU, const glm::dvec3& edgeV,
                    int material, std::vector<Rectangle> holes) {
    const double width = glm::length(edgeU), height = glm::length(edgeV);
    assert(width > 0 && height > 0 && std::abs(glm::dot(edgeU, edgeV)) < 1e-9 * width * height);
    Patch patch;
    patch.origin = origin;
    patch.u = edgeU / width;
    patch.v = edgeV / height;
    patch.normal = glm::normalize(glm::cross(patch.u, patch.v));
    patch.outline = {{0, 0}, {width, 0}, {width, height}, {0, height}};
    patch.holes = std::move(holes);
    patch.material = material;
    return addOutline(model, std::move(patch));
}

Patch& addPolygon(SyntheticModel& model, const std::vector<glm::dvec3>& corners, int material) {
    assert(corners.size() >= 3);
    Patch patch;
    patch.origin = corners[0];
    patch.u = glm::normalize(corners[1] - corners[0]);
    patch.normal = glm::normalize(glm::cross(corners[1] - corners[0], corners[2] - corners[0]));
    patch.v = glm::cross(patch.normal, patch.u);
    for (const glm::dvec3& corner : corners)
        patch.outline.emplace_back(glm::dot(corner - corners[0], patch.u), glm::dot(corner - corners[0], patch.v));
    patch.material = material;
    return addOutline(model, std::move(patch));
}

void addBox(SyntheticModel& model, const Pose& worldFromBox, const glm::dvec3& low, const glm::dvec3& high,
            int material) {
    const glm::dvec3 x = worldFromBox.rotation[0] * (high.x - low.x), y = worldFromBox.rotation[1] * (high.y - low.y),
                     z = worldFromBox.rotation[2] * (high.z - low.z), corner = worldFromBox * low;
    addRectangle(model, corner, x, z, material);
    addRectangle(model, corner + x, y, z, material);
    addRectangle(model, corner + x + y, -x, z, material);
    addRectangle(model, corner + y, -y, z, material);
    addRectangle(model, corner + z, x, y, material);
    addRectangle(model, corner, y, x, material);
}

Round& addSphere(SyntheticModel& model, const glm::dvec3& centre, double radius, int material) {
    return addRound(model, RoundKind::sphere, centre, {0, 0, 1}, radius, 0, material);
}

Round& addTube(SyntheticModel& model, const glm::dvec3& from, const glm::dvec3& to, double radius, int material) {
    return addRound(model, RoundKind::tube, from, to - from, radius, glm::length(to - from), material);
}

Round& addDisc(SyntheticModel& model, const glm::dvec3& centre, const glm::dvec3& normal, double radius, int material) {
    return addRound(model, RoundKind::disc, centre, normal, radius, 0, material);
}

void addRod(SyntheticModel& model, const glm::dvec3& from, const glm::dvec3& to, double radius, int material) {
    addTube(model, from, to, radius, material);
    addDisc(model, from, from - to, radius, material);
    addDisc(model, to, to - from, radius, material);
}

void addSheet(SyntheticModel& model, int columns, int rows, const std::function<glm::dvec3(double s, double t)>& place,
              const std::function<glm::dvec3(double s, double t)>& texture, int material) {
    Mesh& mesh = model.mesh;
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (int row = 0; row <= rows; ++row)
        for (int column = 0; column <= columns; ++column) {
            const double s = static_cast<double>(column) / columns, t = static_cast<double>(row) / rows;
            mesh.positions.push_back(place(s, t));
            mesh.texturePlaces.push_back(texture(s, t));
        }
    mesh.normals.resize(mesh.positions.size(), glm::dvec3(0));
    const auto addTriangle = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        const glm::dvec3 across =
            glm::cross(mesh.positions[b] - mesh.positions[a], mesh.positions[c] - mesh.positions[a]);
        if (glm::dot(across, across) < 1e-20) return; // where a sheet closes in a point
        for (const std::uint32_t corner : {a, b, c})
            mesh.normals[corner] += across;
        mesh.triangles.push_back({a, b, c});
        mesh.materials.push_back(material);
    };
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column) {
            const std::uint32_t a = first + static_cast<std::uint32_t>(row * (columns + 1) + column);
            const std::uint32_t below = a + static_cast<std::uint32_t>(columns + 1);
            addTriangle(a, a + 1, below + 1);
            addTriangle(a, below + 1, below);
        }
    for (std::size_t i = first; i < mesh.normals.size(); ++i) {
        const double length = glm::length(mesh.normals[i]);
        mesh.normals[i] = length > 0 ? mesh.normals[i] / length : glm::dvec3(0, 0, 1);
    }
}

Pose standing(const glm::dvec3& at, double yawRadians) {
    const double c = std::cos(yawRadians), s = std::sin(yawRadians);
    return {glm::dmat3(glm::dvec3(c, s, 0), glm::dvec3(-s, c, 0), glm::dvec3(0, 0, 1)), at};
}

} // namespace scene
