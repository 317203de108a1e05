// Plants: hundreds of thin leaves, the hardest thing for depth images.

#include "scene/synthetic_furniture.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace scene {

namespace {

glm::dvec3 randomDirection(SeededSequence& random) {
    const double z = random.between(-1, 1), angle = random.between(0, 6.283185307179586), r = std::sqrt(1 - z * z);
    return {r * std::cos(angle), r * std::sin(angle), z};
}

/// A leaf from its stem along a direction, seen best from the side it faces.
void addLeaf(SyntheticModel& model, const glm::dvec3& stem, const glm::dvec3& along, const glm::dvec3& facing,
             double length, double width, int material) {
    const glm::dvec3 u = glm::normalize(along), across = glm::cross(facing, u);
    if (glm::dot(across, across) < 1e-6) return;
    const glm::dvec3 v = glm::normalize(across);
    const auto at = [&](double x, double y) { return stem + u * (x * length) + v * (y * width); };
    Patch& leaf =
        addPolygon(model, {at(0, 0), at(0.35, -0.5), at(0.7, -0.36), at(1, 0), at(0.7, 0.36), at(0.35, 0.5)}, material);
    // The midrib is the texture's axis.
    std::vector<glm::dvec3> corners;
    for (const glm::dvec2& p : leaf.outline)
        corners.push_back(leaf.origin + leaf.u * p.x + leaf.v * p.y);
    leaf.u = u;
    leaf.v = glm::cross(leaf.normal, u);
    leaf.outline.clear();
    leaf.extent = {glm::dvec2(1e9), glm::dvec2(-1e9)};
    for (const glm::dvec3& p : corners) {
        const glm::dvec2 flat(glm::dot(p - leaf.origin, leaf.u), glm::dot(p - leaf.origin, leaf.v));
        leaf.outline.push_back(flat);
        leaf.extent = {glm::min(leaf.extent.low, flat), glm::max(leaf.extent.high, flat)};
    }
    leaf.twoSided = true;
}

std::vector<int> leafMaterials(SyntheticModel& model, std::uint32_t dark, std::uint32_t light, SeededSequence& random) {
    std::vector<int> materials;
    for (int i = 0; i < 4; ++i) {
        const double tone = random.between(0.75, 1.2);
        materials.push_back(addMaterial(model, {Pattern::leaf, reflectance(dark) * tone, reflectance(light) * tone, 1.0,
                                                static_cast<std::uint32_t>(random.bits() & 255)}));
    }
    return materials;
}

} // namespace

void addPottedPlant(SyntheticModel& model, const glm::dvec3& at, double height, SeededSequence& random) {
    const double radius = height * 0.14, pot = height * 0.26;
    const int clay = addMaterial(model, {Pattern::mottled, reflectance(0xa85a3a), reflectance(0xc98363), 0.08, 3});
    const int soil = addMaterial(model, {Pattern::mottled, reflectance(0x2a1c12), reflectance(0x5a4030), 0.03, 4});
    addTube(model, at, at + glm::dvec3(0, 0, pot), radius, clay);
    addDisc(model, at + glm::dvec3(0, 0, pot - 0.015), {0, 0, 1}, radius * 0.999, soil);
    const std::vector<int> greens = leafMaterials(model, 0x1f4d26, 0x6da04b, random);
    const int stems = 26;
    for (int i = 0; i < stems; ++i) {
        // An arching stalk, thin, that carries pairs of leaves and a last one.
        const double angle = i * 2.399963, reach = height * random.between(0.14, 0.42),
                     top = height * random.between(0.45, 1.0);
        const glm::dvec3 out(std::cos(angle), std::sin(angle), 0);
        const auto along = [&](double t) {
            return at + glm::dvec3(0, 0, pot - 0.015) + out * (radius * 0.4 * t + reach * t * t) +
                   glm::dvec3(0, 0, (top - pot) * (1.6 * t - 0.6 * t * t));
        };
        for (int k = 0; k < 4; ++k)
            addTube(model, along(k / 4.0), along((k + 1) / 4.0), 0.004, greens[0]);
        for (int k = 2; k <= 4; ++k) {
            const glm::dvec3 stem = along(k / 4.0), forward = glm::normalize(along(k / 4.0) - along(k / 4.0 - 0.2));
            for (const double side : {-1.0, 1.0}) {
                const glm::dvec3 way = forward * (k == 4 ? 0.9 : 0.4) +
                                       glm::cross(forward, glm::dvec3(0, 0, 1)) * (side * (k == 4 ? 0.4 : 1.0)) +
                                       randomDirection(random) * 0.25 - glm::dvec3(0, 0, 0.15);
                addLeaf(model, stem, way, glm::dvec3(0, 0, 1) + randomDirection(random) * 0.3,
                        height * random.between(0.13, 0.2), height * random.between(0.05, 0.075),
                        greens[random.bits() % 4]);
            }
        }
    }
}

