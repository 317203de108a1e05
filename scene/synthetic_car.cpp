// A car as one smooth shell of cross-sections, with wheels, and with what a collision did to it.

#include "scene/synthetic_furniture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace scene {

namespace {

constexpr double kHalfLength = 2.15, kHalfWidth = 0.88, kAxle = 1.36, kWheelRadius = 0.32; // metres
constexpr int kStations = 96, kAround = 64, kEndRings = 6;

/// Piecewise smooth between (x, value) pairs, flat at each.
double profile(double x, const std::array<glm::dvec2, 13>& points) {
    for (std::size_t i = 1; i < points.size(); ++i)
        if (x <= points[i].x) {
            const double t = std::clamp((x - points[i - 1].x) / (points[i].x - points[i - 1].x), 0.0, 1.0);
            return glm::mix(points[i - 1].y, points[i].y, 0.75 * t + 0.25 * t * t * (3.0 - 2.0 * t));
        }
    return points.back().y;
}

/// Height of the car along its middle line.
double topAt(double x) {
    return profile(x, {{{-2.15, 0.80},
                        {-2.08, 0.90},
                        {-1.95, 0.955},
                        {-1.78, 0.975},
                        {-1.10, 1.37},
                        {-0.80, 1.435},
                        {-0.30, 1.46},
                        {0.10, 1.435},
                        {0.34, 1.38},
                        {1.04, 0.955},
                        {1.60, 0.87},
                        {2.00, 0.74},
                        {2.15, 0.62}}});
}

/// The cross-section at x, from the sill (t = 0) over the side to the middle of the roof (t = 1); y positive.
glm::dvec2 sectionAt(double x, double t) {
    const double end = softStep(1.85, 0.35, std::abs(x));
    const double w = kHalfWidth - 0.10 * end, top = topAt(x), belt = std::min(0.93, top - 0.03);
    const double cabin = std::max(top - 0.955, 0.0);
    const double bottom = 0.20 + 0.10 * end;
    const double baseY = w - 0.075, roofY = baseY - 0.42 * cabin;
    const double flat = 1.0 - softStep(0.12, 0.12, cabin); // hood and boot: no cabin
    const std::array<glm::dvec2, 10> points{
        {{w - 0.07, bottom},
         {w - 0.015, bottom + 0.10},
         {w, glm::mix(0.55, 0.48, end)},
         {w - 0.012, glm::mix(0.74, std::min(0.66, top - 0.1), end)},
         {w - 0.045, belt - 0.02 * flat},
         {baseY, glm::mix(0.955, std::min(0.955, top - 0.022), flat)},
         {glm::mix(glm::mix(baseY, roofY, 0.5), baseY * 0.85, flat),
          glm::mix(0.955 + 0.5 * (cabin - 0.05), top - 0.012, flat)},
         {glm::mix(roofY, baseY * 0.66, flat), glm::mix(top - 0.055, top - 0.006, flat)},
         {roofY * 0.82 * (1 - flat) + baseY * 0.45 * flat, glm::mix(top - 0.012, top - 0.001, flat)},
         {0.0, top + 0.004}}};
    const double place = t * 9.0;
    const int piece = std::min(static_cast<int>(place), 8);
    const double u = place - piece;
    const auto at = [&](int i) { return points[static_cast<std::size_t>(std::clamp(i, 0, 9))]; };
    const glm::dvec2 a = at(piece - 1), b = at(piece), c = at(piece + 1), d = at(piece + 2);
    // Half way between the corners' polygon and a curve through them: panels with soft edges.
    const glm::dvec2 curve = 0.5 * (2.0 * b + (c - a) * u + (2.0 * a - 5.0 * b + 4.0 * c - d) * (u * u) +
                                    (3.0 * b - a - 3.0 * c + d) * (u * u * u));
    return glm::mix(glm::mix(b, c, u), curve, 0.7);
}

/// The undamaged surface: s along the car from the rear to the front, t around it from the right sill to the
/// left one. The body's sheet runs around from left to right, so that it faces outwards.
glm::dvec3 shellAt(double s, double t) {
    const double station = s * (kStations + 2 * kEndRings) - kEndRings;
    const double x = glm::mix(-kHalfLength, kHalfLength, std::clamp(station / kStations, 0.0, 1.0));
    const double half = 1.0 - std::abs(2.0 * t - 1.0), sign = t < 0.5 ? -1.0 : 1.0;
    glm::dvec2 section = sectionAt(x, half);
    // The ends close towards the middle line; bumpers are round seen from above.
    const double beyond = std::max(-station, station - kStations) / kEndRings;
    if (beyond > 0) section.x *= 1.0 - beyond;
    const double rounding = softStep(1.75, 0.40, std::abs(x));
    const double bend = 0.17 * rounding * (section.x * section.x) / (kHalfWidth * kHalfWidth);
    double height = section.y;
    double bulge = 0.0;
    if (std::abs(x) > 1.9) bulge = 0.05 * softStep(0.66, 0.10, 1.0 - std::abs(height - 0.48) * 1.2);
    return {x - std::copysign(bend - bulge * rounding, x), sign * section.x, height};
}

/// What the collision did, in the car's coordinates.
glm::dvec3 damaged(const CarShape& shape, glm::dvec3 p) {
    const auto buckle = [&](double size, std::uint32_t salt) {
        return layeredNoise(p * size, 3, shape.seed + salt) - 0.5;
    };
    if (shape.frontCrush > 0 && p.x > 0.9) {
        const double part = softStep(1.65, 0.7, p.x), lean = 1.0 + 0.35 * p.y / kHalfWidth;
        const double ridge = std::sin((p.x - 0.95) * 5.2 + 0.7 * p.y) * softStep(0.62, 0.12, p.z);
        const double x = p.x;
        p.x -= shape.frontCrush * part * lean * (1.0 + 0.5 * buckle(2.6, 1)) * softStep(0.9, 0.3, x);
        p.z += part * (0.20 * std::max(ridge, 0.0) + 0.16 * buckle(3.0, 2)) * (p.z > 0.55 ? 1.0 : 0.35);
        p.y += part * 0.20 * buckle(2.4, 3);
    }
    if (shape.sideDent > 0 && p.y < -0.3) {
        const double from = (p.x - shape.dentAt) / 0.85;
        const double depth = std::exp(-from * from * from * from) * (1.0 - softStep(1.05, 0.35, p.z)) *
                             softStep(-0.62, 0.28, -p.y - 1.25);
        p.y += shape.sideDent * std::exp(-from * from) * (1.0 - 0.8 * softStep(1.05, 0.35, p.z)) *
               (0.9 + 0.7 * buckle(3.2, 4));
        p.z += 0.06 * depth * buckle(3.5, 5);
        p.x += 0.10 * depth * buckle(3.0, 6);
    }
    return p;
}

/// Wheel wells: the side is pushed in around the axles.
glm::dvec3 welled(glm::dvec3 p) {
    if (std::abs(p.y) < 0.66 || p.z > 0.75) return p;
    for (const double axle : {kAxle, -kAxle}) {
        const double fromAxle = glm::length(glm::dvec2(p.x - axle, p.z - kWheelRadius));
        p.y = glm::mix(std::copysign(0.58, p.y), p.y, softStep(0.335, 0.03, fromAxle));
    }
    return p;
}

} // namespace

