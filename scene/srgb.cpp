#include "scene/srgb.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace scene {

namespace {

std::array<float, 256> makeTable() {
    std::array<float, 256> table{};
    for (std::size_t i = 0; i < table.size(); ++i)
        table[i] = static_cast<float>(linearFromSrgb(static_cast<double>(i) / 255));
    return table;
}

} // namespace

double linearFromSrgb(double value) {
    return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}

double srgbFromLinear(double value) {
    return value <= 0.0031308 ? value * 12.92 : 1.055 * std::pow(value, 1.0 / 2.4) - 0.055;
}

float linearFromSrgb(std::uint8_t value) {
    static const std::array<float, 256> table = makeTable();
    return table[value];
}

Rgb8 encoded(const glm::dvec3& linear) {
    const auto channel = [](double value) {
        return static_cast<std::uint8_t>(std::lround(255.0 * srgbFromLinear(std::clamp(value, 0.0, 1.0))));
    };
    return {channel(linear.x), channel(linear.y), channel(linear.z)};
}

} // namespace scene
