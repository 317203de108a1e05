// The test of tile boxes against planes, compiled for every vector width and chosen when the program starts.
#include "render/visibility.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/visibility_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <array>
#include <bit>

// What all targets share is declared once.
#ifndef REVISIT_VISIBILITY_SET_BITS
#define REVISIT_VISIBILITY_SET_BITS
namespace render {

constexpr std::size_t kBitsTogether = 8;

/// Of each byte the numbers of the bits that are set, in order. Highway's own Compress copies a table of a kilobyte to
/// the stack at every call where vectors have 256 bits (1.0.3 as g++ 12 compiles it): four times the time of the test.
constexpr auto kSetBits = [] {
    std::array<std::array<std::uint8_t, kBitsTogether>, 256> numbers{};
    for (std::size_t byte = 0; byte < numbers.size(); ++byte)
        for (std::size_t bit = 0, count = 0; bit < kBitsTogether; ++bit)
            if ((byte >> bit & 1) != 0) numbers[byte][count++] = static_cast<std::uint8_t>(bit);
    return numbers;
}();

} // namespace render
#endif

HWY_BEFORE_NAMESPACE();
namespace render {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

std::size_t findVisibleTiles(const TileBounds& bounds, std::size_t first, std::size_t count, const ImagePlanes& planes,
                             std::uint32_t* visible) {
    const hn::ScalableTag<float> floats;
    const hn::CappedTag<std::uint32_t, kBitsTogether> numbers;
    const hn::Rebind<std::uint8_t, decltype(numbers)> bytes;
    const std::size_t lanes = hn::Lanes(floats);

    // For each plane the faces of the box that are farthest inside: the same for all tiles.
    struct Plane {
        const float *x, *y, *d;
        glm::vec4 inside;
    };
    Plane faced[5];
    for (std::size_t i = 0; i < 5; ++i) {
        const glm::vec4& p = planes.inside[i];
        faced[i] = {p.x > 0 ? bounds.xMax.data() : bounds.xMin.data(),
                    p.y > 0 ? bounds.yMax.data() : bounds.yMin.data(),
                    p.w > 0 ? bounds.dMax.data() : bounds.dMin.data(), p};
    }

    std::size_t found = 0, i = 0;
    const auto isInside = [&](std::size_t tile, auto tag, const Plane& plane) {
        const auto x = hn::LoadU(tag, plane.x + tile), y = hn::LoadU(tag, plane.y + tile),
                   d = hn::LoadU(tag, plane.d + tile);
        const auto sum =
            hn::MulAdd(x, hn::Set(tag, plane.inside.x),
                       hn::MulAdd(y, hn::Set(tag, plane.inside.y),
                                  hn::MulAdd(d, hn::Set(tag, plane.inside.w), hn::Set(tag, plane.inside.z))));
        return hn::Ge(sum, hn::Zero(tag));
    };
    const auto isVisible = [&](std::size_t tile, auto tag) {
        auto inside = isInside(tile, tag, faced[0]);
        for (std::size_t plane = 1; plane < 5; ++plane)
            inside = hn::And(inside, isInside(tile, tag, faced[plane]));
        return inside;
    };
    // Whole vectors are stored, so only where that many places are left.
    for (; i + lanes <= count; i += lanes) {
        std::uint8_t inside[HWY_MAX_BYTES / sizeof(float)];
        hn::StoreMaskBits(floats, isVisible(first + i, floats), inside);
        for (std::size_t part = 0; part < lanes; part += kBitsTogether) {
            const std::uint8_t set = inside[part / kBitsTogether];
            const auto number = hn::Add(hn::Set(numbers, static_cast<std::uint32_t>(first + i + part)),
                                        hn::PromoteTo(numbers, hn::LoadU(bytes, kSetBits[set].data())));
            hn::StoreU(number, numbers, visible + found);
            found += static_cast<std::size_t>(std::popcount(set));
        }
    }
    const hn::CappedTag<float, 1> one;
    for (; i < count; ++i) {
        visible[found] = static_cast<std::uint32_t>(first + i);
        found += hn::AllTrue(one, isVisible(first + i, one)) ? 1 : 0;
    }
    return found;
}

} // namespace HWY_NAMESPACE
} // namespace render
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace render {

HWY_EXPORT(findVisibleTiles);

std::size_t findVisible(const TileBounds& bounds, std::size_t first, std::size_t count, const ImagePlanes& planes,
                        std::uint32_t* visible) {
    return HWY_DYNAMIC_DISPATCH(findVisibleTiles)(bounds, first, count, planes, visible);
}

} // namespace render
#endif
