#pragma once
// Which texels a place of a texture lies between; textures repeat beyond their edges.

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/vec2.hpp>

namespace scene {

/// Columns x0, x1 and rows y0, y1 (0 is the top), and how far the place is from the first of them to the second.
struct Texels {
    int x0 = 0, x1 = 0, y0 = 0, y1 = 0;
    float s = 0, t = 0;
};

/// place: texture coordinates, v = 0 at the bottom.
inline Texels texelsAt(const glm::vec2& place, int width, int height) {
    const auto wrap = [](float at, int size) {
        const float rest = std::fmod(at, static_cast<float>(size));
        // Places so far out that they overflow are as good as any; NaN fails every comparison.
        const float within = rest < 0 ? rest + static_cast<float>(size) : rest;
        return within >= 0 && within < static_cast<float>(size) ? static_cast<int>(within) : 0;
    };
    const float x = place.x * static_cast<float>(width) - 0.5f,
                y = (1.0f - place.y) * static_cast<float>(height) - 0.5f;
    const float left = std::floor(x), top = std::floor(y);
    return {wrap(left, width), wrap(left + 1, width), wrap(top, height), wrap(top + 1, height), x - left, y - top};
}

/// The bilinear mean of what texel(x, y) gives.
template <class Texel>
auto blend(const Texels& between, const Texel& texel) {
    return glm::mix(glm::mix(texel(between.x0, between.y0), texel(between.x1, between.y0), between.s),
                    glm::mix(texel(between.x0, between.y1), texel(between.x1, between.y1), between.s), between.t);
}

} // namespace scene
