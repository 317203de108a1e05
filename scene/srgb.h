#pragma once
// Colours as pictures write them, and as light adds up (IEC 61966-2-1).

#include "scene/image.h"

#include <cstdint>

#include <glm/vec3.hpp>

namespace scene {

/// The sRGB curve, both ways on [0, 1].
double linearFromSrgb(double value);
double srgbFromLinear(double value);

/// The same of a byte, from a table.
float linearFromSrgb(std::uint8_t value);

/// Linear colour to picture bytes; what is beyond 0 to 1 is cut off.
Rgb8 encoded(const glm::dvec3& linear);
inline Rgb8 encoded(const glm::vec3& linear) {
    return encoded(glm::dvec3(linear));
}

} // namespace scene
