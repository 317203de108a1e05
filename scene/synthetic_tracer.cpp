#include "scene/synthetic_tracer.h"

#include "scene/errors.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <embree3/rtcore.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <tbb/parallel_for.h>

namespace scene {

namespace {

constexpr unsigned kPatchGeometry = 0, kMeshGeometry = 1, kRoundGeometry = 2;

/// Embree's rays are single precision; round surfaces read the exact rays behind the context that Embree hands
/// through, each by its number.
struct ExactRays {
    RTCIntersectContext context;
    glm::dvec3 origin;
    const glm::dvec3* directions;
};

RTCRay rayOf(const ExactRays& exact, double lengths) {
    const glm::dvec3& direction = exact.directions[0];
    RTCRay ray{};
    ray.org_x = static_cast<float>(exact.origin.x), ray.org_y = static_cast<float>(exact.origin.y);
    ray.org_z = static_cast<float>(exact.origin.z);
    ray.dir_x = static_cast<float>(direction.x), ray.dir_y = static_cast<float>(direction.y);
    ray.dir_z = static_cast<float>(direction.z);
    ray.tnear = 0.0f;
    ray.tfar = static_cast<float>(lengths);
    ray.mask = ~0u;
    return ray;
}

double distanceToPlane(const glm::dvec3& origin, const glm::dvec3& direction, const glm::dvec3& onPlane,
                       const glm::dvec3& normal) {
    return glm::dot(normal, onPlane - origin) / glm::dot(normal, direction);
}

/// Both places where a ray pierces a sphere or tube wall, nearer first; the caller checks a tube's ends.
struct Pierced {
    bool hit = false;
    double t[2] = {0, 0};
};

Pierced pierce(const Round& round, const glm::dvec3& origin, const glm::dvec3& direction) {
    glm::dvec3 from = origin - round.origin, along = direction;
    if (round.kind == RoundKind::tube) {
        from -= round.axis * glm::dot(from, round.axis);
        along -= round.axis * glm::dot(along, round.axis);
    }
    const double a = glm::dot(along, along);
    if (a < 1e-24) return {};
    // Relative to the point of the ray that is nearest to the centre, so that far origins cost no digits.
    const double nearest = -glm::dot(from, along) / a;
    const glm::dvec3 closest = from + along * nearest;
    const double halfChord2 = (round.radius * round.radius - glm::dot(closest, closest)) / a;
    if (halfChord2 < 0) return {};
    const double halfChord = std::sqrt(halfChord2);
    return {true, {nearest - halfChord, nearest + halfChord}};
}

/// First t in (low, high) where the ray meets the round; infinity if none.
double meet(const Round& round, const glm::dvec3& origin, const glm::dvec3& direction, double low, double high) {
    constexpr double kNone = std::numeric_limits<double>::infinity();
    if (round.kind == RoundKind::disc) {
        const double t = distanceToPlane(origin, direction, round.origin, round.axis);
        const glm::dvec3 p = origin + direction * t - round.origin;
        return t > low && t < high && glm::dot(p, p) <= round.radius * round.radius ? t : kNone;
    }
    const Pierced pierced = pierce(round, origin, direction);
    if (!pierced.hit) return kNone;
    for (const double t : pierced.t) {
        if (!(t > low && t < high)) continue;
        if (round.kind == RoundKind::sphere) return t;
        const double height = glm::dot(origin + direction * t - round.origin, round.axis);
        if (height >= 0 && height <= round.length) return t;
    }
    return kNone;
}

void boundRound(const RTCBoundsFunctionArguments* args) {
    const Round& round = static_cast<const Round*>(args->geometryUserPtr)[args->primID];
    const glm::dvec3 far = round.origin + round.axis * round.length;
    const glm::dvec3 low = glm::min(round.origin, far) - round.radius * 1.00001 - 1e-5;
    const glm::dvec3 high = glm::max(round.origin, far) + round.radius * 1.00001 + 1e-5;
    *args->bounds_o = {static_cast<float>(low.x),  static_cast<float>(low.y),  static_cast<float>(low.z),  0,
                       static_cast<float>(high.x), static_cast<float>(high.y), static_cast<float>(high.z), 0};
}

void intersectRound(const RTCIntersectFunctionNArguments* args) {
    const Round& round = static_cast<const Round*>(args->geometryUserPtr)[args->primID];
    const auto& exact = *reinterpret_cast<const ExactRays*>(args->context);
    RTCRayN* const rays = RTCRayHitN_RayN(args->rayhit, args->N);
    RTCHitN* const hits = RTCRayHitN_HitN(args->rayhit, args->N);
    for (unsigned i = 0; i < args->N; ++i) {
        if (args->valid[i] == 0) continue;
        float& end = RTCRayN_tfar(rays, args->N, i);
        const double t = meet(round, exact.origin, exact.directions[RTCRayN_id(rays, args->N, i)],
                              RTCRayN_tnear(rays, args->N, i), end);
        if (!std::isfinite(t)) continue;
        end = static_cast<float>(t);
        RTCHitN_geomID(hits, args->N, i) = args->geomID;
        RTCHitN_primID(hits, args->N, i) = args->primID;
        RTCHitN_instID(hits, args->N, i, 0) = args->context->instID[0];
    }
}

void occludeRound(const RTCOccludedFunctionNArguments* args) {
    assert(args->N == 1);
    if (args->valid[0] == 0) return;
    const Round& round = static_cast<const Round*>(args->geometryUserPtr)[args->primID];
    const auto& exact = *reinterpret_cast<const ExactRays*>(args->context);
    auto& ray = *reinterpret_cast<RTCRay*>(args->ray);
    if (std::isfinite(meet(round, exact.origin, exact.directions[0], ray.tnear, ray.tfar)))
        ray.tfar = -std::numeric_limits<float>::infinity();
}

struct Triangles {
    std::vector<glm::dvec3> positions;
    std::vector<std::array<std::uint32_t, 3>> triangles;

