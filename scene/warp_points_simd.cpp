// Points of a tile, compiled for every vector width and chosen when the program starts. Vectors decode, project and
// make keys; the z-buffer is reached sample by sample, since neighbouring samples share pixels.
#include "scene/warp_points.h"

#include <algorithm>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "scene/warp_points_simd.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace scene {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::ScalableTag<float>;
using Ints = hn::RebindToSigned<Floats>;
using Words = hn::RebindToUnsigned<Floats>;
constexpr std::size_t kMaxLanes = hn::MaxLanes(Floats());

/// Samples on their way to the pixels: so many that the first pixel has come to the cache when the last is projected.
/// One that is not drawn has key 0, which changes nothing.
struct Batch {
    static constexpr std::size_t kCapacity = std::max<std::size_t>(kMaxLanes, 128);
    HWY_ALIGN std::uint32_t keys[2 * kCapacity]; ///< low and high word of each
    HWY_ALIGN std::int32_t x[kCapacity];         ///< footprint 1: the pixel's index
    HWY_ALIGN std::int32_t y[kCapacity];
    HWY_ALIGN float u[kCapacity]; ///< where it stands, and its order disparity; not for footprint 1
    HWY_ALIGN float v[kCapacity];
    HWY_ALIGN float disparity[kCapacity];
    std::size_t count = 0;

    std::uint64_t key(std::size_t i) const {
        std::uint64_t result;
        std::memcpy(&result, keys + 2 * i, sizeof(result));
        return result;
    }
};

/// One pixel a sample. The store is unconditional: whether a sample wins is hard to predict.
inline void scatter(Batch& batch, std::uint64_t* pixels) {
    for (std::size_t i = 0; i < batch.count; ++i) {
        std::uint64_t& pixel = pixels[batch.x[i]];
        const std::uint64_t old = pixel, key = batch.key(i);
        pixel = old < key ? key : old;
    }
    batch.count = 0;
}

/// Squares of side x side pixels.
inline void scatterSquares(Batch& batch, int side, const ImageView<std::uint64_t>& zBuffer) {
    for (std::size_t i = 0; i < batch.count; ++i) {
        const std::uint64_t key = batch.key(i);
        if (key == 0) continue;
        const int x0 = std::max(batch.x[i], 0), x1 = std::min(batch.x[i] + side, zBuffer.width);
        const int y0 = std::max(batch.y[i], 0), y1 = std::min(batch.y[i] + side, zBuffer.height);
        const auto low = static_cast<std::uint32_t>(key);
        const std::uint64_t rim = rimOf(batch.disparity[i], low >> 8, low & 255u);
        const float u = batch.u[i], v = batch.v[i];
        const int ownX = static_cast<int>(std::floor(u)), ownY = static_cast<int>(std::floor(v));
        for (int y = y0; y < y1; ++y)
            for (int x = x0; x < x1; ++x) {
                const bool isOwn = x == ownX && y == ownY;
                const float offsetX = static_cast<float>(x) + 0.5f - u, offsetY = static_cast<float>(y) + 0.5f - v;
                zBuffer(x, y) = std::max(zBuffer(x, y), withPlace(isOwn ? key : rim, offsetX, offsetY,
                                                                  isOwn ? kPlaceStepsOfPoint : kPlaceStepsOfRim));
            }
    }
    batch.count = 0;
}

