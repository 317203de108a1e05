#include "scene/synthetic_texture.h"

#include "scene/srgb.h"
#include "scene/synthetic_random.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

namespace scene {

namespace {

double cellHash(std::int64_t x, std::int64_t y, std::int64_t z, std::uint32_t seed) {
    const auto key = static_cast<std::uint64_t>(x) * 0x9e3779b97f4a7c15ULL ^
                     static_cast<std::uint64_t>(y) * 0xc2b2ae3d27d4eb4fULL ^
                     static_cast<std::uint64_t>(z) * 0x165667b19e3779f9ULL;
    return unitOf(mixBits(key + seed * 0x27d4eb2f165667c5ULL));
}

double fade(double t) {
    return t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
}

/// Without std::floor, which plain x86-64 has to call for.
std::int64_t floorOf(double value) {
    const auto cut = static_cast<std::int64_t>(value);
    return cut - (static_cast<double>(cut) > value ? 1 : 0);
}

/// 1 on lines of the given width at whole multiples of the period, 0 between.
double lineMask(double value, double period, double width) {
    const double offset = std::abs(value - period * std::round(value / period));
    return 1.0 - softStep(width / 2, width / 3, offset);
}

glm::dvec3 planks(const Material& m, const glm::dvec3& p) {
    const std::int64_t board = floorOf(p.y / m.scale);
    const double shift = cellHash(board, 7, 0, m.seed) * 1.4;
    const std::int64_t piece = floorOf((p.x + shift) / 1.4);
    const double tint = cellHash(board, piece, 1, m.seed);
    const double wander = layeredNoise({p.x * 1.6, p.y * 9.0, tint * 90.0}, 2, m.seed);
    const double fibre = smoothNoise({p.x * 5.0, p.y * 75.0 + wander * 8.0, tint * 50.0}, m.seed + 1);
    const double mixed = std::clamp(0.25 + 0.5 * wander + 0.35 * (fibre - 0.5) + 0.5 * (tint - 0.5), 0.0, 1.0);
    const double seam = std::max(lineMask(p.y, m.scale, 0.005), lineMask(p.x + shift, 1.4, 0.005));
    return glm::mix(m.base, m.accent, mixed) * (1.0 - 0.55 * seam);
}

glm::dvec3 grain(const Material& m, const glm::dvec3& p) {
    const double wander = layeredNoise({p.x * 1.3 + m.seed, p.y * 7.0, p.z * 7.0}, 2, m.seed);
    const double fibre = smoothNoise({p.x * 4.0, p.y * 60.0 + wander * 10.0, p.z * 60.0}, m.seed + 1);
    return glm::mix(m.base, m.accent, std::clamp(wander * 0.8 + 0.35 * (fibre - 0.4), 0.0, 1.0));
}

glm::dvec3 tiles(const Material& m, const glm::dvec3& p) {
    const double tint = cellHash(floorOf(p.x / m.scale), floorOf(p.y / m.scale), 0, m.seed);
    const double cloud = layeredNoise({p.x * 6.0, p.y * 6.0, tint * 40.0}, 3, m.seed);
    const double joint = std::max(lineMask(p.x, m.scale, 0.008), lineMask(p.y, m.scale, 0.008));
    return glm::mix(m.base * (0.82 + 0.16 * tint + 0.16 * cloud), m.accent, joint);
}

/// Courses of blocks, each row shifted by half a block.
glm::dvec3 blocks(const Material& m, const glm::dvec3& p, double height, double joint, double variety) {
    const std::int64_t course = floorOf(p.y / height);
    const double x = p.x + (course & 1 ? m.scale / 2 : 0.0);
    const double tint = cellHash(floorOf(x / m.scale), course, 2, m.seed);
    const double rough = layeredNoise({p.x * 22.0, p.y * 22.0, tint * 9.0}, 2, m.seed);
    const double cloud = layeredNoise({p.x * 0.6, p.y * 0.6, 3.0}, 3, m.seed + 9);
    const double mask = std::max(lineMask(x, m.scale, joint), lineMask(p.y, height, joint));
    const double light = (1.0 - variety / 2 + variety * tint) * (0.86 + 0.28 * rough) * (0.8 + 0.4 * cloud);
    return glm::mix(m.base * light, m.accent * (0.8 + 0.3 * rough), mask);
}

glm::dvec3 rug(const Material& m, const glm::dvec3& p) {
    // Diamonds in the field, three borders: symmetric about both axes, as woven rugs are.
    const double x = std::abs(p.x), y = std::abs(p.y);
    const double halfLength = m.scale, halfWidth = m.scale * 0.66;
    const double fromEdge = std::min(halfLength - x, halfWidth - y);
    const double diamond =
        std::abs(std::fmod(x + 0.6 * y, 0.3) - 0.15) + std::abs(std::fmod(y + 10.2 - 0.6 * x, 0.3) - 0.15);
    glm::dvec3 colour = glm::mix(m.base, m.accent, 1.0 - softStep(0.10, 0.008, diamond));
    colour = glm::mix(colour, glm::dvec3(0.04, 0.05, 0.10), softStep(0.22, 0.008, diamond));
    if (fromEdge < 0.22) {
        const double along = halfLength - x < halfWidth - y ? y : x;
        const double zigzag = std::abs(std::fmod(along, 0.12) - 0.06) + 0.08;
        colour = glm::mix(m.accent, m.base * 0.6, softStep(zigzag, 0.006, fromEdge));
        colour = glm::mix(colour, glm::dvec3(0.03, 0.04, 0.08), softStep(0.19, 0.006, fromEdge));
        colour = glm::mix(glm::dvec3(0.03, 0.04, 0.08), colour, softStep(0.04, 0.006, fromEdge));
    }
    const double tuft = layeredNoise({p.x * 45.0, p.y * 45.0, 1.0}, 2, m.seed);
    return colour * (0.78 + 0.4 * tuft);
}

glm::dvec3 picture(const Material& m, const glm::dvec3& p) {
    // Ridge behind ridge under a low sun, painted with a visible brush.
    const double u = p.x / m.scale, v = p.y / m.scale;
    const double brush = layeredNoise({u * 60.0, v * 22.0, 5.0}, 2, m.seed);
    const glm::dvec2 toSun(u - 0.68, v - 0.50);
    glm::dvec3 colour = glm::mix(reflectance(0xf4c98a), reflectance(0x4f7fb0), std::clamp(v * 1.7 - 0.35, 0.0, 1.0));
    const double cloud = layeredNoise({u * 4.0, v * 12.0, 8.0}, 3, m.seed + 4);
    colour = glm::mix(colour, reflectance(0xfbe9d0), 0.8 * softStep(0.56, 0.06, cloud));
    colour = glm::mix(reflectance(0xfff3c0), colour, softStep(0.055, 0.004, glm::length(toSun)));
    const glm::dvec3 ridgeColour[4] = {reflectance(0x7d8fb3), reflectance(0x4d6a8a), reflectance(0x35574f),
                                       reflectance(0x1f3a26)};
    for (int ridge = 0; ridge < 4; ++ridge) {
        const double height =
            0.46 - 0.1 * ridge + 0.16 * (layeredNoise({u * (3.0 + 2.0 * ridge), 4.0 * ridge, 2.0}, 4, m.seed) - 0.5);
        colour = glm::mix(ridgeColour[ridge], colour, softStep(height, 0.003, v));
    }
    const double gold = softStep(0.6, 0.05, smoothNoise({u * 40.0, v * 40.0, 3.0}, m.seed + 7));
    if (v < 0.16) colour = glm::mix(colour, reflectance(0xc9a23a), 0.6 * gold * (1.0 - v / 0.16));
    return colour * (0.85 + 0.3 * brush);
}

glm::dvec3 chart(const Material& m, const glm::dvec3& p) {
    // Fine detail of known shape: a star, rings, bars from coarse to fine, and squares of many colours.
    const double u = p.x / m.scale, v = p.y / m.scale;
    const glm::dvec3 paper(0.82, 0.80, 0.76), ink(0.03, 0.03, 0.035);
    if (u < 0.04 || u > 0.96 || v < 0.04 || v > 1.30) return paper;
    double dark = 0.0;
    if (v > 0.74) {
        const glm::dvec2 c(u - 0.5, v - 1.02);
        const double radius = glm::length(c);
        const double spoke = std::sin(std::atan2(c.y, c.x) * 16.0);
        if (radius > 0.05 && radius < 0.25) dark = softStep(0.0, 0.3, spoke);
        if (radius > 0.26) dark = 1.0 - softStep(0.006, 0.002, std::abs(radius - 0.265));
    } else if (v > 0.42) {
        const double wave = std::sin(u * u * 180.0);
        dark = softStep(0.0, 0.35, wave);
    } else {
        const std::int64_t i = floorOf((u - 0.04) / 0.115), j = floorOf((v - 0.04) / 0.095);
        const glm::dvec3 colour(cellHash(i, j, 1, m.seed), cellHash(i, j, 2, m.seed), cellHash(i, j, 3, m.seed));
        const double edge = std::max(lineMask(u - 0.04, 0.115, 0.01), lineMask(v - 0.04, 0.095, 0.01));
        return glm::mix(colour * 0.8 + 0.03, paper, edge);
    }
    return glm::mix(paper, ink, dark);
}

glm::dvec3 asphalt(const Material& m, const glm::dvec3& p) {
    const double grit = smoothNoise(p * 38.0, m.seed), stain = layeredNoise(p * 0.5, 4, m.seed + 1);
    const double crackField = layeredNoise(p * 0.9, 4, m.seed + 2);
    const double crack = (1.0 - softStep(0.0025, 0.002, std::abs(crackField - 0.5))) * softStep(0.52, 0.05, stain);
    return glm::mix(m.base, m.accent, std::clamp(0.35 * grit + 0.2 + 0.9 * (stain - 0.35), 0.0, 1.0)) *
           (1.0 - 0.5 * crack);
}

/// Markings of the street corner: see synthetic_corner.cpp for where the streets run (along x and y, 7 m
/// wide).
glm::dvec3 road(const Material& m, const glm::dvec3& p) {
    const double x = std::abs(p.x), y = std::abs(p.y);
    double paint = 0.0;
    const auto band = [](double value, double low, double high) {
        return softStep(low, 0.012, value) * (1.0 - softStep(high, 0.012, value));
    };
    const auto crossing = [&](double along, double across) {
        return band(along, 4.2, 6.8) *
               (across < 3.1 ? 1.0 - softStep(0.25, 0.012, std::abs(std::fmod(across + 0.5, 1.0) - 0.5)) : 0.0);
    };
    paint = std::max({crossing(x, y), crossing(y, x),
                      band(x, 7.4, 7.8) * (y < 3.1 ? 1.0 : 0.0) * (p.x * p.y < 0 ? 1.0 : 0.0),
                      band(y, 7.4, 7.8) * (x < 3.1 ? 1.0 : 0.0) * (p.x * p.y > 0 ? 1.0 : 0.0)});
    const auto dashes = [&](double along, double across) {
        return along > 8.4 ? (1.0 - softStep(0.06, 0.012, across)) * band(std::fmod(along, 4.0), 0.5, 2.5) : 0.0;
    };
    paint = std::max({paint, dashes(x, y), dashes(y, x)});
    const double wear = layeredNoise(p * 3.0, 4, m.seed + 5);
    paint *= 0.45 + 0.5 * softStep(0.36, 0.1, wear);
    return glm::mix(asphalt(m, p), glm::dvec3(0.62, 0.61, 0.58), paint);
}

} // namespace

glm::dvec3 reflectance(std::uint32_t rgb) {
    const auto channel = [&](int shift) { return linearFromSrgb(static_cast<double>((rgb >> shift) & 255u) / 255.0); };
    return {channel(16), channel(8), channel(0)};
}

double softStep(double edge, double softness, double value) {
    const double t = std::clamp((value - edge + softness) / (2.0 * softness), 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

double smoothNoise(const glm::dvec3& p, std::uint32_t seed) {
    const std::int64_t x = floorOf(p.x), y = floorOf(p.y), z = floorOf(p.z);
    const double u = fade(p.x - static_cast<double>(x)), v = fade(p.y - static_cast<double>(y)),
                 w = fade(p.z - static_cast<double>(z));
    const auto edge = [&](std::int64_t dy, std::int64_t dz) {
        const double a = cellHash(x, y + dy, z + dz, seed), b = cellHash(x + 1, y + dy, z + dz, seed);
        return a + (b - a) * u;
    };
    const double near = edge(0, 0) + (edge(1, 0) - edge(0, 0)) * v;
    if (w == 0.0) return near;
    const double e0 = edge(0, 1), far = e0 + (edge(1, 1) - e0) * v;
    return near + (far - near) * w;
}

double layeredNoise(const glm::dvec3& p, int octaves, std::uint32_t seed) {
    double sum = 0.0, weight = 1.0, total = 0.0, frequency = 1.0;
    for (int octave = 0; octave < octaves; ++octave) {
        sum += weight * smoothNoise(p * frequency, seed + static_cast<std::uint32_t>(octave) * 101u);
        total += weight;
        weight /= 2, frequency *= 2.03;
    }
    return sum / total;
}

glm::dvec3 reflectanceAt(const Material& m, const glm::dvec3& p) {
    switch (m.pattern) {
    case Pattern::plain:
        return m.base;
    case Pattern::mottled:
        return glm::mix(m.base, m.accent, layeredNoise(p / m.scale, 4, m.seed));
    case Pattern::plaster:
        return m.base * (0.93 + 0.09 * layeredNoise(p * 1.1, 3, m.seed) + 0.05 * smoothNoise(p * 35.0, m.seed + 1));
    case Pattern::planks:
        return planks(m, p);
    case Pattern::grain:
        return grain(m, p);
    case Pattern::tiles:
        return tiles(m, p);
    case Pattern::slabs:
        return blocks(m, p, m.scale / 2, 0.012, 0.25);
    case Pattern::bricks:
        return blocks(m, p, m.scale * 0.34, 0.013, 0.6);
    case Pattern::checker: {
        const double x = std::sin(p.x / m.scale * 3.141592653589793), y = std::sin(p.y / m.scale * 3.141592653589793);
        const double cloud = layeredNoise(p * 5.0, 3, m.seed);
        return glm::mix(m.base, m.accent, softStep(0.0, 0.03, x * y)) * (0.85 + 0.3 * cloud);
    }
    case Pattern::rug:
        return rug(m, p);
    case Pattern::picture:
        return picture(m, p);
    case Pattern::chart:
        return chart(m, p);
    case Pattern::weave: {
        const double thread = 0.5 + 0.25 * (std::sin(p.x * 330.0) + std::sin(p.y * 330.0));
        const double cloud = layeredNoise(p * 8.0, 3, m.seed);
        return glm::mix(m.base, m.accent, std::clamp(0.4 * thread + 0.8 * (cloud - 0.2), 0.0, 1.0));
    }
    case Pattern::asphalt:
        return asphalt(m, p);
    case Pattern::road:
        return road(m, p);
    case Pattern::stripes:
        return glm::mix(m.base, m.accent, softStep(0.0, 0.06, std::sin(p.x / m.scale * 3.141592653589793)));
    default:
        return objectReflectanceAt(m, p);
    }
}

} // namespace scene
