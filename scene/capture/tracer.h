#pragma once
// Rays into a polygon scene, by Embree, with the hit computed again in double precision.

#include "scene/polygon_scene.h"
#include "scene/sight_lines.h"

#include <memory>
#include <optional>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

struct RTCDeviceTy;
struct RTCSceneTy;

namespace scene {

/// Where a ray ends.
struct PolygonHit {
    double t = 0; ///< in lengths of the ray's direction
    std::uint32_t instance = 0, triangle = 0;
    bool isBack = false; ///< the triangle is seen clockwise
};

/// Corners of a triangle in the world, in the order of its winding after the instance's map.
struct TriangleInWorld {
    std::array<glm::dvec3, 3> corners;
    glm::dvec3 across{0.0}; ///< towards the front, twice the area long; zero if it has none
};

/// Weights of the three corners at a point of the triangle's plane; their sum is 1, beyond an edge one is negative.
glm::dvec3 weightsAt(const TriangleInWorld& triangle, const glm::dvec3& pInWorld);

/// Lent the scene, which must outlive it. Glass is not there. Cut-outs are looked up in the full picture, so that a
/// surface has the same holes from everywhere. May be used from any number of threads.
class PolygonTracer {
  public:
    /// Throws Failure if Embree cannot start, if memory ends, or if all triangles are glass.
    explicit PolygonTracer(const PolygonScene& scene);
    PolygonTracer(const PolygonTracer&) = delete;
    PolygonTracer& operator=(const PolygonTracer&) = delete;

    const PolygonScene& scene() const { return scene_; }
    const PolygonBounds& bounds() const { return bounds_; }

    /// How far a ray must start before a surface so as not to meet it again, metres: single precision over the
    /// whole scene.
    double skinMetres() const { return skinMetres_; }

    /// The first surface on a ray, if any; direction need not be a unit vector but must not be zero.
    std::optional<PolygonHit> cast(const glm::dvec3& origin, const glm::dvec3& direction) const;

    /// True if anything stands on the ray before `lengths` of its direction.
    bool isBlocked(const glm::dvec3& origin, const glm::dvec3& direction, double lengths) const;

    TriangleInWorld triangleOf(const PolygonHit& hit) const;

    /// Carries normals: the inverse transpose of an instance's map.
    const glm::dmat3& worldFromMeshNormals(std::uint32_t instance) const { return normalMaps_[instance]; }

  private:
    struct Release {
        void operator()(RTCDeviceTy* device) const;
        void operator()(RTCSceneTy* rtcScene) const;
    };
    using ScenePointer = std::unique_ptr<RTCSceneTy, Release>;
    /// What a filter needs to find holes.
    struct CutOut {
        const PolygonMesh* mesh = nullptr;
        const Image<Rgba8>* alpha = nullptr;
        float cut = 0.5f;
    };
    static bool isHole(const CutOut& cutOut, std::uint32_t triangle, float u, float v);
    RTCSceneTy* sceneOf(std::uint32_t mesh);
    void attachMesh(RTCSceneTy* to, unsigned id, std::uint32_t mesh, const glm::dmat4& centredFromMesh);
    void attachInstance(unsigned id, const PolygonInstance& instance);

    const PolygonScene& scene_;
    PolygonBounds bounds_;
    glm::dvec3 middle_{0.0}; ///< Embree's origin
    double skinMetres_ = 0;
    std::vector<std::unique_ptr<CutOut>> cutOuts_;
    std::unique_ptr<RTCDeviceTy, Release> device_;
    std::vector<ScenePointer> meshScenes_; ///< of meshes that stand in several places; else null
    ScenePointer world_;
    std::vector<glm::dmat3> normalMaps_;
    std::vector<bool> isMirrored_;
};

/// Lent the tracer.
SightLines sightLinesOf(const PolygonTracer& tracer);

} // namespace scene