    std::uint32_t add(const glm::dvec3& p) {
        positions.push_back(p);
        return static_cast<std::uint32_t>(positions.size()) - 1;
    }
};

/// A rectangle with holes is cut along the edges of all holes; every piece that is in none is two triangles.
void triangulate(const Patch& patch, Triangles& out) {
    const auto add = [&](double x, double y) { return out.add(patch.origin + patch.u * x + patch.v * y); };
    if (patch.holes.empty()) {
        const std::uint32_t first = static_cast<std::uint32_t>(out.positions.size());
        for (const glm::dvec2& corner : patch.outline)
            add(corner.x, corner.y);
        for (std::uint32_t i = 2; i < patch.outline.size(); ++i)
            out.triangles.push_back({first, first + i - 1, first + i});
        return;
    }
    std::vector<double> xs{patch.extent.low.x, patch.extent.high.x}, ys{patch.extent.low.y, patch.extent.high.y};
    for (const Rectangle& hole : patch.holes) {
        xs.insert(xs.end(), {hole.low.x, hole.high.x});
        ys.insert(ys.end(), {hole.low.y, hole.high.y});
    }
    std::sort(xs.begin(), xs.end());
    std::sort(ys.begin(), ys.end());
    for (std::size_t i = 0; i + 1 < xs.size(); ++i)
        for (std::size_t j = 0; j + 1 < ys.size(); ++j) {
            const double x = (xs[i] + xs[i + 1]) / 2, y = (ys[j] + ys[j + 1]) / 2;
            const bool open = std::any_of(patch.holes.begin(), patch.holes.end(), [&](const Rectangle& hole) {
                return x > hole.low.x && x < hole.high.x && y > hole.low.y && y < hole.high.y;
            });
            if (open || xs[i] == xs[i + 1] || ys[j] == ys[j + 1]) continue;
            const std::uint32_t a = add(xs[i], ys[j]), b = add(xs[i + 1], ys[j]), c = add(xs[i + 1], ys[j + 1]),
                                d = add(xs[i], ys[j + 1]);
            out.triangles.push_back({a, b, c});
            out.triangles.push_back({a, c, d});
        }
}

void attachTriangles(RTCDevice device, RTCScene rtcScene, unsigned id, const std::vector<glm::dvec3>& positions,
                     const std::vector<std::array<std::uint32_t, 3>>& triangles) {
    if (triangles.empty()) return;
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                                 3 * sizeof(float), positions.size()));
    for (const glm::dvec3& p : positions)
        for (int axis = 0; axis < 3; ++axis)
            *vertices++ = static_cast<float>(p[axis]);
    auto* indices = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), triangles.size()));
    for (const auto& triangle : triangles)
        indices = std::copy(triangle.begin(), triangle.end(), indices);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(rtcScene, geometry, id);
    rtcReleaseGeometry(geometry);
}

} // namespace

