#include "scene/capture/tracer.h"

#include "scene/capture/texels.h"
#include "scene/errors.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include <embree3/rtcore.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <tbb/parallel_for.h>

namespace scene {

namespace {

/// Of a scene's diagonal: some units in the last place of a float there.
constexpr double kSkinShare = 1e-5;

RTCRay rayOf(const glm::dvec3& origin, const glm::dvec3& direction, double lengths) {
    RTCRay ray{};
    ray.org_x = static_cast<float>(origin.x), ray.org_y = static_cast<float>(origin.y);
    ray.org_z = static_cast<float>(origin.z);
    ray.dir_x = static_cast<float>(direction.x), ray.dir_y = static_cast<float>(direction.y);
    ray.dir_z = static_cast<float>(direction.z);
    ray.tnear = 0.0f;
    ray.tfar = static_cast<float>(lengths);
    ray.mask = ~0u;
    return ray;
}

} // namespace

glm::dvec3 weightsAt(const TriangleInWorld& triangle, const glm::dvec3& pInWorld) {
    const auto& [a, b, c] = triangle.corners;
    const glm::dvec3 across = glm::cross(b - a, c - a); // of a mirrored triangle this is not the front
    const double area = glm::dot(across, across);
    if (!(area > 0)) return {1, 0, 0};
    const double wb = glm::dot(glm::cross(pInWorld - a, c - a), across) / area;
    const double wc = glm::dot(glm::cross(b - a, pInWorld - a), across) / area;
    return {1.0 - wb - wc, wb, wc};
}

PolygonTracer::PolygonTracer(const PolygonScene& scene) : scene_(scene), bounds_(boundsOf(scene)) {
    // oneTBB's tasks keep the arithmetic of whoever woke it first; with Embree's, tiny numbers would be zero in all
    // that runs after.
    tbb::parallel_for(0, 1, [](int) {});
    device_.reset(rtcNewDevice(nullptr));
    if (device_ == nullptr)
        throw Failure("cannot start the ray tracer", std::string("Embree"),
                      "check that this processor has SSE2 and memory is free");
    middle_ = (bounds_.low + bounds_.high) * 0.5;
    skinMetres_ = kSkinShare * glm::length(bounds_.high - bounds_.low);
    world_.reset(rtcNewScene(device_.get()));
    rtcSetSceneFlags(world_.get(), RTC_SCENE_FLAG_ROBUST);

    std::vector<int> uses(scene.meshes.size());
    for (const PolygonInstance& instance : scene.instances)
        ++uses[instance.mesh];
    meshScenes_.resize(scene.meshes.size());
    bool isAnySolid = false;
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const PolygonInstance& instance = scene.instances[i];
        const glm::dmat3 linear(instance.worldFromMesh);
        normalMaps_.push_back(glm::transpose(glm::inverse(linear)));
        isMirrored_.push_back(glm::determinant(linear) < 0);
        if (scene.materials[scene.meshes[instance.mesh].material].isGlass) continue;
        isAnySolid = true;
        // What stands once is traced faster as part of the whole.
        if (uses[instance.mesh] > 1) {
            attachInstance(static_cast<unsigned>(i), instance);
            continue;
        }
        glm::dmat4 centredFromMesh = instance.worldFromMesh;
        centredFromMesh[3] -= glm::dvec4(middle_, 0.0);
        attachMesh(world_.get(), static_cast<unsigned>(i), instance.mesh, centredFromMesh);
    }
    rtcCommitScene(world_.get());
    const bool isShort = rtcGetDeviceError(device_.get()) == RTC_ERROR_OUT_OF_MEMORY;
    if (isAnySolid && !isShort) return;
    const std::string name = scene.files.empty() ? "scene" : scene.files.front().string();
    if (isShort) throw Failure("is too large to trace rays into", name, "close other programs, or divide the scene");
    throw Failure("holds nothing but glass", name, "check the opacity of its materials");
}

void PolygonTracer::Release::operator()(RTCDeviceTy* device) const {
    rtcReleaseDevice(device);
}

void PolygonTracer::Release::operator()(RTCSceneTy* rtcScene) const {
    rtcReleaseScene(rtcScene);
}

bool PolygonTracer::isHole(const CutOut& cutOut, std::uint32_t triangle, float u, float v) {
    const auto [a, b, c] = cutOut.mesh->triangles[triangle];
    const std::vector<glm::vec2>& places = cutOut.mesh->texturePlaces;
    const glm::vec2 place = places[a] * (1.0f - u - v) + places[b] * u + places[c] * v;
    const Image<Rgba8>& picture = *cutOut.alpha;
    return blend(texelsAt(place, picture.width(), picture.height()),
                 [&](int x, int y) { return static_cast<float>(picture(x, y).a) / 255.0f; }) < cutOut.cut;
}

