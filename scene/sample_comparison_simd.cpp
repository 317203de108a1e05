// Comparison of samples, compiled for every vector width and chosen when the program starts.
#include "scene/sample_comparison.h"

#include <algorithm>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "scene/sample_comparison_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// What all targets share is declared once.
#ifndef REVISIT_SAMPLE_COMPARISON_ARRAYS
#define REVISIT_SAMPLE_COMPARISON_ARRAYS
namespace scene {

/// In and out, all of padded length.
struct ComparisonArrays {
    const float *x, *y, *disparity;
    float *u, *v, *seenDisparity, *surface;
    std::int32_t* codes;
};

constexpr std::size_t kMostComparedLanes = 16; ///< vectors are no wider

} // namespace scene
#endif

HWY_BEFORE_NAMESPACE();
namespace scene {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, kMostComparedLanes>;
using Ints = hn::RebindToSigned<Floats>;
using FloatVector = hn::Vec<Floats>;

HWY_INLINE FloatVector set(float value) {
    return hn::Set(Floats(), value);
}
HWY_INLINE hn::Vec<Ints> code(SampleComparison::Code value) {
    return hn::Set(Ints(), static_cast<std::int32_t>(value));
}

/// Within [0, width) x [0, height).
HWY_INLINE hn::Mask<Floats> areIn(FloatVector x, FloatVector y, int width, int height) {
    const FloatVector zero = hn::Zero(Floats());
    return hn::And(hn::And(hn::Ge(x, zero), hn::Ge(y, zero)),
                   hn::And(hn::Lt(x, set(static_cast<float>(width))), hn::Lt(y, set(static_cast<float>(height)))));
}

/// What is read of the target for some samples at a time: vectors find the places, single reads fetch what stands there
/// (they are faster than vectors' own gathering), vectors compare.
struct Corners {
    static constexpr std::size_t kCapacity = 256;
    HWY_ALIGN std::int32_t places[kCapacity]; ///< index of the upper left of the four; 0 where there are no four
    HWY_ALIGN float upper[2 * kCapacity];     ///< left, right
    HWY_ALIGN float lower[2 * kCapacity];
    HWY_ALIGN std::int32_t flags[kCapacity]; ///< of two of them and of two, or
};

/// Where samples are seen, and the places of their corners; codes: whether they are seen.
void findCorners(const Camera& camera, const Reprojection& into, std::size_t first, std::size_t end,
                 const ComparisonArrays& a, Corners& corners) {
    const Floats floats;
    const Ints ints;
    for (std::size_t i = first; i < end; i += hn::Lanes(floats)) {
        const auto x = hn::LoadU(floats, a.x + i), y = hn::LoadU(floats, a.y + i);
        const auto d = hn::LoadU(floats, a.disparity + i);
        const auto along = [&](float origin, float byX, float byY, float byD) HWY_ATTR {
            const auto plane = hn::Add(hn::Add(set(origin), hn::Mul(x, set(byX))), hn::Mul(y, set(byY)));
            return hn::Add(plane, hn::Mul(d, set(byD)));
        };
        const auto w = along(into.origin.z, into.columnX.z, into.columnY.z, into.columnD.z);
        const auto perW = hn::Div(set(1.0f), w);
        const auto u = hn::Mul(along(into.origin.x, into.columnX.x, into.columnY.x, into.columnD.x), perW);
        const auto v = hn::Mul(along(into.origin.y, into.columnX.y, into.columnY.y, into.columnD.y), perW);
        hn::StoreU(u, floats, a.u + i);
        hn::StoreU(v, floats, a.v + i);
        hn::StoreU(hn::Mul(d, perW), floats, a.seenDisparity + i);
        const auto isSeen = hn::And(hn::Gt(w, hn::Zero(floats)), areIn(u, v, camera.width, camera.height));
        const auto left = hn::Sub(u, set(0.5f)), top = hn::Sub(v, set(0.5f));
        const auto hasCorners = hn::And(isSeen, areIn(left, top, camera.width - 1, camera.height - 1));
        const auto column = hn::ConvertTo(ints, hn::IfThenElseZero(hasCorners, left)),
                   row = hn::ConvertTo(ints, hn::IfThenElseZero(hasCorners, top));
        hn::Store(hn::Add(hn::Mul(row, hn::Set(ints, camera.width)), column), ints, corners.places + (i - first));
        hn::StoreU(hn::IfThenElse(hn::RebindMask(ints, isSeen), code(SampleComparison::Code::askWhole),
                                  code(SampleComparison::Code::unseen)),
                   ints, a.codes + i);
    }
}

inline void readCorners(const DepthImage& target, std::size_t count, Corners& corners) {
    const float* const disparities = target.disparity.pixels().data();
    const std::uint8_t* const flags = target.flags.pixels().data();
    const auto below = static_cast<std::size_t>(target.camera.width);
    for (std::size_t i = 0; i < count; ++i) {
        const auto place = static_cast<std::size_t>(corners.places[i]);
        std::memcpy(corners.upper + 2 * i, disparities + place, 2 * sizeof(float));
        std::memcpy(corners.lower + 2 * i, disparities + place + below, 2 * sizeof(float));
        std::uint16_t upper, lower;
        std::memcpy(&upper, flags + place, sizeof upper);
        std::memcpy(&lower, flags + place + below, sizeof lower);
        corners.flags[i] = upper | lower;
    }
}

/// Those of the samples that are settled by the four corners.
void settle(const Camera& camera, const ComparisonOptions& options, std::size_t first, std::size_t end,
            const ComparisonArrays& a, const Corners& corners) {
    const Floats floats;
    const Ints ints;
    const auto noSurface = hn::Set(ints, (kNoSurface | kFloating) * 0x0101);
    for (std::size_t i = first; i < end; i += hn::Lanes(floats)) {
        const std::size_t k = i - first;
        hn::Vec<Floats> d00, d10, d01, d11;
        hn::LoadInterleaved2(floats, corners.upper + 2 * k, d00, d10);
        hn::LoadInterleaved2(floats, corners.lower + 2 * k, d01, d11);
        const auto left = hn::Sub(hn::LoadU(floats, a.u + i), set(0.5f)),
                   top = hn::Sub(hn::LoadU(floats, a.v + i), set(0.5f));
        const auto isSeen = hn::Ne(hn::LoadU(ints, a.codes + i), code(SampleComparison::Code::unseen));
        const auto hasCorners = areIn(left, top, camera.width - 1, camera.height - 1);
        const auto areSurfaces = hn::Eq(hn::And(hn::Load(ints, corners.flags + k), noSurface), hn::Zero(ints));
        const auto highest = hn::Max(hn::Max(d00, d10), hn::Max(d01, d11));
        const auto slope = hn::Sub(highest, hn::Min(hn::Min(d00, d10), hn::Min(d01, d11)));
        const auto isFlat = hn::Le(slope, hn::Mul(set(smoothSlope(options, 1)), highest));
        const auto isSmooth =
            hn::And(hn::RebindMask(floats, hn::And(isSeen, areSurfaces)), hn::And(hasCorners, isFlat));
        // Before the camera places are positive: to cut them off is to round them down.
        const auto inside = [&](const auto& place) HWY_ATTR { return hn::IfThenElseZero(hasCorners, place); };
        const auto s = hn::Sub(left, hn::ConvertTo(floats, hn::ConvertTo(ints, inside(left)))),
                   t = hn::Sub(top, hn::ConvertTo(floats, hn::ConvertTo(ints, inside(top))));
        const auto mix = [&](const auto& p, const auto& q, const auto& share)
                             HWY_ATTR { return hn::Add(p, hn::Mul(share, hn::Sub(q, p))); };
        const auto surface = mix(mix(d00, d10, s), mix(d01, d11, s), t);
        hn::StoreU(surface, floats, a.surface + i);
        const auto seen = hn::LoadU(floats, a.seenDisparity + i);
        const auto tolerance =
            hn::Add(hn::Mul(set(options.sameSurface), seen), hn::Mul(set(options.pixelError), slope));
        const auto difference = hn::Sub(seen, surface);
        const auto agrees = hn::And(isSmooth, hn::Le(hn::Abs(difference), tolerance));
        const auto isBehind = hn::And(isSmooth, hn::Lt(difference, hn::Zero(floats)));
        auto result = hn::LoadU(ints, a.codes + i);
        result = hn::IfThenElse(hn::RebindMask(ints, isBehind), code(SampleComparison::Code::behind), result);
        result = hn::IfThenElse(hn::RebindMask(ints, agrees), code(SampleComparison::Code::agrees), result);
        hn::StoreU(result, ints, a.codes + i);
    }
}

/// The order of every sum and product is that of sightingOf and compareWith.
void compareSamples(const DepthImage& target, const Reprojection& into, const ComparisonOptions& options,
                    std::size_t count, const ComparisonArrays& a) {
    Corners corners;
    for (std::size_t first = 0; first < count; first += Corners::kCapacity) {
        const std::size_t end = std::min(count, first + Corners::kCapacity);
        findCorners(target.camera, into, first, end, a, corners);
        if (target.camera.width < 2 || target.camera.height < 2) continue;
        readCorners(target, end - first, corners);
        settle(target.camera, options, first, end, a, corners);
    }
}

} // namespace HWY_NAMESPACE
} // namespace scene
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace scene {

HWY_EXPORT(compareSamples);

SampleComparison::SampleComparison(int most) : most_(most) {
    const std::size_t padded =
        (static_cast<std::size_t>(most) + kMostComparedLanes - 1) / kMostComparedLanes * kMostComparedLanes;
    for (std::vector<float>* values : {&x_, &y_, &disparity_, &u_, &v_, &seenDisparity_, &surface_})
        values->resize(padded);
    codes_.resize(padded);
}

void SampleComparison::compare(const DepthImage& target, const Reprojection& into, const ComparisonOptions& options) {
    target_ = &target;
    options_ = options;
    HWY_DYNAMIC_DISPATCH(compareSamples)
    (target, into, options, at(count_),
     {x_.data(), y_.data(), disparity_.data(), u_.data(), v_.data(), seenDisparity_.data(), surface_.data(),
      codes_.data()});
}

Comparison SampleComparison::whole(int i) const {
    return compareWith(*target_, sighting(i), options_);
}

} // namespace scene

#endif
