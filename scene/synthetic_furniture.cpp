#include "scene/synthetic_furniture.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace scene {

void addChair(SyntheticModel& model, const Pose& worldFromChair, int wood, int cloth) {
    const double half = 0.21;
    for (const double x : {-half, half}) {
        addRod(model, worldFromChair * glm::dvec3(x, -half, 0), worldFromChair * glm::dvec3(x, -half, 0.43), 0.019,
               wood);
        addRod(model, worldFromChair * glm::dvec3(x, half, 0), worldFromChair * glm::dvec3(x * 0.95, half + 0.05, 0.92),
               0.019, wood);
    }
    addBox(model, worldFromChair, {-half - 0.02, -half - 0.03, 0.43}, {half + 0.02, half, 0.462}, wood);
    addBox(model, worldFromChair, {-half, -half - 0.01, 0.4625}, {half, half - 0.03, 0.49}, cloth);
    for (const double z : {0.60, 0.72, 0.84})
        addBox(model, worldFromChair, {-half + 0.01, half + 0.015, z}, {half - 0.01, half + 0.032, z + 0.065}, wood);
    for (const double y : {-half, half})
        addBox(model, worldFromChair, {-half, y - 0.008, 0.20}, {half, y + 0.008, 0.225}, wood);
}

void addTable(SyntheticModel& model, const Pose& worldFromTable, const glm::dvec3& size, int wood) {
    const double x = size.x / 2, y = size.y / 2;
    addBox(model, worldFromTable, {-x, -y, size.z - 0.035}, {x, y, size.z}, wood);
    for (const double sx : {-1.0, 1.0})
        for (const double sy : {-1.0, 1.0}) {
            const glm::dvec3 foot(sx * (x - 0.07), sy * (y - 0.07), 0);
            addTube(model, worldFromTable * foot, worldFromTable * (foot + glm::dvec3(0, 0, size.z - 0.035)), 0.032,
                    wood);
        }
    addBox(model, worldFromTable, {-x + 0.1, -y + 0.05, size.z - 0.12}, {x - 0.1, -y + 0.07, size.z - 0.036}, wood);
    addBox(model, worldFromTable, {-x + 0.1, y - 0.07, size.z - 0.12}, {x - 0.1, y - 0.05, size.z - 0.036}, wood);
}

namespace {

/// A box with generously rounded edges, as upholstery has: a superellipsoid.
void addCushion(SyntheticModel& model, const Pose& worldFromCushion, const glm::dvec3& centre, const glm::dvec3& half,
                int material, double roundness) {
    const auto power = [&](double value) { return std::copysign(std::pow(std::abs(value), roundness), value); };
    const auto shape = [&](double s, double t) {
        const double angle = s * 6.283185307179586, rise = (t - 0.5) * 3.141592653589793;
        const double girth = power(std::cos(rise));
        return glm::dvec3(half.x * girth * power(std::cos(angle)), half.y * girth * power(std::sin(angle)),
                          half.z * power(std::sin(rise)));
    };
    addSheet(
        model, 36, 18, [&](double s, double t) { return worldFromCushion * (centre + shape(s, t)); },
        [&](double s, double t) {
            const glm::dvec3 p = shape(s, t);
            return glm::dvec3(p.x + 0.3 * p.y, p.y + p.z, 0);
        },
        material);
}

} // namespace

