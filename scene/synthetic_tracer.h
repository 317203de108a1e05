#pragma once
// Rays against a synthetic model: Embree finds which surface, double precision says where.

#include "scene/synthetic_model.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

struct RTCDeviceTy;
struct RTCSceneTy;

namespace scene {

enum class SurfaceKind : std::uint8_t { patch, mesh, round };

/// A ray's first surface. t counts in lengths of the ray's direction and is exact to double rounding.
struct RayHit {
    double t = 0;
    SurfaceKind kind = SurfaceKind::patch;
    std::uint32_t index = 0; ///< of the patch, the mesh triangle or the round
};

/// What the light sees of a surface there.
struct SurfacePoint {
    glm::dvec3 position{0.0};
    glm::dvec3 normal{0.0};        ///< of the geometry, outwards
    glm::dvec3 shadingNormal{0.0}; ///< smoothed on meshes
    glm::dvec3 texturePlace{0.0};
    glm::dvec2 lightPlace{0.0}; ///< both parameters of its light map; on meshes how near the second and third vertex
    int material = 0;
    bool twoSided = false;
};

class SyntheticTracer {
  public:
    /// The model must outlive the tracer and keep its geometry; light maps are none of the tracer's.
    explicit SyntheticTracer(const SyntheticModel& model);
    ~SyntheticTracer();
    SyntheticTracer(const SyntheticTracer&) = delete;
    SyntheticTracer& operator=(const SyntheticTracer&) = delete;

    std::optional<RayHit> cast(const glm::dvec3& origin, const glm::dvec3& direction) const;

    /// What cast finds along each of up to so many rays from one place, in less time where they lie close together.
    static constexpr std::size_t kTogether = 16;
    std::array<std::optional<RayHit>, kTogether> castTogether(const glm::dvec3& origin,
                                                              std::span<const glm::dvec3> directions) const;

    /// True if a surface stands on the ray before lengths times its direction.
    bool isBlocked(const glm::dvec3& origin, const glm::dvec3& direction, double lengths) const;

    SurfacePoint surfaceAt(const glm::dvec3& origin, const glm::dvec3& direction, const RayHit& hit) const;

  private:
    /// Embree's answer, in its own numbers.
    struct Found {
        unsigned geometry, primitive;
        float lengths;
    };
    RayHit exactHit(const glm::dvec3& origin, const glm::dvec3& direction, const Found& found) const;

    const SyntheticModel& model_;
    std::vector<std::uint32_t> patchOfTriangle_;
    RTCDeviceTy* device_ = nullptr;
    RTCSceneTy* scene_ = nullptr;
};

/// The place on a round at parameters in [0, 1]: sphere and tube by angle and height, disc by its square.
struct RoundPlace {
    glm::dvec3 position, normal;
};
RoundPlace placeOn(const Round& round, double s, double t);

} // namespace scene
