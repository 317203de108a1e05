#include "scene/align/image_pairs.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <hwy/cache_control.h>

namespace scene {

namespace {

constexpr int kAbout = 3;          ///< samples to each side over which a surface's slope is taken
constexpr float kBend = 0.01f;     ///< of disparity: what bends by more over them has no one slope
constexpr double kSmallest = 1e-7; ///< size of the first count

/// A value of a picture between its pixels, and how it changes with the place. Call with the place at least a pixel
/// within the picture.
struct Slope {
    double value = 0, du = 0, dv = 0;
};

Slope slopeAt(const Image<float>& picture, double u, double v) {
    const double left = u - 0.5, top = v - 0.5;
    const int x = static_cast<int>(left), y = static_cast<int>(top);
    const double s = left - x, t = top - y;
    const auto f = [&](int i, int j) { return static_cast<double>(picture(x + i, y + j)); };
    const double upper = f(0, 0) + s * (f(1, 0) - f(0, 0)), lower = f(0, 1) + s * (f(1, 1) - f(0, 1));
    return {upper + t * (lower - upper), (1 - t) * (f(1, 0) - f(0, 0)) + t * (f(1, 1) - f(0, 1)), lower - upper};
}

/// Slopes of disparity over a few samples, where those are of one surface: noise of neighbours would turn normals, and
/// normals that are turned at random hold an image where it is.
void widenSlope(const DepthImage& image, double u, double v, const ComparisonOptions& options, Slope& slope) {
    const int x = static_cast<int>(u), y = static_cast<int>(v);
    if (x < kAbout || y < kAbout || x + kAbout >= image.camera.width || y + kAbout >= image.camera.height) return;
    const auto across = [&](int dx, int dy, double& d) {
        if (!isSurface(image.flags(x + dx, y + dy)) || !isSurface(image.flags(x - dx, y - dy))) return;
        const float after = image.disparity(x + dx, y + dy), before = image.disparity(x - dx, y - dy);
        if (std::abs(after - before) > kAbout * smoothSlope(options, std::max(after, before))) return;
        const float middle = image.disparity(x, y);
        if (std::abs(after + before - 2 * middle) > kBend * middle) return;
        d = static_cast<double>(after - before) / (2 * kAbout);
    };
    across(kAbout, 0, slope.du);
    across(0, kAbout, slope.dv);
}

bool isWithin(const Image<float>& picture, double u, double v) {
    return u >= 1 && v >= 1 && u <= picture.width() - 1 && v <= picture.height() - 1;
}

/// Samples of a pair are far apart: what will be read about the next ones is in no cache, unless it is asked for
/// before. The place is as for slopeAt.
void prefetchAbout(const Image<float>& picture, double u, double v) {
    const int x = static_cast<int>(u - 0.5), y = static_cast<int>(v - 0.5);
    hwy::Prefetch(&picture(x, y));
    hwy::Prefetch(&picture(x, y + 1));
}

/// As widenSlope reads it.
void prefetchAbout(const DepthImage& image, double u, double v) {
    const int x = static_cast<int>(u), y = static_cast<int>(v);
    for (const int row : {std::max(y - kAbout, 0), std::min(y + kAbout, image.camera.height - 1)}) {
        hwy::Prefetch(&image.disparity(x, row));
        hwy::Prefetch(&image.flags(x, row));
    }
}

/// slope: of the residual with the point of the world.
void add(ImagePairSums& sums, const glm::dvec3& slope, const glm::dvec3& arm, double residual, double scale) {
    const double times = residual / scale, outside = 1 + times * times;
    const double weight = 1 / (scale * scale * outside * outside);
    const glm::dvec3 turn = glm::cross(arm, slope);
    const std::array<double, 6> j{slope.x, slope.y, slope.z, turn.x, turn.y, turn.z};
    for (int c = 0; c < 6; ++c) {
        const double weighted = weight * j[static_cast<std::size_t>(c)];
        for (int r = c; r < 6; ++r)
            sums.square(r, c) += weighted * j[static_cast<std::size_t>(r)];
        sums.slope[c] += weighted * residual;
    }
}

} // namespace

void SizeCounts::add(double size) {
    // Steps are wide enough for single precision, whose logarithm takes half the time.
    constexpr float kPerDoubling = kPerDecade * 0.30102999566f;
    const float step = size > kSmallest ? kPerDoubling * std::log2(static_cast<float>(size / kSmallest)) : 0;
    ++counts_[static_cast<std::size_t>(std::min(static_cast<int>(step), kPerDecade * kDecades - 1))];
    ++count_;
}

void SizeCounts::add(const SizeCounts& other) {
    for (std::size_t i = 0; i < counts_.size(); ++i)
        counts_[i] += other.counts_[i];
    count_ += other.count_;
}

double SizeCounts::median() const {
    if (count_ == 0) return 0;
    std::int64_t below = 0;
    std::size_t step = 0;
    while (2 * (below + counts_[step]) < count_)
        below += counts_[step++];
    return kSmallest * std::pow(10, (static_cast<double>(step) + 0.5) / kPerDecade);
}

SampleComparison samplesOf(const ImageSketch& sketch, int step) {
    const Camera& camera = sketch.depth.camera;
    SampleComparison samples(((camera.width - 1) / step + 1) * ((camera.height - 1) / step + 1));
    for (int y = step / 2; y < camera.height; y += step)
        for (int x = step / 2; x < camera.width; x += step)
            if (isSurface(sketch.depth.flags(x, y)))
                samples.add(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f, sketch.depth.disparity(x, y));
    return samples;
}

ImagePairSums comparePair(const ImageSketch& a, SampleComparison& samples, const Pose& worldFromA, const ImageSketch& b,
                          const Pose& worldFromB, const glm::dvec3& pivotInWorld, const ImagePairOptions& options,
                          ResidualSizes& sizes) {
    ImagePairSums sums;
    const Camera &from = a.depth.camera, &to = b.depth.camera;
    const Pose bFromWorld = inverse(worldFromB);
    const double perPixel = 1.0 / static_cast<double>(1 << options.level);
    const Image<float>&greyA = a.greys[options.level], &greyB = b.greys[options.level];
    samples.compare(b.depth, reprojectionInto(to, worldFromB, from, worldFromA), options.comparison);
    std::vector<int> agreeing;
    for (int i = 0; i < samples.count(); ++i) {
        const Comparison comparison = samples.comparison(i);
        if (comparison.relation == Relation::inFront) ++sums.against;
        if (comparison.relation != Relation::agrees || !comparison.isSmooth) continue;
        const Sighting at = samples.sighting(i);
        const double u = static_cast<double>(at.u), v = static_cast<double>(at.v);
        if (!isWithin(b.depth.disparity, u, v)) continue;
        agreeing.push_back(i);
        prefetchAbout(b.depth, u, v);
        if (isWithin(greyB, u * perPixel, v * perPixel)) prefetchAbout(greyB, u * perPixel, v * perPixel);
    }
    for (const int i : agreeing) {
        const Sighting at = samples.sighting(i);
        const double u = static_cast<double>(at.u), v = static_cast<double>(at.v);
        const auto x = static_cast<double>(samples.x(i)), y = static_cast<double>(samples.y(i));
        const glm::dvec3 p = worldFromA * (rayThrough(from, x, y) / static_cast<double>(samples.disparity(i)));
        const glm::dvec3 q = bFromWorld * p, arm = p - pivotInWorld;
        // b's surface about there is the plane n . q = 1, since disparity is linear over the picture of a plane.
        Slope surface = slopeAt(b.depth.disparity, u, v);
        widenSlope(b.depth, u, v, options.comparison, surface);
        glm::dvec3 n(surface.du * to.fx, surface.dv * to.fy, 0);
        n.z = surface.value - n.x * (u - to.cx) / to.fx - n.y * (v - to.cy) / to.fy;
        const double perMetre = surface.value / glm::length(n); // the distance in parts of the range
        const double apart = (glm::dot(n, q) - 1) * perMetre;
        add(sums, worldFromB.rotation * (n * perMetre), arm, apart, options.scales.range);
        sizes.range.add(std::abs(apart));
        ++sums.agreeing;

        const double ua = x * perPixel, va = y * perPixel;
        if (!isWithin(greyA, ua, va) || !isWithin(greyB, u * perPixel, v * perPixel)) continue;
        const Slope grey = slopeAt(greyB, u * perPixel, v * perPixel);
        const double du = grey.du * perPixel * to.fx / q.z, dv = grey.dv * perPixel * to.fy / q.z;
        const glm::dvec3 slope(du, dv, -(du * q.x + dv * q.y) / q.z);
        const double difference = grey.value - slopeAt(greyA, ua, va).value;
        add(sums, worldFromB.rotation * slope, arm, difference, options.scales.grey);
        sizes.grey.add(std::abs(difference));
    }
    return sums;
}

} // namespace scene