SyntheticTracer::SyntheticTracer(const SyntheticModel& model) : model_(model) {
    // oneTBB's tasks keep the arithmetic of whoever woke it first; with Embree's, tiny numbers would be zero in all
    // that runs after.
    tbb::parallel_for(0, 1, [](int) {});
    device_ = rtcNewDevice(nullptr);
    if (device_ == nullptr)
        throw Failure("cannot start the ray tracer", std::string("Embree"),
                      "check that this processor has SSE2 and memory is free");
    scene_ = rtcNewScene(device_);
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);

    Triangles flat;
    for (std::size_t i = 0; i < model.patches.size(); ++i) {
        triangulate(model.patches[i], flat);
        patchOfTriangle_.resize(flat.triangles.size(), static_cast<std::uint32_t>(i));
    }
    attachTriangles(device_, scene_, kPatchGeometry, flat.positions, flat.triangles);
    attachTriangles(device_, scene_, kMeshGeometry, model.mesh.positions, model.mesh.triangles);
    if (!model.rounds.empty()) {
        RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_USER);
        rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(model.rounds.size()));
        rtcSetGeometryUserData(geometry, const_cast<Round*>(model.rounds.data())); // only read
        rtcSetGeometryBoundsFunction(
            geometry, [](const RTCBoundsFunctionArguments* args) { boundRound(args); }, nullptr);
        rtcSetGeometryIntersectFunction(geometry, intersectRound);
        rtcSetGeometryOccludedFunction(geometry, occludeRound);
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(scene_, geometry, kRoundGeometry);
        rtcReleaseGeometry(geometry);
    }
    rtcCommitScene(scene_);
}

SyntheticTracer::~SyntheticTracer() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
}

RayHit SyntheticTracer::exactHit(const glm::dvec3& origin, const glm::dvec3& direction, const Found& found) const {
    RayHit hit{0, SurfaceKind::patch, found.primitive};
    if (found.geometry == kPatchGeometry) {
        hit.index = patchOfTriangle_[found.primitive];
        const Patch& patch = model_.patches[hit.index];
        hit.t = distanceToPlane(origin, direction, patch.origin, patch.normal);
    } else if (found.geometry == kMeshGeometry) {
        hit.kind = SurfaceKind::mesh;
        const auto& corners = model_.mesh.triangles[hit.index];
        const glm::dvec3 a = model_.mesh.positions[corners[0]];
        const glm::dvec3 ab = model_.mesh.positions[corners[1]] - a, ac = model_.mesh.positions[corners[2]] - a;
        hit.t = distanceToPlane(origin, direction, a, glm::cross(ab, ac));
    } else {
        hit.kind = SurfaceKind::round;
        // Embree's limit is rounded to a float: leave room for the exact value beside it.
        hit.t = meet(model_.rounds[hit.index], origin, direction, 0.0, found.lengths * 1.000001 + 1e-9);
    }
    // A ray within a plane, or one that the exact equation just misses: Embree's own answer is the best there
    // is.
    if (!std::isfinite(hit.t) || hit.t <= 0) hit.t = found.lengths;
    return hit;
}

std::optional<RayHit> SyntheticTracer::cast(const glm::dvec3& origin, const glm::dvec3& direction) const {
    ExactRays exact{{}, origin, &direction};
    rtcInitIntersectContext(&exact.context);
    RTCRayHit found{};
    found.ray = rayOf(exact, std::numeric_limits<double>::infinity());
    found.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    found.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene_, &exact.context, &found);
    if (found.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
    return exactHit(origin, direction, {found.hit.geomID, found.hit.primID, found.ray.tfar});
}