RowRange drawPointsOf(const TileWarp& warp, std::span<const TileVertex> vertices, int side,
                      const ImageView<std::uint64_t>& zBuffer) {
    const Floats floats;
    const Ints ints;
    const Words words;
    const std::size_t lanes = hn::Lanes(floats);

    const auto set = [&](float value) { return hn::Set(floats, value); };
    const auto zero = hn::Zero(floats), one = set(1.f);
    const auto nearest = set(1.0f / kNearMetres);
    // A square whose first pixel stands before the image may still reach into it, from up to 63 pixels away.
    const bool isPixel = side == 1;
    const auto before = set(std::max(1.f - static_cast<float>(side), -63.f)),
               half = set(0.5f * static_cast<float>(side - 1));
    const auto width = set(static_cast<float>(zBuffer.width)), height = set(static_cast<float>(zBuffer.height));
    const auto rowStride = hn::Set(ints, static_cast<std::int32_t>(zBuffer.rowStride));
    // Lanes that are not drawn go to pixels of their own, so that none waits for another's store.
    const auto unused = hn::Min(hn::Iota(ints, 0), hn::Set(ints, zBuffer.width - 1));
    auto firstRow = hn::Set(ints, zBuffer.height), lastRow = hn::Set(ints, -1);
    const int placeBits = static_cast<int>(warp.placeBits);
    Batch batch;
    const auto flush = [&] {
        if (isPixel)
            scatter(batch, zBuffer.pixels);
        else
            scatterSquares(batch, side, zBuffer);
    };

    const auto drawVector = [&](const TileVertex* vertex, const auto& isThere) HWY_ATTR {
        auto place = hn::Zero(words), colour = hn::Zero(words);
        hn::LoadInterleaved2(words, &vertex->place, place, colour);
        const auto number = [&](const auto& bits) HWY_ATTR { return hn::ConvertTo(floats, hn::BitCast(ints, bits)); };
        const auto mask = hn::Set(words, (1u << warp.placeBits) - 1);
        const auto column = number(hn::And(place, mask));
        const auto line = number(hn::And(hn::ShiftRightSame(place, placeBits), mask));
        const auto q = number(hn::ShiftRightSame(place, 2 * placeBits));
        // As projectVertex: every product is rounded before it is added.
        const auto row = [&](int i) HWY_ATTR {
            return hn::Add(hn::Add(hn::Add(set(warp.origin[i]), hn::Mul(column, set(warp.columnX[i]))),
                                   hn::Mul(line, set(warp.columnY[i]))),
                           hn::Mul(q, set(warp.columnQ[i])));
        };
        const auto w = row(2), perW = hn::Div(one, w);
        const auto disparity = hn::Mul(hn::Add(set(warp.minDisparity), hn::Mul(q, set(warp.disparityStep))), perW);
        const auto u = hn::Mul(row(0), perW), v = hn::Mul(row(1), perW);
        auto left = hn::Sub(u, half), top = hn::Sub(v, half);
        if (!isPixel) left = hn::Floor(left), top = hn::Floor(top);

        const auto isInEye =
            hn::And(hn::And(hn::Gt(w, zero), isThere), hn::And(hn::Ge(disparity, zero), hn::Le(disparity, nearest)));
        const auto isInImage = hn::And(hn::And(hn::Ge(left, before), hn::Lt(left, width)),
                                       hn::And(hn::Ge(top, before), hn::Lt(top, height)));
        const auto isDrawn = hn::And(isInEye, isInImage);
        if (hn::AllFalse(floats, isDrawn)) return;

        const auto low = hn::Or(hn::ShiftLeft<8>(colour), hn::Set(words, warp.levelAndClass));
        const auto rounding = hn::Set(words, (kNotDisparity + 1) / 2);
        auto high = hn::AndNot(hn::Set(words, kNotDisparity), hn::Add(hn::BitCast(words, disparity), rounding));
        if (isPixel) {
            // As withPlace.
            const auto stepsOf = [&](const auto& position) HWY_ATTR {
                const auto offset = hn::Sub(hn::Add(hn::Floor(position), set(0.5f)), position);
                const auto steps = hn::Floor(hn::Sub(set(0.5f), hn::Mul(offset, set(kPlaceStepsOfPoint))));
                return hn::Add(steps, hn::IfThenElseZero(hn::Lt(steps, zero), set(5.f)));
            };
            const auto code = hn::ConvertTo(ints, hn::MulAdd(stepsOf(u), set(5.f), stepsOf(v)));
            const auto isNear = hn::RebindMask(floats, hn::Ne(high, hn::Zero(words)));
            high = hn::Or(high,
                          hn::BitCast(words, hn::IfThenElseZero(isNear, hn::BitCast(floats, hn::ShiftLeft<1>(code)))));
        }
        const auto isDrawnWord = hn::RebindMask(words, isDrawn);
        hn::StoreInterleaved2(hn::IfThenElseZero(isDrawnWord, low), hn::IfThenElseZero(isDrawnWord, high), words,
                              batch.keys + 2 * batch.count);
        const auto isDrawnInt = hn::RebindMask(ints, isDrawn);
        const auto pixelX = hn::ConvertTo(ints, hn::IfThenElseZero(isDrawn, left));
        const auto pixelY = hn::ConvertTo(ints, hn::IfThenElseZero(isDrawn, top));
        firstRow = hn::Min(firstRow, hn::IfThenElse(isDrawnInt, pixelY, firstRow));
        lastRow = hn::Max(lastRow, hn::IfThenElse(isDrawnInt, pixelY, lastRow));
        std::int32_t* const x = batch.x + batch.count;
        if (isPixel) {
            hn::Store(hn::IfThenElse(isDrawnInt, hn::Add(hn::Mul(pixelY, rowStride), pixelX), unused), ints, x);
            hwy::Prefetch(zBuffer.pixels + x[0]);
            hwy::Prefetch(zBuffer.pixels + x[lanes - 1]);
        } else {
            hn::Store(pixelX, ints, x);
            hn::Store(pixelY, ints, batch.y + batch.count);
            hn::Store(hn::IfThenElseZero(isDrawn, u), floats, batch.u + batch.count);
            hn::Store(hn::IfThenElseZero(isDrawn, v), floats, batch.v + batch.count);
            hn::Store(disparity, floats, batch.disparity + batch.count);
        }
        batch.count += lanes;
        if (batch.count + lanes > Batch::kCapacity) flush();
    };

    std::size_t i = 0;
    const auto all = hn::FirstN(floats, lanes);
    for (; i + lanes <= vertices.size(); i += lanes)
        drawVector(vertices.data() + i, all);
    if (i < vertices.size()) {
        TileVertex rest[kMaxLanes] = {};
        std::copy(vertices.begin() + static_cast<std::ptrdiff_t>(i), vertices.end(), rest);
        drawVector(rest, hn::FirstN(floats, vertices.size() - i));
    }
    flush();
    const int first = hn::GetLane(hn::MinOfLanes(ints, firstRow)), last = hn::GetLane(hn::MaxOfLanes(ints, lastRow));
    return {std::max(first, 0), std::min(last + side, zBuffer.height)};
}

void mergeKeysOf(const std::uint64_t* from, std::uint64_t* into, std::size_t count) {
    const hn::ScalableTag<std::uint64_t> keys;
    const std::size_t lanes = hn::Lanes(keys);
    std::size_t i = 0;
    for (; i + lanes <= count; i += lanes)
        hn::StoreU(hn::Max(hn::LoadU(keys, from + i), hn::LoadU(keys, into + i)), keys, into + i);
    for (; i < count; ++i)
        into[i] = std::max(into[i], from[i]);
}

} // namespace HWY_NAMESPACE
} // namespace scene
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scene {

HWY_EXPORT(drawPointsOf);
HWY_EXPORT(mergeKeysOf);

RowRange drawPoints(const TileWarp& warp, std::span<const TileVertex> vertices, int footprint,
                    ImageView<std::uint64_t> zBuffer) {
    return HWY_DYNAMIC_DISPATCH(drawPointsOf)(warp, vertices, footprint, zBuffer);
}

void mergeKeys(std::span<const std::uint64_t> from, std::span<std::uint64_t> into) {
    HWY_DYNAMIC_DISPATCH(mergeKeysOf)(from.data(), into.data(), into.size());
}

} // namespace scene
#endif