void addCar(SyntheticModel& model, const Pose& worldFromCar, const CarShape& shape) {
    const int body = addMaterial(model, {Pattern::carBody, shape.paint, {}, 1.0, shape.seed});
    addSheet(
        model, static_cast<int>(kAround * shape.fineness),
        static_cast<int>((kStations + 2 * kEndRings) * shape.fineness),
        [&](double s, double t) { return worldFromCar * damaged(shape, welled(shellAt(t, 1.0 - s))); },
        [&](double s, double t) { return shellAt(t, 1.0 - s); }, body);

    const int dark = addMaterial(model, {Pattern::plain, glm::dvec3(0.012)});
    addBox(model, worldFromCar, {-1.95, -0.60, 0.18}, {shape.frontCrush > 0 ? 1.35 : 1.95, 0.60, 0.40}, dark);
    const int rubber = addMaterial(model, {Pattern::mottled, glm::dvec3(0.012), glm::dvec3(0.03), 0.03, 3});
    const int rim =
        addMaterial(model, {Pattern::wheel, glm::dvec3(0.42, 0.43, 0.45), {}, kWheelRadius, shape.seed % 6});
    for (const double axle : {kAxle, -kAxle})
        for (const double side : {-1.0, 1.0}) {
            // The front wheel on the struck side stands askew.
            const bool isBent = shape.frontCrush > 0 && axle > 0;
            const glm::dvec3 hub(axle - (isBent ? 0.55 * shape.frontCrush : 0.0), side * 0.765, kWheelRadius);
            const double steer = isBent ? 0.32 : 0.0;
            glm::dvec3 out(-std::sin(steer) * side, std::cos(steer) * side, isBent ? 0.06 : 0.0);
            out = glm::normalize(out);
            const glm::dvec3 inner = worldFromCar * (hub - out * 0.10), outer = worldFromCar * (hub + out * 0.095);
            addTube(model, inner, outer, kWheelRadius, rubber);
            addDisc(model, inner, inner - outer, kWheelRadius, rubber);
            addDisc(model, outer, outer - inner, kWheelRadius, rim);
        }
    // Mirrors.
    const int paint = addMaterial(model, {Pattern::plain, shape.paint});
    for (const double side : {-1.0, 1.0}) {
        if (side < 0 && shape.sideDent > 0) continue; // torn off
        const Pose mirror = worldFromCar * standing({0.72, side * 0.90, 0.97}, side * 0.12);
        addBox(model, mirror, {-0.05, -0.085, -0.055}, {0.06, 0.085, 0.065}, paint);
    }
}

} // namespace scene
