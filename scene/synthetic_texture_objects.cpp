// Patterns of made things: windows, doors, plates, leaves, cars.

#include "scene/synthetic_texture.h"

#include "scene/synthetic_random.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

namespace scene {

namespace {

/// 1 inside of [low, high], with soft edges.
double band(double value, double low, double high, double softness = 0.004) {
    return softStep(low, softness, value) * (1.0 - softStep(high, softness, value));
}

/// 1 on a line of the given width around value 0.
double stroke(double value, double width, double softness = 0.003) {
    return 1.0 - softStep(width / 2, softness, std::abs(value));
}

/// Distance from a segment of the plane.
double distanceToSegment(const glm::dvec2& p, const glm::dvec2& a, const glm::dvec2& b) {
    const glm::dvec2 along = b - a;
    const double part = std::clamp(glm::dot(p - a, along) / glm::dot(along, along), 0.0, 1.0);
    return glm::length(p - a - along * part);
}

glm::dvec3 pane(const Material& m, const glm::dvec3& p) {
    // What stands behind glass: dusk, a curtain edge, a light here and there; the frame is painted.
    const double column = std::floor(p.x / m.scale), x = p.x - column * m.scale;
    const double gloom = layeredNoise({p.x * 1.1, p.y * 1.1, m.seed * 0.37}, 3, m.seed);
    glm::dvec3 glass = m.base * (0.5 + 0.9 * gloom) + glm::dvec3(0.02, 0.03, 0.045) * softStep(0.0, 0.9, p.y);
    const double curtain = 0.12 + 0.16 * smoothNoise({p.x * 7.0, 0.5, m.seed * 1.0}, m.seed + 3);
    glass = glm::mix(glm::dvec3(0.30, 0.29, 0.26) * (0.7 + 0.5 * std::abs(std::sin(p.x * 60.0))), glass,
                     softStep(curtain * m.scale, 0.01, std::min(x, m.scale - x)));
    const double bars = std::max({stroke(x, 0.09, 0.004), stroke(x - m.scale, 0.09, 0.004), stroke(p.y, 0.12, 0.004),
                                  stroke(p.y - m.scale * 1.25, 0.05, 0.004)});
    return glm::mix(glass, m.accent, bars);
}

glm::dvec3 door(const Material& m, const glm::dvec3& p) {
    const double u = p.x / m.scale, wander = layeredNoise({p.x * 8.0, p.y * 1.2, m.seed * 0.7}, 3, m.seed);
    glm::dvec3 colour = glm::mix(m.base, m.accent, 0.2 + 0.6 * wander);
    for (const double low : {0.16, 1.08}) {
        const double high = low + (low < 0.5 ? 0.72 : 0.84);
        const double inX = std::min(u - 0.16, 0.84 - u) * m.scale, inY = std::min(p.y - low, high - p.y);
        const double edge = std::min(inX, inY);
        colour *= 1.0 - 0.45 * stroke(edge, 0.018) + 0.18 * stroke(edge - 0.02, 0.014);
    }
    colour = glm::mix(colour, glm::dvec3(0.45, 0.43, 0.40), band(u, 0.02, 0.98) * band(p.y, 0.02, 0.13) * 0.8);
    const glm::dvec2 handle(p.x - 0.91 * m.scale, p.y - 1.02);
    const double lever = distanceToSegment(handle, {0, 0}, {-0.10, 0.0});
    colour = glm::mix(colour, glm::dvec3(0.50, 0.49, 0.46), 1.0 - softStep(0.012, 0.003, lever));
    return glm::mix(colour, glm::dvec3(0.06), stroke(glm::length(handle + glm::dvec2(0, 0.09)), 0.02));
}

/// Distance from the strokes of a digit in a box one wide and two high.
double distanceToDigit(int digit, const glm::dvec2& p) {
    constexpr std::array<unsigned, 10> kBars{0x3f, 0x06, 0x5b, 0x4f, 0x66, 0x6d, 0x7d, 0x07, 0x7f, 0x6f};
    constexpr std::array<std::array<double, 4>, 7> kPlaces{
        {{0, 2, 1, 2}, {1, 1, 1, 2}, {1, 0, 1, 1}, {0, 0, 1, 0}, {0, 0, 0, 1}, {0, 1, 0, 2}, {0, 1, 1, 1}}};
    double nearest = 1e9;
    for (std::size_t bar = 0; bar < kPlaces.size(); ++bar)
        if ((kBars[static_cast<std::size_t>(digit)] >> bar & 1u) != 0)
            nearest = std::min(
                nearest, distanceToSegment(p, {kPlaces[bar][0], kPlaces[bar][1]}, {kPlaces[bar][2], kPlaces[bar][3]}));
    return nearest;
}

glm::dvec3 number(const Material& m, const glm::dvec3& p) {
    const double size = m.scale * 0.15;
    double nearest = 1e9;
    for (int place = 0; place < 3; ++place) {
        const int digit = static_cast<int>(m.seed / (place == 0 ? 100u : place == 1 ? 10u : 1u) % 10u);
        const glm::dvec2 corner(m.scale * (0.14 + 0.285 * place), m.scale * 0.14);
        nearest = std::min(nearest, distanceToDigit(digit, (glm::dvec2(p.x, p.y) - corner) / size) * size);
    }
    return glm::mix(m.accent, m.base, softStep(size * 0.17, 0.002, nearest));
}

glm::dvec3 leaf(const Material& m, const glm::dvec3& p) {
    const double ribs = std::sin((p.x - 1.2 * std::abs(p.y)) * 240.0);
    const double shade = layeredNoise(p * 20.0 + m.seed * 0.1, 2, m.seed);
    return glm::mix(m.base, m.accent, std::clamp(0.65 * shade + 0.12 * ribs + 0.5 * stroke(p.y, 0.006), 0.0, 1.0));
}

/// See synthetic_car.cpp for the car's shape: x forward, y left, z up from the road, metres.
glm::dvec3 carBody(const Material& m, const glm::dvec3& p) {
    const double side = std::abs(p.y);
    const double flake = smoothNoise(p * 2.5, m.seed);
    glm::dvec3 colour = m.base * (0.94 + 0.12 * flake);
    const glm::dvec3 trim(0.018, 0.018, 0.02), glass(0.012, 0.016, 0.020);

    // Glass: between the belt and the roof, cut by pillars.
    const double frontPillar = 1.02 - (p.z - 0.93) * 1.62, rearPillar = -1.86 + (p.z - 0.93) * 1.35;
    const double aboveBelt = band(p.z, 0.965, 1.335, 0.006);
    const double cabinSide = 0.80 - (p.z - 0.95) * 0.40;
    if (side > cabinSide - 0.045) {
        const double open = band(p.x, rearPillar + 0.34, frontPillar - 0.18, 0.006);
        const double pillar = stroke(p.x + 0.42, 0.085, 0.006);
        colour = glm::mix(colour, trim, aboveBelt * band(p.x, rearPillar + 0.30, frontPillar - 0.14, 0.006));
        colour = glm::mix(colour, glass + 0.02 * softStep(1.1, 0.2, p.z),
                          band(p.z, 0.985, 1.315, 0.006) * open * (1.0 - pillar));
    } else if (p.z > 0.93 && p.z < 1.40) {
        const double inner = 1.0 - softStep(cabinSide - 0.085, 0.006, side);
        colour = glm::mix(colour, glass + 0.025 * softStep(1.2, 0.2, p.z),
                          inner * band(p.z, 0.985, 1.365, 0.008) * (p.x > 0.2 || p.x < -1.0 ? 1.0 : 0.0));
    }

    // Doors, handles and sills.
    if (side > 0.74 && p.z < 0.97) {
        const double tall = band(p.z, 0.33, 0.97);
        double seam =
            std::max({stroke(p.x - 0.86, 0.014), stroke(p.x + 0.38, 0.014), stroke(p.x + 1.28, 0.014)}) * tall;
        seam = std::max(seam, stroke(p.z - 0.33, 0.014) * band(p.x, -1.28, 0.86));
        colour *= 1.0 - 0.8 * seam;
        const double handle = std::max(band(p.x, -0.28, -0.10), band(p.x, -1.18, -1.00)) * band(p.z, 0.80, 0.835);
        colour = glm::mix(colour, trim, handle);
        colour *= 1.0 - 0.35 * stroke(p.z - 0.64, 0.03, 0.015) * band(p.x, -1.9, 1.9, 0.05);
        for (const double axle : {1.36, -1.36}) {
            const double fromAxle = glm::length(glm::dvec2(p.x - axle, p.z - 0.32));
            colour = glm::mix(trim * 0.5, colour, softStep(0.375, 0.005, fromAxle));
        }
    }
    colour = glm::mix(colour, trim, 1.0 - softStep(0.30, 0.006, p.z));

    // Front: lamps, grille, plate. Rear: lamps, plate.
    if (p.x > 1.85 || p.x < -1.9) {
        const bool isFront = p.x > 0;
        const double lamp = band(side, 0.46, 0.80, 0.006) * band(p.z, 0.575, 0.70, 0.006);
        const double ribs = 0.75 + 0.25 * std::sin(p.y * 130.0);
        colour = glm::mix(colour, isFront ? glm::dvec3(0.62, 0.64, 0.66) * ribs : glm::dvec3(0.42, 0.012, 0.010) * ribs,
                          lamp);
        if (isFront) {
            const double grille = (1.0 - softStep(0.42, 0.006, side)) * band(p.z, 0.50, 0.66, 0.006);
            colour = glm::mix(colour, trim + 0.10 * softStep(0.2, 0.3, std::sin(p.z * 150.0)), grille);
            colour = glm::mix(colour, trim, (1.0 - softStep(0.62, 0.006, side)) * band(p.z, 0.33, 0.40, 0.006));
        }
        const double plate = (1.0 - softStep(0.26, 0.004, side)) * band(p.z, 0.41, 0.52);
        colour = glm::mix(colour, glm::dvec3(0.75, 0.75, 0.70), plate);
        const double ink =
            softStep(0.55, 0.05, unitOf(mixBits(static_cast<std::uint64_t>(std::floor((p.y + 3.0) / 0.032)), m.seed)));
        colour = glm::mix(colour, glm::dvec3(0.03),
                          plate * ink * band(p.z, 0.435, 0.495) * (1.0 - softStep(0.23, 0.004, side)));
    } else if (p.z > 0.7 && side < 0.72) {
        colour *= 1.0 - 0.7 * (stroke(side - 0.70, 0.014) * (p.x > 1.02 || p.x < -1.8 ? 1.0 : 0.0));
    }
    const double dust = layeredNoise(p * 4.0, 4, m.seed + 3) * (1.0 - softStep(0.45, 0.25, p.z));
    return glm::mix(colour, glm::dvec3(0.20, 0.18, 0.15), 0.45 * dust);
}

glm::dvec3 wheel(const Material& m, const glm::dvec3& p) {
    const double radius = glm::length(glm::dvec2(p.x, p.y)) / m.scale, angle = std::atan2(p.y, p.x);
    const glm::dvec3 rubber = glm::dvec3(0.018) * (0.8 + 0.5 * layeredNoise(p * 14.0, 2, m.seed));
    if (radius > 0.72) return glm::mix(rubber, glm::dvec3(0.05), stroke(radius - 0.86, 0.02, 0.01));
    const double spokes = softStep(-0.1, 0.25, std::cos(angle * 5.0 + m.seed));
    const double metal = std::max({softStep(0.62, 0.012, radius), 1.0 - softStep(0.20, 0.012, radius), spokes});
    const double bolts =
        stroke(glm::length(glm::dvec2(std::fmod(std::abs(angle), 1.2566) - 0.6283, (radius - 0.13) * 5.0)), 0.4, 0.1);
    return glm::mix(glm::dvec3(0.02), m.base, metal) * (1.0 - 0.7 * bolts);
}

glm::dvec3 dial(const Material& m, const glm::dvec3& p) {
    const glm::dvec2 at = glm::dvec2(p.x, p.y) / m.scale;
    const double radius = glm::length(at), hours = std::atan2(at.x, at.y) * 6.0 / 3.141592653589793;
    const double tick =
        stroke((hours - std::round(hours)) * radius * 0.5236, 0.035, 0.01) * band(radius, 0.74, 0.92, 0.01);
    const auto hand = [&](double hour, double length, double width) {
        const double angle = hour * 0.5235987755982988;
        return 1.0 - softStep(width, 0.012,
                              distanceToSegment(at, {0, 0}, glm::dvec2(std::sin(angle), std::cos(angle)) * length));
    };
    const double ink = std::max({tick, hand(10.15, 0.48, 0.03), hand(1.9, 0.70, 0.02)});
    return glm::mix(m.base, glm::dvec3(0.02), ink);
}

} // namespace

glm::dvec3 objectReflectanceAt(const Material& m, const glm::dvec3& p) {
    switch (m.pattern) {
    case Pattern::spine: {
        const double gold =
            std::max({stroke(p.y - 0.035, 0.008), stroke(p.y - 0.05, 0.005), stroke(p.y - m.scale + 0.03, 0.006)});
        const double title = (m.seed % 3 == 0 ? 0.0 : 0.55) * band(p.y, 0.09, 0.07 + 0.45 * m.scale) *
                             softStep(0.5, 0.12, smoothNoise({p.x * 130.0, p.y * 70.0, 1}, m.seed));
        const double wear = layeredNoise({p.x * 25.0, p.y * 25.0, 2}, 2, m.seed);
        return glm::mix(m.base * (0.75 + 0.4 * wear), m.accent, std::max(0.8 * gold, title));
    }
    case Pattern::pane:
        return pane(m, p);
    case Pattern::door:
        return door(m, p);
    case Pattern::number:
        return number(m, p);
    case Pattern::leaf:
        return leaf(m, p);
    case Pattern::carBody:
        return carBody(m, p);
    case Pattern::wheel:
        return wheel(m, p);
    case Pattern::dial:
        return dial(m, p);
    default:
        return m.base;
    }
}

} // namespace scene
