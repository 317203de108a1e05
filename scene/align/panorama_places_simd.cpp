// Places in a panorama, compiled for every vector width and chosen when the program starts.
#include "scene/align/panorama_places.h"

#include <numbers>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "scene/align/panorama_places_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// What all targets share is declared once.
#ifndef REVISIT_PANORAMA_PLACES_ARRAYS
#define REVISIT_PANORAMA_PLACES_ARRAYS
namespace scene {

/// In and out, all of padded length.
struct PanoramaPlacesArrays {
    const float *givenX, *givenY, *givenZ;
    double *x, *y, *z;
    std::int32_t* cells;
};

constexpr std::size_t kMostPlacedLanes = 8; ///< vectors of doubles are no wider

} // namespace scene
#endif

HWY_BEFORE_NAMESPACE();
namespace scene {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Doubles = hn::CappedTag<double, kMostPlacedLanes>;
using Floats = hn::Rebind<float, Doubles>;
using Ints = hn::Rebind<std::int32_t, Doubles>;
using DoubleVector = hn::Vec<Doubles>;

HWY_INLINE DoubleVector set(double value) {
    return hn::Set(Doubles(), value);
}

/// The order of every sum and product is that of Panorama::placeOf.
HWY_INLINE DoubleVector angleOf(DoubleVector y, DoubleVector x) {
    const DoubleVector zero = hn::Zero(Doubles());
    const auto across = hn::Abs(x), up = hn::Abs(y);
    const auto ratio = hn::Div(hn::Min(across, up), hn::Max(across, up)), square = hn::Mul(ratio, ratio);
    DoubleVector sum = zero;
    for (std::size_t i = kArcTangent.size(); i > 0; --i)
        sum = hn::Mul(hn::Add(sum, set(kArcTangent[i - 1])), square);
    DoubleVector angle = hn::Mul(ratio, hn::Add(set(1), sum));
    angle = hn::IfThenElse(hn::Gt(up, across), hn::Sub(set(std::numbers::pi / 2), angle), angle);
    angle = hn::IfThenElse(hn::Lt(x, zero), hn::Sub(set(std::numbers::pi), angle), angle);
    return hn::IfThenElse(hn::Lt(y, zero), hn::Neg(angle), angle);
}

void findPlaces(const Pose& panoramaFromPoints, int rows, std::size_t count, const PanoramaPlacesArrays& a) {
    const Doubles doubles;
    const Floats floats;
    const Ints ints;
    const glm::dmat3& turn = panoramaFromPoints.rotation;
    const glm::dvec3& shift = panoramaFromPoints.translation;
    const auto step = set(std::numbers::pi / rows);
    const double columns = 2.0 * rows;
    for (std::size_t i = 0; i < count; i += hn::Lanes(doubles)) {
        const auto givenX = hn::PromoteTo(doubles, hn::LoadU(floats, a.givenX + i)),
                   givenY = hn::PromoteTo(doubles, hn::LoadU(floats, a.givenY + i)),
                   givenZ = hn::PromoteTo(doubles, hn::LoadU(floats, a.givenZ + i));
        const auto along = [&](int axis) HWY_ATTR {
            const auto turned =
                hn::Add(hn::Add(hn::Mul(set(turn[0][axis]), givenX), hn::Mul(set(turn[1][axis]), givenY)),
                        hn::Mul(set(turn[2][axis]), givenZ));
            return hn::Add(turned, set(shift[axis]));
        };
        const auto x = along(0), y = along(1), z = along(2);
        hn::StoreU(x, doubles, a.x + i);
        hn::StoreU(y, doubles, a.y + i);
        hn::StoreU(z, doubles, a.z + i);
        const auto level = hn::Sqrt(hn::Add(hn::Mul(x, x), hn::Mul(y, y)));
        const auto size = hn::Add(level, hn::Abs(z));
        const auto isSomewhere = hn::And(hn::Gt(size, hn::Zero(doubles)), hn::Lt(size, hn::Inf(doubles)));
        const auto azimuth = hn::Div(hn::Add(angleOf(y, x), set(std::numbers::pi)), step),
                   elevation = hn::Div(hn::Add(angleOf(z, level), set(std::numbers::pi / 2)), step);
        const auto within = [&](const auto& place, double most)
                                HWY_ATTR { return hn::Trunc(hn::Min(hn::Max(place, hn::Zero(doubles)), set(most))); };
        const auto column =
            within(hn::IfThenElse(hn::Gt(level, hn::Zero(doubles)), azimuth, set(columns / 2)), columns - 1);
        const auto row = within(elevation, rows - 1.0);
        const auto cell = hn::IfThenElse(isSomewhere, hn::Add(hn::Mul(row, set(columns)), column), set(-1));
        hn::StoreU(hn::DemoteTo(ints, cell), ints, a.cells + i);
    }
}

} // namespace HWY_NAMESPACE
} // namespace scene
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace scene {

HWY_EXPORT(findPlaces);

void PanoramaPlaces::add(const glm::vec3& point) {
    if (count_ == givenX_.size()) {
        const std::size_t padded = 2 * count_ + 32 * kMostPlacedLanes;
        for (std::vector<float>* values : {&givenX_, &givenY_, &givenZ_})
            values->resize(padded);
        for (std::vector<double>* values : {&x_, &y_, &z_})
            values->resize(padded);
        cells_.resize(padded);
    }
    givenX_[count_] = point.x, givenY_[count_] = point.y, givenZ_[count_] = point.z;
    ++count_;
}

void PanoramaPlaces::find(const Pose& panoramaFromPoints, int rows) {
    HWY_DYNAMIC_DISPATCH(findPlaces)
    (panoramaFromPoints, rows, count_,
     {givenX_.data(), givenY_.data(), givenZ_.data(), x_.data(), y_.data(), z_.data(), cells_.data()});
}

} // namespace scene

#endif