void addTree(SyntheticModel& model, const glm::dvec3& at, double height, int leaves, SeededSequence& random) {
    const int bark = addMaterial(model, {Pattern::mottled, reflectance(0x4a3b2c), reflectance(0x85705a), 0.09, 5});
    const std::vector<int> greens = leafMaterials(model, 0x2b5a22, 0x8fb04a, random);
    const glm::dvec3 fork = at + glm::dvec3(0.05, -0.04, height * 0.42);
    addTube(model, at, fork, height * 0.024, bark);
    addSphere(model, fork, height * 0.024, bark);
    std::vector<glm::dvec3> tips;
    for (int i = 0; i < 7; ++i) {
        const double angle = i * 2.399963 + random.between(-0.3, 0.3), spread = random.between(0.10, 0.24) * height;
        const glm::dvec3 tip =
            fork + glm::dvec3(std::cos(angle) * spread, std::sin(angle) * spread, height * random.between(0.2, 0.46));
        addTube(model, fork, tip, height * 0.010, bark);
        tips.push_back(tip);
        for (int k = 0; k < 3; ++k) {
            const glm::dvec3 from = fork + (tip - fork) * random.between(0.45, 0.9);
            const glm::dvec3 twig = from + (randomDirection(random) + glm::dvec3(0, 0, 0.4)) * (height * 0.13);
            addTube(model, from, twig, height * 0.005, bark);
            tips.push_back(twig);
        }
    }
    for (int i = 0; i < leaves; ++i) {
        const glm::dvec3 from = tips[random.bits() % tips.size()];
        const glm::dvec3 stem = from + randomDirection(random) * (height * 0.16 * std::cbrt(random.unit()));
        const double length = height * random.between(0.026, 0.04);
        addLeaf(model, stem, randomDirection(random) - glm::dvec3(0, 0, 0.3),
                randomDirection(random) + glm::dvec3(0, 0, 0.8), length, length * 0.6, greens[random.bits() % 4]);
    }
}

void addHedge(SyntheticModel& model, const Pose& worldFromHedge, const glm::dvec3& size, int leaves,
              SeededSequence& random) {
    const int core = addMaterial(model, {Pattern::mottled, reflectance(0x142310), reflectance(0x2c4420), 0.12, 6});
    const glm::dvec3 half(size.x / 2, size.y / 2, 0);
    addBox(model, worldFromHedge, {-half.x + 0.12, -half.y + 0.12, 0}, {half.x - 0.12, half.y - 0.12, size.z - 0.12},
           core);
    const std::vector<int> greens = leafMaterials(model, 0x24491f, 0x6f9440, random);
    for (int i = 0; i < leaves; ++i) {
        // On the four sides and the top, in proportion to their area.
        const double sides = 2 * (size.x + size.y) * size.z, top = size.x * size.y;
        glm::dvec3 p, out;
        const double depth = random.between(0.0, 0.14);
        if (random.unit() * (sides + top) < top) {
            p = {random.between(-half.x, half.x), random.between(-half.y, half.y), size.z - depth};
            out = {0, 0, 1};
        } else {
            const bool isLong = random.unit() * (size.x + size.y) < size.x;
            const double sign = random.unit() < 0.5 ? -1.0 : 1.0;
            out = isLong ? glm::dvec3(0, sign, 0) : glm::dvec3(sign, 0, 0);
            p = isLong ? glm::dvec3(random.between(-half.x, half.x), sign * (half.y - depth), 0)
                       : glm::dvec3(sign * (half.x - depth), random.between(-half.y, half.y), 0);
            p.z = random.between(0.03, size.z);
        }
        const double length = random.between(0.06, 0.11);
        addLeaf(model, worldFromHedge * p, worldFromHedge.rotation * (out * 0.6 + randomDirection(random)),
                worldFromHedge.rotation * (out + randomDirection(random) * 0.7), length, length * 0.6,
                greens[random.bits() % 4]);
    }
}

} // namespace scene
