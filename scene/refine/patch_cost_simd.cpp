// Colours of a patch against a photograph's, compiled for every vector width and chosen when the program starts.
#include "scene/refine/patch_cost.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "scene/refine/patch_cost_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace scene {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, PatchSamples::kMostLanes>;
using Ints = hn::RebindToSigned<Floats>;

float differencesOf(const std::uint8_t* bytes, int width, const PatchSamples& patch, const PatchPlaces& places,
                    float most) {
    const Floats floats;
    const Ints ints;
    const auto set = [&](float value) { return hn::Set(floats, value); };
    const auto* const base = reinterpret_cast<const std::int32_t*>(bytes);
    const auto byteMask = hn::Set(ints, 0xff);
    const auto toNumber = [&](const auto& byte) HWY_ATTR { return hn::ConvertTo(floats, hn::And(byte, byteMask)); };
    const auto mix = [&](const auto& a, const auto& b, const auto& share)
                         HWY_ATTR { return hn::Add(a, hn::Mul(share, hn::Sub(b, a))); };
    // Sixteen sums whatever the width of a vector is: rounding must not depend on the processor.
    HWY_ALIGN float sums[PatchSamples::kMostLanes] = {};
    for (std::size_t i = 0; i < patch.padded(); i += hn::Lanes(floats)) {
        const auto dx = hn::LoadU(floats, &patch.dx[i]), dy = hn::LoadU(floats, &patch.dy[i]);
        const auto left =
            hn::Add(set(places.u - 0.5f), hn::Add(hn::Mul(dx, set(places.uByX)), hn::Mul(dy, set(places.uByY))));
        const auto top =
            hn::Add(set(places.v - 0.5f), hn::Add(hn::Mul(dx, set(places.vByX)), hn::Mul(dy, set(places.vByY))));
        const auto x = hn::ConvertTo(ints, left), y = hn::ConvertTo(ints, top);
        const auto s = hn::Sub(left, hn::ConvertTo(floats, x)), t = hn::Sub(top, hn::ConvertTo(floats, y));
        // Four bytes at a time: red, green, blue and the next pixel's red of the left pixel; of the right one the
        // blue of the left before its own, lest the last pixel's be read beyond the end.
        const auto upper = hn::Mul(hn::Add(hn::Mul(y, hn::Set(ints, width)), x), hn::Set(ints, 3));
        const auto lower = hn::Add(upper, hn::Set(ints, 3 * width)), two = hn::Set(ints, 2);
        const auto a = hn::GatherOffset(ints, base, upper), b = hn::GatherOffset(ints, base, hn::Add(upper, two));
        const auto c = hn::GatherOffset(ints, base, lower), d = hn::GatherOffset(ints, base, hn::Add(lower, two));
        const auto apart = [&](const auto& p, const auto& q, const auto& r, const auto& e, const float* of) HWY_ATTR {
            const auto here = mix(mix(toNumber(p), toNumber(q), s), mix(toNumber(r), toNumber(e), s), t);
            return hn::Abs(hn::Sub(here, hn::LoadU(floats, of + i)));
        };
        const auto red = apart(a, hn::ShiftRight<8>(b), c, hn::ShiftRight<8>(d), patch.red.data());
        const auto green = apart(hn::ShiftRight<8>(a), hn::ShiftRight<16>(b), hn::ShiftRight<8>(c),
                                 hn::ShiftRight<16>(d), patch.green.data());
        const auto blue = apart(hn::ShiftRight<16>(a), hn::ShiftRight<24>(b), hn::ShiftRight<16>(c),
                                hn::ShiftRight<24>(d), patch.blue.data());
        const auto mean = hn::Mul(hn::Add(hn::Add(red, green), blue), set(1.0f / 3));
        float* const sum = sums + i % PatchSamples::kMostLanes;
        const auto weighed = hn::Mul(hn::LoadU(floats, &patch.weight[i]), hn::Min(mean, set(most)));
        hn::Store(hn::Add(hn::Load(floats, sum), weighed), floats, sum);
    }
    for (std::size_t half = PatchSamples::kMostLanes / 2; half > 0; half /= 2)
        for (std::size_t k = 0; k < half; ++k)
            sums[k] += sums[k + half];
    return sums[0];
}

} // namespace HWY_NAMESPACE
} // namespace scene
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace scene {

HWY_EXPORT(differencesOf);

void PatchSamples::clear() {
    for (std::vector<float>* values : {&dx, &dy, &weight, &red, &green, &blue})
        values->clear();
    weightOfAll_ = 0;
}

void PatchSamples::add(float offsetX, float offsetY, float sampleWeight, const glm::vec3& colour) {
    dx.push_back(offsetX), dy.push_back(offsetY), weight.push_back(sampleWeight);
    red.push_back(colour.x), green.push_back(colour.y), blue.push_back(colour.z);
    weightOfAll_ += sampleWeight;
}

void PatchSamples::pad() {
    const std::size_t padded = (dx.size() + kMostLanes - 1) / kMostLanes * kMostLanes;
    for (std::vector<float>* values : {&dx, &dy, &weight, &red, &green, &blue})
        values->resize(padded, 0.f);
}

float sumOfDifferences(const Image<Rgb8>& photograph, const PatchSamples& patch, const PatchPlaces& places,
                       float most) {
    static_assert(sizeof(Rgb8) == 3);
    return HWY_DYNAMIC_DISPATCH(differencesOf)(&photograph.pixels().data()->r, photograph.width(), patch, places, most);
}

} // namespace scene

#endif
