#include "tests/bench/bare_warp.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tests/bench/bare_warp.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace scene {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

void warpBareOf(std::span<const BareSample> samples, const glm::mat4& imageFromPoint, const BareTarget& target) {
    const hn::ScalableTag<float> floats;
    const hn::RebindToSigned<decltype(floats)> ints;
    const std::size_t lanes = hn::Lanes(floats);
    HWY_ALIGN std::int32_t index[hn::MaxLanes(floats)];
    HWY_ALIGN std::uint32_t depth[hn::MaxLanes(floats)], colour[hn::MaxLanes(floats)];

    const auto set = [&](float value) { return hn::Set(floats, value); };
    const auto zero = hn::Zero(floats);
    const auto width = set(static_cast<float>(target.width)), height = set(static_cast<float>(target.height));
    const auto rowStride = hn::Set(ints, static_cast<std::int32_t>(target.width));
    const auto outside = hn::Set(ints, static_cast<std::int32_t>(target.width * target.height));
    const hn::RebindToUnsigned<decltype(floats)> words;
    for (std::size_t i = 0; i < samples.size(); i += lanes) {
        auto x = zero, y = zero, z = zero, bits = zero;
        hn::LoadInterleaved4(floats, &samples[i].x, x, y, z, bits);
        const auto row = [&](int r) HWY_ATTR {
            const auto term = [&](int c) HWY_ATTR { return set(imageFromPoint[c][r]); };
            return hn::MulAdd(term(0), x, hn::MulAdd(term(1), y, hn::MulAdd(term(2), z, term(3))));
        };
        const auto w = row(3), perW = hn::Div(set(1.f), w);
        const auto u = hn::Mul(row(0), perW), v = hn::Mul(row(1), perW);
        const auto isInside =
            hn::And(hn::And(hn::And(hn::Ge(u, zero), hn::Lt(u, width)), hn::And(hn::Ge(v, zero), hn::Lt(v, height))),
                    hn::Gt(w, zero));
        const auto pixel = hn::Add(hn::Mul(hn::ConvertTo(ints, v), rowStride), hn::ConvertTo(ints, u));
        hn::Store(hn::IfThenElse(hn::RebindMask(ints, isInside), pixel, outside), ints, index);
        hn::Store(hn::BitCast(words, hn::Max(hn::Mul(row(2), perW), zero)), words, depth);
        hn::Store(hn::BitCast(words, bits), words, colour);
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            const std::uint64_t key = static_cast<std::uint64_t>(depth[lane]) << 32 | colour[lane];
            std::uint64_t& place = target.keys[index[lane]];
            const std::uint64_t old = place;
            place = key < old ? key : old;
        }
    }
}

} // namespace HWY_NAMESPACE
} // namespace scene
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scene {

HWY_EXPORT(warpBareOf);

void warpBare(std::span<const BareSample> samples, const glm::mat4& imageFromPoint, const BareTarget& target) {
    HWY_DYNAMIC_DISPATCH(warpBareOf)(samples, imageFromPoint, target);
}

} // namespace scene
#endif