void addSofa(SyntheticModel& model, const Pose& worldFromSofa, double width, int cloth, int pillow) {
    const double x = width / 2;
    addBox(model, worldFromSofa, {-x, -0.40, 0.09}, {x, 0.42, 0.30}, cloth);
    const int foot = addMaterial(model, {Pattern::plain, glm::dvec3(0.05, 0.03, 0.02)});
    for (const double sx : {-x + 0.1, x - 0.1})
        for (const double y : {-0.32, 0.34})
            addTube(model, worldFromSofa * glm::dvec3(sx, y, 0), worldFromSofa * glm::dvec3(sx, y, 0.09), 0.025, foot);
    for (const double sx : {-x + 0.09, x - 0.09})
        addCushion(model, worldFromSofa, {sx, 0.0, 0.40}, {0.11, 0.43, 0.24}, cloth, 0.3);
    const int seats = width > 1.7 ? 3 : 2;
    const double seat = (width - 0.40) / seats;
    for (int i = 0; i < seats; ++i) {
        const double centre = -x + 0.20 + seat * (i + 0.5);
        addCushion(model, worldFromSofa, {centre, -0.08, 0.36}, {seat * 0.5, 0.35, 0.10}, cloth, 0.3);
        addCushion(model, worldFromSofa, {centre, 0.30, 0.60}, {seat * 0.5, 0.13, 0.25}, cloth, 0.35);
    }
    const Pose leaning = standing({-x + 0.42, 0.08, 0.62}, 0.5);
    addCushion(model, worldFromSofa * leaning, {0, 0, 0}, {0.21, 0.08, 0.20}, pillow, 0.55);
    addCushion(model, worldFromSofa * standing({x - 0.42, 0.08, 0.62}, -0.4), {0, 0, 0}, {0.21, 0.08, 0.20}, pillow,
               0.55);
}

void addBookcase(SyntheticModel& model, const Pose& worldFromCase, const glm::dvec3& size, int wood,
                 SeededSequence& random) {
    const double x = size.x / 2, board = 0.022;
    for (const double side : {-x, x - board})
        addBox(model, worldFromCase, {side, 0, 0}, {side + board, size.y, size.z}, wood);
    addBox(model, worldFromCase, {-x + board, size.y - 0.008, 0.05}, {x - board, size.y - 0.001, size.z - 0.001}, wood);
    const int shelves = 5;
    const double step = (size.z - board - 0.06) / shelves;
    const std::uint32_t paints[] = {0x8c2f2b, 0x27496d, 0x2f5d50, 0xc9a227, 0x6b4a7b,
                                    0x3b3b3b, 0xb5651d, 0xd9d2c0, 0x4f7942, 0x9b4f62};
    for (int shelf = 0; shelf <= shelves; ++shelf) {
        const double z = 0.06 + step * shelf;
        addBox(model, worldFromCase, {-x + board, 0.002, z}, {x - board, size.y - 0.009, z + board}, wood);
        if (shelf == shelves) break;
        double at = -x + board + 0.01;
        const double end = x - board - 0.03, top = step - board - 0.03;
        while (at < end) {
            if (random.unit() < 0.10) { // a gap, with something in it
                const double radius = random.between(0.045, 0.07);
                if (at + 2 * radius + 0.03 > end) break;
                const int glaze =
                    addMaterial(model, {Pattern::mottled, reflectance(paints[random.bits() % 10]),
                                        reflectance(0xe8e0d0), 0.04, static_cast<std::uint32_t>(random.bits() & 1023)});
                const glm::dvec3 foot = glm::dvec3(at + radius + 0.01, size.y * 0.45, z + board);
                if (random.unit() < 0.5)
                    addSphere(model, worldFromCase * (foot + glm::dvec3(0, 0, radius)), radius, glaze);
                else
                    addRod(model, worldFromCase * foot, worldFromCase * (foot + glm::dvec3(0, 0, top * 0.75)), radius,
                           glaze);
                at += 2 * radius + 0.03;
                continue;
            }
            const double thick = random.between(0.018, 0.048), height = random.between(0.62, 0.95) * top;
            const double deep = random.between(0.55, 0.80) * size.y;
            Material spine{Pattern::spine, reflectance(paints[random.bits() % 10]), reflectance(0xe3d3a0), height};
            spine.seed = static_cast<std::uint32_t>(random.bits() & 4095);
            if (at + thick > end) break;
            addBox(model, worldFromCase, {at, 0.015 + random.between(0, 0.02), z + board + 0.0005},
                   {at + thick - 0.0015, deep, z + board + height}, addMaterial(model, spine));
            at += thick;
        }
    }
}

} // namespace scene
