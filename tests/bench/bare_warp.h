#pragma once
// The least that a warp to one z-buffer can be: records of four floats through one matrix, a 64-bit key, a minimum.
// What warpPoints is measured against.

#include <cstddef>
#include <cstdint>
#include <span>

#include <glm/mat4x4.hpp>

namespace scene {

/// A sample as a point: nothing to decode.
struct alignas(16) BareSample {
    float x, y, z;
    std::uint32_t colour;
};

/// One thread's z-buffer: width x height keys (depth << 32 | colour, the smallest wins), then one for what is outside.
struct BareTarget {
    std::uint32_t width, height;
    std::uint64_t* keys;
};

/// Draws the samples at (u, v, depth) = imageFromPoint (x, y, z, 1) / w. Their number is a multiple of kBareStep.
void warpBare(std::span<const BareSample> samples, const glm::mat4& imageFromPoint, const BareTarget& target);
inline constexpr std::size_t kBareStep = 64;

} // namespace scene
