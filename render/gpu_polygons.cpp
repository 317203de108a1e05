#include "render/gpu_polygons.h"

#include "render/device.h"
#include "render/pipeline.h"
#include "scene/errors.h"

#include <algorithm>
#include <array>
#include <limits>

#include <glm/geometric.hpp>
#include <glm/gtc/packing.hpp>
#include <glm/matrix.hpp>
#include <glm/packing.hpp>

namespace render {

namespace {

/// Of each vertex; where the file has none, the mean of its triangles'.
std::vector<glm::vec3> normalsOf(const scene::PolygonMesh& mesh) {
    if (!mesh.normals.empty()) return mesh.normals;
    std::vector<glm::vec3> normals(mesh.positions.size(), glm::vec3(0));
    for (const auto& [a, b, c] : mesh.triangles) {
        const glm::vec3 across =
            glm::cross(mesh.positions[b] - mesh.positions[a], mesh.positions[c] - mesh.positions[a]);
        for (const std::uint32_t corner : {a, b, c})
            normals[corner] += across;
    }
    return normals;
}

std::uint32_t packNormal(const glm::vec3& normal) {
    const float length = glm::length(normal);
    return glm::packSnorm4x8(glm::vec4(length > 0 ? normal / length : glm::vec3(0), 0));
}

void appendVertices(const scene::PolygonMesh& mesh, std::vector<PolygonVertex>& vertices) {
    const std::vector<glm::vec3> normals = normalsOf(mesh);
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        const glm::vec3 colour = mesh.colours.empty() ? glm::vec3(1) : mesh.colours[i];
        const glm::vec2 place = mesh.texturePlaces.empty() ? glm::vec2(0) : mesh.texturePlaces[i];
        // A picture's first row is its top.
        vertices.push_back({mesh.positions[i], packNormal(normals[i]), glm::vec2(place.x, 1 - place.y),
                            glm::packHalf4x16(glm::vec4(colour, 1))});
    }
}

/// A mesh in the buffers.
struct Placed {
    std::uint32_t firstIndex = 0, firstVertex = 0;
    glm::dvec3 low{0}, high{0};
};

} // namespace

GpuPolygons::GpuPolygons(const Device& device, const scene::PolygonScene& scene, const glm::dvec3& upInWorld) {
    makeMaterials(device, scene);
    makeMeshes(device, scene, upInWorld);
}

void GpuPolygons::makeMaterials(const Device& device, const scene::PolygonScene& scene) {
    for (const scene::PolygonTexture& texture : scene.textures)
        textures_.push_back(uploadTexture(device, texture.pixels, texture.name));
    const std::size_t white = textures_.size();
    textures_.push_back(uploadTexture(device, scene::Image<scene::Rgba8>(1, 1, {255, 255, 255, 255}), "white"));
    sampler_ = makeTextureSampler(device);

    constexpr std::array kTextures{Binding::sampled, Binding::sampled};
    layout_ = makeSetLayout(device, kTextures, VK_SHADER_STAGE_FRAGMENT_BIT);
    pool_ = makeSetPool(device, scene.materials.size(), kTextures);
    for (const scene::PolygonMaterial& material : scene.materials) {
        const auto boundTo = [&](int texture) {
            const DeviceImage& image =
                textures_[texture == scene::kNoTexture ? white : static_cast<std::size_t>(texture)];
            return Bound{.image = image.view, .sampler = sampler_};
        };
        sets_.push_back(allocateSet(device, pool_, layout_,
                                    std::array{boundTo(material.colourTexture), boundTo(material.alphaTexture)}));
        const float cut = material.alphaTexture == scene::kNoTexture ? 0 : material.alphaCut;
        colours_.emplace_back(material.baseColour, cut);
    }
}

void GpuPolygons::makeMeshes(const Device& device, const scene::PolygonScene& scene, const glm::dvec3& upInWorld) {
    std::size_t vertexCount = 0, indexCount = 0;
    for (const scene::PolygonMesh& mesh : scene.meshes)
        vertexCount += mesh.positions.size(), indexCount += 3 * mesh.triangles.size();
    if (vertexCount > std::numeric_limits<std::int32_t>::max() ||
        indexCount > std::numeric_limits<std::uint32_t>::max())
        throw scene::Failure("has more corners than a device can number",
                             scene.files.empty() ? std::string("the polygons") : scene.files.front().string(),
                             "divide it, or leave out what is not needed");
    std::vector<PolygonVertex> vertices;
    std::vector<std::uint32_t> indices;
    vertices.reserve(vertexCount), indices.reserve(indexCount);
    std::vector<Placed> placed;
    for (const scene::PolygonMesh& mesh : scene.meshes) {
        Placed place{static_cast<std::uint32_t>(indices.size()), static_cast<std::uint32_t>(vertices.size()), {}, {}};
        if (!mesh.positions.empty()) place.low = place.high = glm::dvec3(mesh.positions.front());
        for (const glm::vec3& p : mesh.positions)
            place.low = glm::min(place.low, glm::dvec3(p)), place.high = glm::max(place.high, glm::dvec3(p));
        placed.push_back(place);
        if (scene.materials[mesh.material].isGlass) continue;
        appendVertices(mesh, vertices);
        for (const auto& triangle : mesh.triangles)
            indices.insert(indices.end(), triangle.begin(), triangle.end());
    }
    for (const scene::PolygonInstance& instance : scene.instances) {
        const scene::PolygonMesh& mesh = scene.meshes[instance.mesh];
        if (mesh.triangles.empty() || scene.materials[mesh.material].isGlass) continue;
        const Placed& place = placed[instance.mesh];
        const glm::dmat3 worldFromMesh(instance.worldFromMesh);
        // Normals are carried by the inverse transpose; up, the other way, by its transpose. Scales are taken out by
        // their mean: it is light, not measure.
        const glm::dvec3 up = glm::inverse(worldFromMesh) * upInWorld;
        parts_.push_back({place.firstIndex, static_cast<std::uint32_t>(3 * mesh.triangles.size()), place.firstVertex,
                          mesh.material, instance.worldFromMesh, glm::normalize(up), place.low, place.high});
        triangles_ += std::ssize(mesh.triangles);
    }
    std::stable_sort(parts_.begin(), parts_.end(),
                     [](const PolygonPart& a, const PolygonPart& b) { return a.material < b.material; });
    if (parts_.empty()) return;
    vertices_ = upload(device, std::as_bytes(std::span(vertices)), VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
    indices_ = upload(device, std::as_bytes(std::span(indices)), VK_BUFFER_USAGE_INDEX_BUFFER_BIT);
}

} // namespace render
