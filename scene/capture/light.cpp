#include "scene/capture/light.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <tbb/parallel_for.h>

namespace scene {

namespace {

constexpr int kMostSteps = 256; ///< of nodes along an edge: 33,000 nodes on the largest triangles
/// Share of the way between two nodes by which those on an edge are drawn in.
constexpr double kDrawnIn = 0.03;
constexpr double kFarAway = std::numeric_limits<double>::infinity();
constexpr float kLeastTrust = 1e-3f;  ///< so that rooms whose every face is turned round are lit, too
constexpr float kEnoughTrust = 0.05f; ///< of three nodes together
constexpr int kReachOfTrust = 2;      ///< nodes to each side that are asked where there is less
enum : std::uint8_t { kUnknown, kBusy, kKnown };

/// A rotation of +Z to a unit vector, smooth but for the one that points along -Z. Duff et al., "Building an
/// orthonormal basis, revisited", 2017.
glm::dmat3 frameAbout(const glm::dvec3& n) {
    const double sign = std::copysign(1.0, n.z), a = -1.0 / (sign + n.z), b = n.x * n.y * a;
    return {glm::dvec3(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), glm::dvec3(b, sign + n.y * n.y * a, -n.y),
            n};
}

/// Directions about +Z as dense as the cosine, on a spiral that leaves no clumps.
std::vector<glm::dvec3> cosineSpiral(int count) {
    const double golden = std::numbers::pi * (3.0 - std::sqrt(5.0));
    std::vector<glm::dvec3> directions;
    for (int i = 0; i < count; ++i) {
        const double r2 = (i + 0.5) / count, r = std::sqrt(r2), turn = golden * i;
        directions.emplace_back(r * std::cos(turn), r * std::sin(turn), std::sqrt(1.0 - r2));
    }
    return directions;
}

/// Nodes (i, j) with i + j <= steps, row j after row j - 1.
std::size_t indexOf(int steps, int i, int j) {
    return static_cast<std::size_t>(j * (steps + 1) - j * (j - 1) / 2 + i);
}

template <class T>
T blend(const std::vector<T>& values, const std::array<std::uint32_t, 3>& corners, const glm::dvec3& weights) {
    using Number = typename T::value_type;
    return values[corners[0]] * static_cast<Number>(weights.x) + values[corners[1]] * static_cast<Number>(weights.y) +
           values[corners[2]] * static_cast<Number>(weights.z);
}

} // namespace

SurfaceLight::Nodes::Nodes(int stepCount)
    : steps(stepCount), nodes(static_cast<std::size_t>((stepCount + 1) * (stepCount + 2) / 2)) {}

SurfaceLight::SurfaceLight(const PolygonTracer& tracer, const CaptureLight& light)
    : tracer_(tracer), light_(light), textures_(tracer.scene().textures.size()), hemisphere_(cosineSpiral(light.rays)) {
    assert(glm::length(light.towardsSun) > 0 && light.rays > 0 && light.spacingMetres > 0);
    light_.towardsSun = glm::normalize(light.towardsSun);
    const PolygonBounds& bounds = tracer.bounds();
    light_.spacingMetres = std::max(light.spacingMetres, kLeastSpacing * glm::distance(bounds.low, bounds.high));
    light_.sun *= light.sunStrength, light_.fill *= light.fillStrength;
    for (glm::vec3* const colour : {&light_.zenith, &light_.horizon, &light_.ground})
        *colour *= light.skyStrength;
    const PolygonScene& scene = tracer.scene();
    std::vector<bool> isCutOut(textures_.size(), false);
    for (const PolygonMaterial& material : scene.materials)
        if (material.colourTexture != kNoTexture && material.alphaTexture != kNoTexture)
            isCutOut[static_cast<std::size_t>(material.colourTexture)] = true;
    tbb::parallel_for(std::size_t{0}, textures_.size(), [&](std::size_t i) {
        textures_[i] = std::make_unique<TexturePyramid>(scene.textures[i].pixels, isCutOut[i]);
    });
    std::size_t triangles = 0;
    for (const PolygonInstance& instance : scene.instances) {
        firstTriangle_.push_back(triangles);
        triangles += scene.meshes[instance.mesh].triangles.size();
    }
    nodes_ = std::vector<std::atomic<Nodes*>>(2 * triangles);
}

SurfaceLight::~SurfaceLight() {
    for (const std::atomic<Nodes*>& nodes : nodes_)
        delete nodes.load();
}

glm::vec3 SurfaceLight::skyTowards(const glm::dvec3& direction) const {
    const auto height = static_cast<float>(direction.y / glm::length(direction));
    if (height < 0) return glm::mix(light_.horizon, light_.ground, std::min(1.0f, -8 * height));
    return glm::mix(light_.horizon, light_.zenith, std::sqrt(height));
}

glm::vec3 SurfaceLight::exposed(const glm::vec3& linear) const {
    const float brightness = glm::dot(linear, glm::vec3(0.2126f, 0.7152f, 0.0722f));
    return linear * ((1 + brightness / (light_.white * light_.white)) / (1 + brightness));
}

glm::dvec3 SurfaceLight::bentNormal(const PolygonHit& hit, const glm::dvec3& weights,
                                    const glm::dvec3& flatNormal) const {
    const PolygonScene& scene = tracer_.scene();
    const PolygonMesh& mesh = scene.meshes[scene.instances[hit.instance].mesh];
    if (mesh.normals.empty()) return flatNormal;
    const glm::vec3 inMesh = blend(mesh.normals, mesh.triangles[hit.triangle], weights);
    const glm::dvec3 bent = tracer_.worldFromMeshNormals(hit.instance) * glm::dvec3(inMesh);
    const double length = glm::length(bent);
    if (!(length > 0)) return flatNormal;
    // Files disagree about which side normals are on; what counts is the side that is looked at.
    return bent * ((glm::dot(bent, flatNormal) < 0 ? -1.0 : 1.0) / length);
}

PolygonPoint SurfaceLight::pointAt(const glm::dvec3& origin, const glm::dvec3& direction, const PolygonHit& hit) const {
    const TriangleInWorld triangle = tracer_.triangleOf(hit);
    PolygonPoint point;
    point.position = origin + direction * hit.t;
    point.weights = glm::max(weightsAt(triangle, point.position), glm::dvec3(0));
    point.weights /= point.weights.x + point.weights.y + point.weights.z;
    const double area = glm::length(triangle.across);
    point.flatNormal = area > 0 ? triangle.across / area : -glm::normalize(direction);
    if (hit.isBack) point.flatNormal = -point.flatNormal;
    point.normal = bentNormal(hit, point.weights, point.flatNormal);
    return point;
}

glm::vec2 SurfaceLight::texturePlaceAt(const PolygonHit& hit, const glm::dvec3& weights) const {
    const PolygonScene& scene = tracer_.scene();
    const PolygonMesh& mesh = scene.meshes[scene.instances[hit.instance].mesh];
    return mesh.texturePlaces.empty() ? glm::vec2(0) : blend(mesh.texturePlaces, mesh.triangles[hit.triangle], weights);
}

glm::vec3 SurfaceLight::colourAt(const PolygonHit& hit, const PolygonPoint& point,
                                 const TextureFootprint& footprint) const {
    const PolygonScene& scene = tracer_.scene();
    const PolygonMesh& mesh = scene.meshes[scene.instances[hit.instance].mesh];
    const PolygonMaterial& material = scene.materials[mesh.material];
    glm::vec3 colour = material.baseColour;
    if (!mesh.colours.empty()) colour *= blend(mesh.colours, mesh.triangles[hit.triangle], point.weights);
    if (material.colourTexture != kNoTexture && !mesh.texturePlaces.empty())
        colour *= textures_[static_cast<std::size_t>(material.colourTexture)]->colourAt(
            texturePlaceAt(hit, point.weights), footprint);
    return colour;
}

glm::vec3 SurfaceLight::meanColourOf(const PolygonHit& hit, const glm::dvec3& weights) const {
    const PolygonScene& scene = tracer_.scene();
    const PolygonMesh& mesh = scene.meshes[scene.instances[hit.instance].mesh];
    const PolygonMaterial& material = scene.materials[mesh.material];
    glm::vec3 colour = material.baseColour;
    if (!mesh.colours.empty()) colour *= blend(mesh.colours, mesh.triangles[hit.triangle], weights);
    if (material.colourTexture != kNoTexture)
        colour *= textures_[static_cast<std::size_t>(material.colourTexture)]->mean();
    return colour;
}

glm::vec3 SurfaceLight::sunAt(const PolygonPoint& point) const {
    const double slant = glm::dot(point.normal, light_.towardsSun);
    if (slant <= 0 || glm::dot(point.flatNormal, light_.towardsSun) <= 0) return glm::vec3(0);
    raysCast_.fetch_add(1, std::memory_order_relaxed);
    const glm::dvec3 start = point.position + point.flatNormal * tracer_.skinMetres();
    if (tracer_.isBlocked(start, light_.towardsSun, kFarAway)) return glm::vec3(0);
    return light_.sun * static_cast<float>(slant);
}

SurfaceLight::Gathered SurfaceLight::gather(const PolygonPoint& point) const {
    const glm::dmat3 worldFromNormal = frameAbout(point.normal);
    const glm::dvec3 start = point.position + point.flatNormal * tracer_.skinMetres();
    glm::vec3 sum(0);
    int count = 0, backs = 0;
    for (const glm::dvec3& about : hemisphere_) {
        const glm::dvec3 direction = worldFromNormal * about;
        if (glm::dot(direction, point.flatNormal) <= 0) continue;
        ++count;
        const std::optional<PolygonHit> hit = tracer_.cast(start, direction);
        if (!hit) {
            sum += skyTowards(direction);
            continue;
        }
        backs += hit->isBack;
        const PolygonPoint there = pointAt(start, direction, *hit);
        const double reach = light_.fillReachMetres, share = reach > 0 ? hit->t / (hit->t + reach) : 1.0;
        sum += meanColourOf(*hit, there.weights) * sunAt(there) + light_.fill * static_cast<float>(share);
    }
    raysCast_.fetch_add(count, std::memory_order_relaxed);
    if (count == 0) return {glm::vec3(0), kLeastTrust};
    const float free = 1 - static_cast<float>(backs) / static_cast<float>(count);
    return {sum / static_cast<float>(count), std::max(free * free, kLeastTrust)};
}

SurfaceLight::Nodes& SurfaceLight::nodesOf(const PolygonHit& hit, const TriangleInWorld& triangle) const {
    std::atomic<Nodes*>& slot = nodes_[2 * (firstTriangle_[hit.instance] + hit.triangle) + (hit.isBack ? 1 : 0)];
    if (Nodes* const known = slot.load(std::memory_order_acquire)) return *known;
    const auto& [a, b, c] = triangle.corners;
    const double longest = std::max({glm::distance(a, b), glm::distance(b, c), glm::distance(c, a)});
    const double steps = std::clamp(std::ceil(longest / light_.spacingMetres), 1.0, static_cast<double>(kMostSteps));
    auto made = std::make_unique<Nodes>(static_cast<int>(steps));
    Nodes* first = nullptr;
    if (slot.compare_exchange_strong(first, made.get(), std::memory_order_acq_rel)) return *made.release();
    return *first;
}

SurfaceLight::Gathered SurfaceLight::gatheredAt(const PolygonHit& hit, const TriangleInWorld& triangle, Nodes& nodes,
                                                int i, int j) const {
    Node& node = nodes.nodes[indexOf(nodes.steps, i, j)];
    if (node.state.load(std::memory_order_acquire) == kKnown) return node.gathered;

    const double steps = nodes.steps;
    const auto& [a, b, c] = triangle.corners;
    const double shortest = std::min({glm::distance(a, b), glm::distance(b, c), glm::distance(c, a)});
    const double drawnIn = std::min(std::max(kDrawnIn / steps, 2 * tracer_.skinMetres() / shortest), 0.3);
    PolygonPoint point;
    point.weights = {1.0 - (i + j) / steps, i / steps, j / steps};
    point.weights = glm::mix(point.weights, glm::dvec3(1.0 / 3), drawnIn);
    point.position = a * point.weights.x + b * point.weights.y + c * point.weights.z;
    point.flatNormal = glm::normalize(triangle.across) * (hit.isBack ? -1.0 : 1.0);
    point.normal = bentNormal(hit, point.weights, point.flatNormal);
    const Gathered gathered = gather(point);

    // Whoever comes while another writes keeps what it found itself: it is the same.
    std::uint8_t expected = kUnknown;
    if (node.state.compare_exchange_strong(expected, kBusy, std::memory_order_acq_rel)) {
        node.gathered = gathered;
        node.state.store(kKnown, std::memory_order_release);
    }
    return gathered;
}

SurfaceLight::Gathered SurfaceLight::gatheredAround(const PolygonHit& hit, const TriangleInWorld& triangle,
                                                    Nodes& nodes, int i, int j) const {
    Gathered around;
    for (int dj = -kReachOfTrust; dj <= kReachOfTrust + 1; ++dj)
        for (int di = -kReachOfTrust; di <= kReachOfTrust + 1; ++di) {
            if (i + di < 0 || j + dj < 0 || i + di + j + dj > nodes.steps) continue;
            const Gathered node = gatheredAt(hit, triangle, nodes, i + di, j + dj);
            around.light += node.light * node.trust;
            around.trust += node.trust;
        }
    around.light /= around.trust;
    return around;
}

glm::vec3 SurfaceLight::at(const PolygonHit& hit, const PolygonPoint& point) const {
    const TriangleInWorld triangle = tracer_.triangleOf(hit);
    if (!(glm::length(triangle.across) > 0)) return light_.fill;
    Nodes& nodes = nodesOf(hit, triangle);
    const int steps = nodes.steps;
    const double u = point.weights.y * steps, v = point.weights.z * steps;
    const int i = std::min(static_cast<int>(u), steps - 1);
    const int j = std::clamp(static_cast<int>(v), 0, steps - 1 - i);
    const auto s = static_cast<float>(u - i), t = static_cast<float>(v - j);
    glm::vec3 sum(0);
    float trust = 0;
    const auto add = [&](int di, int dj, float share) {
        const Gathered node = gatheredAt(hit, triangle, nodes, i + di, j + dj);
        const float weight = std::max(share, 0.0f) * node.trust;
        sum += node.light * weight;
        trust += weight;
    };
    if (s + t <= 1 || i + j + 2 > steps)
        add(0, 0, 1 - s - t), add(1, 0, s), add(0, 1, t);
    else
        add(1, 1, s + t - 1), add(0, 1, 1 - s), add(1, 0, 1 - t);
    if (trust < kEnoughTrust) { // all buried: what lies around them knows better
        const Gathered around = gatheredAround(hit, triangle, nodes, i, j);
        sum += around.light * (kEnoughTrust - trust);
        trust = kEnoughTrust;
    }
    return sum / trust + sunAt(point);
}

} // namespace scene
