#pragma once
// Ordinary polygons on the device, to be drawn beside images.

#include "render/images.h"
#include "render/resources.h"
#include "scene/polygon_scene.h"

#include <cstdint>
#include <span>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

namespace render {

/// As the vertex shader reads it.
struct PolygonVertex {
    glm::vec3 position{0};
    std::uint32_t normal = 0; ///< four signed bytes
    glm::vec2 texturePlace{0};
    std::uint64_t colour = 0; ///< four halves; linear
};
static_assert(sizeof(PolygonVertex) == 32);

/// A mesh where it stands once.
struct PolygonPart {
    std::uint32_t firstIndex = 0, indexCount = 0, firstVertex = 0, material = 0;
    glm::dmat4 worldFromMesh{1.0};
    glm::dvec3 upFromNormal{0}; ///< see PolygonConstants
    glm::dvec3 low{0}, high{0}; ///< its box, in the mesh's coordinates
};

class GpuPolygons {
  public:
    /// Copies it to the device; glass is left out. upInWorld: where most light comes from, a unit vector. Throws
    /// scene::Failure if the device's memory does not suffice.
    GpuPolygons(const Device& device, const scene::PolygonScene& scene, const glm::dvec3& upInWorld);

    std::span<const PolygonPart> parts() const { return parts_; } ///< by material
    VkBuffer vertices() const { return vertices_.handle(); }
    VkBuffer indices() const { return indices_.handle(); }
    std::int64_t triangles() const { return triangles_; }

    VkDescriptorSetLayout textureLayout() const { return layout_; } ///< 0 colour, 1 alpha
    VkDescriptorSet texturesOf(std::uint32_t material) const { return sets_[material]; }
    const glm::vec4& colourOf(std::uint32_t material) const { return colours_[material]; } ///< and the cut of alpha

  private:
    void makeMaterials(const Device& device, const scene::PolygonScene& scene);
    void makeMeshes(const Device& device, const scene::PolygonScene& scene, const glm::dvec3& upInWorld);

    Buffer vertices_, indices_;
    std::vector<PolygonPart> parts_;
    std::int64_t triangles_ = 0;
    std::vector<DeviceImage> textures_; ///< those of the scene, then a white one
    Sampler sampler_;
    VkDescriptorSetLayout layout_ = VK_NULL_HANDLE;
    DescriptorPool pool_;
    std::vector<VkDescriptorSet> sets_; ///< by material
    std::vector<glm::vec4> colours_;
};

} // namespace render