void PolygonTracer::attachMesh(RTCSceneTy* to, unsigned id, std::uint32_t meshIndex,
                               const glm::dmat4& centredFromMesh) {
    const PolygonMesh& mesh = scene_.meshes[meshIndex];
    RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                                 3 * sizeof(float), mesh.positions.size()));
    auto* indices = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), mesh.triangles.size()));
    if (vertices == nullptr || indices == nullptr)
        throw Failure("not enough memory to trace rays into", mesh.name, "close other programs, or divide the scene");
    for (const glm::vec3& p : mesh.positions) {
        const glm::dvec4 moved = centredFromMesh * glm::dvec4(glm::dvec3(p), 1.0);
        for (int axis = 0; axis < 3; ++axis)
            *vertices++ = static_cast<float>(moved[axis]);
    }
    for (const auto& triangle : mesh.triangles)
        indices = std::copy(triangle.begin(), triangle.end(), indices);

    const PolygonMaterial& material = scene_.materials[mesh.material];
    if (material.alphaTexture != kNoTexture && !mesh.texturePlaces.empty()) {
        const auto& alpha = scene_.textures[static_cast<std::size_t>(material.alphaTexture)].pixels;
        cutOuts_.push_back(std::make_unique<CutOut>(CutOut{&mesh, &alpha, material.alphaCut}));
        rtcSetGeometryUserData(geometry, cutOuts_.back().get());
        const auto filter = [](const RTCFilterFunctionNArguments* args) {
            assert(args->N == 1);
            const auto& hit = *reinterpret_cast<const RTCHit*>(args->hit);
            if (isHole(*static_cast<const CutOut*>(args->geometryUserPtr), hit.primID, hit.u, hit.v))
                args->valid[0] = 0;
        };
        rtcSetGeometryIntersectFilterFunction(geometry, filter);
        rtcSetGeometryOccludedFilterFunction(geometry, filter);
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(to, geometry, id);
    rtcReleaseGeometry(geometry);
}

RTCSceneTy* PolygonTracer::sceneOf(std::uint32_t mesh) {
    ScenePointer& meshScene = meshScenes_[mesh];
    if (meshScene == nullptr) {
        meshScene.reset(rtcNewScene(device_.get()));
        rtcSetSceneFlags(meshScene.get(), RTC_SCENE_FLAG_ROBUST);
        attachMesh(meshScene.get(), 0, mesh, glm::dmat4(1.0));
        rtcCommitScene(meshScene.get());
    }
    return meshScene.get();
}

void PolygonTracer::attachInstance(unsigned id, const PolygonInstance& instance) {
    RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(geometry, sceneOf(instance.mesh));
    std::array<float, 12> columns{};
    for (std::size_t i = 0; i < columns.size(); ++i) {
        const auto column = static_cast<int>(i / 3), row = static_cast<int>(i % 3);
        const double moved = instance.worldFromMesh[column][row] - (column == 3 ? middle_[row] : 0.0);
        columns[i] = static_cast<float>(moved);
    }
    rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns.data());
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(world_.get(), geometry, id);
    rtcReleaseGeometry(geometry);
}

std::optional<PolygonHit> PolygonTracer::cast(const glm::dvec3& origin, const glm::dvec3& direction) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit found{};
    found.ray = rayOf(origin - middle_, direction, std::numeric_limits<double>::infinity());
    found.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    found.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(world_.get(), &context, &found);
    if (found.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;

    PolygonHit hit;
    hit.instance = found.hit.instID[0] != RTC_INVALID_GEOMETRY_ID ? found.hit.instID[0] : found.hit.geomID;
    hit.triangle = found.hit.primID;
    const TriangleInWorld triangle = triangleOf(hit);
    const double along = glm::dot(triangle.across, direction);
    hit.isBack = along > 0;
    hit.t = glm::dot(triangle.across, triangle.corners[0] - origin) / along;
    // A ray within the triangle's plane: Embree's own answer is the best there is.
    const double rounding = std::abs(static_cast<double>(found.ray.tfar)) * 1e-3 + skinMetres_ / glm::length(direction);
    if (!(hit.t > 0) || std::abs(hit.t - found.ray.tfar) > rounding) hit.t = found.ray.tfar;
    return hit;
}

bool PolygonTracer::isBlocked(const glm::dvec3& origin, const glm::dvec3& direction, double lengths) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRay ray = rayOf(origin - middle_, direction, lengths);
    rtcOccluded1(world_.get(), &context, &ray);
    return ray.tfar < 0;
}

TriangleInWorld PolygonTracer::triangleOf(const PolygonHit& hit) const {
    const PolygonInstance& instance = scene_.instances[hit.instance];
    const PolygonMesh& mesh = scene_.meshes[instance.mesh];
    const auto& corners = mesh.triangles[hit.triangle];
    TriangleInWorld triangle;
    for (std::size_t i = 0; i < 3; ++i)
        triangle.corners[i] =
            glm::dvec3(instance.worldFromMesh * glm::dvec4(glm::dvec3(mesh.positions[corners[i]]), 1.0));
    triangle.across = glm::cross(triangle.corners[1] - triangle.corners[0], triangle.corners[2] - triangle.corners[0]);
    if (isMirrored_[hit.instance]) triangle.across = -triangle.across;
    return triangle;
}

SightLines sightLinesOf(const PolygonTracer& tracer) {
    constexpr double kShort = 1e-4; // of the line, and more than rays err
    const auto cast = [&tracer](const glm::dvec3& from, const glm::dvec3& direction) -> std::optional<SightEnd> {
        const std::optional<PolygonHit> hit = tracer.cast(from, direction);
        if (!hit) return std::nullopt;
        return SightEnd{from + hit->t * direction, glm::normalize(tracer.triangleOf(*hit).across)};
    };
    const auto isBlocked = [&tracer](const glm::dvec3& from, const glm::dvec3& to) {
        const double length = glm::length(to - from), lengths = 1 - kShort - 2 * tracer.skinMetres() / length;
        return lengths > 0 && tracer.isBlocked(from, to - from, lengths);
    };
    return {cast, isBlocked};
}

} // namespace scene
