#pragma once
// A tile on its way into an eye: the incremental transform of its vertices, and the keys of the z-buffer.
// Nyland et al. 1999, section 5.1: along a tile the columns of the warp are stepped, so that a sample costs one
// multiply-add by its disparity.

#include "scene/tile.h"
#include "scene/warp.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

namespace scene {

/// h = origin + x columnX + y columnY + q columnQ = (u w, v w, w), all rounded from double. Disparity is the order's:
/// over orderScale(level).
struct TileWarp {
    glm::vec3 origin, columnX, columnY, columnQ;
    float minDisparity, disparityStep;
    std::uint32_t levelAndClass;
    std::uint32_t placeBits;
};

inline PixelClass classOf(Tier tier) {
    return isMeasured(tier) ? PixelClass::seen : PixelClass::filled;
}

inline TileWarp tileWarpOf(const Tile& tile, const glm::dmat4& eyeImageFromSourceImage, int level) {
    const glm::dmat4& c = eyeImageFromSourceImage;
    const double perScale = 1.0 / static_cast<double>(orderScale(level));
    const double step = (static_cast<double>(tile.maxDisparity) - tile.minDisparity) / maxQuantisedOf(tile);
    const glm::dvec4 origin = c * glm::dvec4(tile.x0 + 0.5, tile.y0 + 0.5, 1.0, static_cast<double>(tile.minDisparity));
    return {glm::vec3(glm::dvec3(origin)),
            glm::vec3(glm::dvec3(c[0])),
            glm::vec3(glm::dvec3(c[1])),
            glm::vec3(glm::dvec3(c[3]) * step),
            static_cast<float>(tile.minDisparity * perScale),
            static_cast<float>(step * perScale),
            static_cast<std::uint32_t>(level) << 2 | static_cast<std::uint32_t>(classOf(tile.tier)),
            tile.placeBits};
}

/// A vertex in the eye's image.
struct Projected {
    float u = 0, v = 0, perW = 0, disparity = -1; ///< disparity < 0: behind the eye or too near
};

/// The formula of every warp, on the processor and on the GPU: the same operations in the same order.
inline Projected projectVertex(const TileWarp& warp, std::uint32_t place) {
    const std::uint32_t mask = (1u << warp.placeBits) - 1;
    const auto x = static_cast<float>(place & mask), y = static_cast<float>(place >> warp.placeBits & mask);
    const auto q = static_cast<float>(place >> 2 * warp.placeBits);
    const glm::vec3 h = warp.origin + x * warp.columnX + y * warp.columnY + q * warp.columnQ;
    if (!(h.z > 0)) return {};
    const float perW = 1.0f / h.z;
    const float disparity = (warp.minDisparity + q * warp.disparityStep) * perW;
    if (!(disparity <= 1.0f / kNearMetres)) return {};
    return {h.x * perW, h.y * perW, perW, disparity};
}

/// What a point covers besides the pixel it stands in keeps this share of its disparity: where squares of one surface
/// lie over one another, a pixel then shows the sample that stands in it and not one beside it that is nearer to the
/// eye. More than neighbouring samples of a slanted surface differ by, and less than an order level.
inline constexpr float kRimShare = 0.99f, kPerRimShare = 1.0f / 0.99f;

/// Bits of a key's high word that are not the order disparity's.
inline constexpr std::uint32_t kNotDisparity = 63u;

/// The order disparity there, rounded.
inline std::uint32_t orderBitsOf(float disparity) {
    return (std::bit_cast<std::uint32_t>(disparity) + (kNotDisparity + 1) / 2) & ~kNotDisparity;
}

/// The key of what stands in the middle of its pixel.
inline std::uint64_t keyOf(float disparity, std::uint32_t colour, std::uint32_t levelAndClass) {
    return std::uint64_t{orderBitsOf(disparity)} << 32 | (colour & 0xffffffu) << 8 | levelAndClass;
}

/// Of a pixel that a point covers beside its own. What is infinitely far has no rim.
inline std::uint64_t rimOf(float disparity, std::uint32_t colour, std::uint32_t levelAndClass) {
    const std::uint64_t key = keyOf(disparity * kRimShare, colour, levelAndClass);
    return key >> 32 != 0 ? key | std::uint64_t{1} << 32 : key;
}

/// Steps from a pixel's centre to where its sample stands, along an axis, and how many of them make a pixel: a point's
/// in its pixel and at its rim, a splat's.
inline constexpr int kMostPlaceSteps = 2;
inline constexpr float kPlaceStepsOfPoint = 4, kPlaceStepsOfRim = 2, kPlaceStepsOfSplat = 8.f / 3.f;

/// That key where the sample stands elsewhere: from it to the pixel's centre, pixels. What is infinitely far stands in
/// the middle.
inline std::uint64_t withPlace(std::uint64_t key, float offsetX, float offsetY, float stepsPerPixel) {
    const auto steps = [&](float offset) {
        constexpr auto most = static_cast<float>(kMostPlaceSteps);
        return static_cast<int>(std::clamp(std::floor(0.5f - offset * stepsPerPixel), -most, most));
    };
    const int x = steps(offsetX), y = steps(offsetY);
    const auto code = static_cast<std::uint64_t>((x < 0 ? x + 5 : x) * 5 + (y < 0 ? y + 5 : y));
    return key >> 32 != 0 ? key | code << 33 : key;
}

/// The eye's disparity in a key that is not 0: its order's with what pushed it back taken off.
inline float eyeDisparityOf(std::uint64_t key) {
    const auto high = static_cast<std::uint32_t>(key >> 32);
    const float disparity = std::bit_cast<float>(high & ~kNotDisparity) * orderScale(static_cast<int>(key >> 2 & 63u));
    return (high & 1u) != 0 ? disparity * kPerRimShare : disparity;
}

} // namespace scene