std::array<std::optional<RayHit>, SyntheticTracer::kTogether>
SyntheticTracer::castTogether(const glm::dvec3& origin, std::span<const glm::dvec3> directions) const {
    assert(directions.size() <= kTogether);
    ExactRays exact{{}, origin, directions.data()};
    rtcInitIntersectContext(&exact.context);
    exact.context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    RTCRayHit16 found{};
    alignas(64) std::array<int, kTogether> valid{};
    for (std::size_t i = 0; i < directions.size(); ++i) {
        valid[i] = -1;
        found.ray.org_x[i] = static_cast<float>(origin.x), found.ray.org_y[i] = static_cast<float>(origin.y);
        found.ray.org_z[i] = static_cast<float>(origin.z);
        found.ray.dir_x[i] = static_cast<float>(directions[i].x);
        found.ray.dir_y[i] = static_cast<float>(directions[i].y);
        found.ray.dir_z[i] = static_cast<float>(directions[i].z);
        found.ray.tfar[i] = std::numeric_limits<float>::infinity();
        found.ray.mask[i] = ~0u;
        found.ray.id[i] = static_cast<unsigned>(i);
        found.hit.geomID[i] = found.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
    rtcIntersect16(valid.data(), scene_, &exact.context, &found);
    std::array<std::optional<RayHit>, kTogether> hits;
    for (std::size_t i = 0; i < directions.size(); ++i)
        if (found.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID)
            hits[i] = exactHit(origin, directions[i], {found.hit.geomID[i], found.hit.primID[i], found.ray.tfar[i]});
    return hits;
}

bool SyntheticTracer::isBlocked(const glm::dvec3& origin, const glm::dvec3& direction, double lengths) const {
    ExactRays exact{{}, origin, &direction};
    rtcInitIntersectContext(&exact.context);
    RTCRay ray = rayOf(exact, lengths);
    rtcOccluded1(scene_, &exact.context, &ray);
    return ray.tfar < 0;
}

SurfacePoint SyntheticTracer::surfaceAt(const glm::dvec3& origin, const glm::dvec3& direction,
                                        const RayHit& hit) const {
    SurfacePoint point;
    point.position = origin + direction * hit.t;
    if (hit.kind == SurfaceKind::patch) {
        const Patch& patch = model_.patches[hit.index];
        const glm::dvec3 p = point.position - patch.origin;
        const glm::dvec2 at(glm::dot(p, patch.u), glm::dot(p, patch.v));
        const glm::dvec2 part = (at - patch.extent.low) / (patch.extent.high - patch.extent.low);
        point.normal = point.shadingNormal = patch.normal;
        point.texturePlace = glm::dvec3(at, 0);
        point.lightPlace = part;
        point.material = patch.material;
        point.twoSided = patch.twoSided;
    } else if (hit.kind == SurfaceKind::mesh) {
        const Mesh& mesh = model_.mesh;
        const auto [i, j, k] = mesh.triangles[hit.index];
        const glm::dvec3 a = mesh.positions[i], ab = mesh.positions[j] - a, ac = mesh.positions[k] - a;
        const glm::dvec3 across = glm::cross(ab, ac), p = point.position - a;
        const double area = glm::dot(across, across);
        const double wb = std::clamp(glm::dot(glm::cross(p, ac), across) / area, 0.0, 1.0);
        const double wc = std::clamp(glm::dot(glm::cross(ab, p), across) / area, 0.0, 1.0 - wb);
        const auto blend = [&](const std::vector<glm::dvec3>& values) {
            return values[i] * (1.0 - wb - wc) + values[j] * wb + values[k] * wc;
        };
        point.normal = glm::normalize(across);
        point.shadingNormal = glm::normalize(blend(mesh.normals));
        point.texturePlace = blend(mesh.texturePlaces);
        point.lightPlace = {wb, wc};
        point.material = mesh.materials[hit.index];
    } else {
        const Round& round = model_.rounds[hit.index];
        const glm::dvec3 p = point.position - round.origin;
        const double x = glm::dot(p, round.side), y = glm::dot(p, round.up), z = glm::dot(p, round.axis);
        const double turn = std::atan2(y, x) / kTwoPi + 0.5;
        point.material = round.material;
        if (round.kind == RoundKind::disc) {
            point.normal = round.axis;
            point.texturePlace = {x, y, 0};
            point.lightPlace = {0.5 + 0.5 * x / round.radius, 0.5 + 0.5 * y / round.radius};
        } else if (round.kind == RoundKind::tube) {
            point.normal = (p - round.axis * z) / round.radius;
            point.texturePlace = {turn * kTwoPi * round.radius, z, 0};
            point.lightPlace = {turn, z / round.length};
        } else {
            point.normal = p / round.radius;
            point.texturePlace = p;
            point.lightPlace = {turn, std::acos(std::clamp(-z / round.radius, -1.0, 1.0)) / kTwoPi * 2.0};
        }
        point.normal = glm::normalize(point.normal);
        point.shadingNormal = point.normal;
    }
    return point;
}

RoundPlace placeOn(const Round& round, double s, double t) {
    const double angle = (s - 0.5) * kTwoPi;
    const glm::dvec3 around = round.side * std::cos(angle) + round.up * std::sin(angle);
    if (round.kind == RoundKind::tube)
        return {round.origin + around * round.radius + round.axis * (t * round.length), around};
    if (round.kind == RoundKind::sphere) {
        const double latitude = (t - 0.5) * kTwoPi / 2;
        const glm::dvec3 normal = around * std::cos(latitude) + round.axis * std::sin(latitude);
        return {round.origin + normal * round.radius, normal};
    }
    glm::dvec2 square(2.0 * s - 1.0, 2.0 * t - 1.0);
    square *= 0.999 / std::max(1.0, glm::length(square));
    return {round.origin + (round.side * square.x + round.up * square.y) * round.radius, round.axis};
}

} // namespace scene
