#include "app/picture_error.h"

#include "render/shaders/shared/z_key.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>

namespace app {

namespace {

constexpr int kWindow = 11;
constexpr double kWindowSigma = 1.5, kRange = 255, kK1 = 0.01, kK2 = 0.03;

/// ITU-R BT.601, as the paper's own programs have it.
double lumaOf(scene::Rgb8 c) {
    return 0.299 * c.r + 0.587 * c.g + 0.114 * c.b;
}

bool isCovered(std::uint8_t pixelClass) {
    return pixelClass == render::kClassSeen || pixelClass == render::kClassFilled;
}

/// The nearest that the camera measured in 3 x 3 pixels; 0 if it measured nothing at the middle.
float nearestAround(const scene::Image<float>& depth, int x, int y) {
    if (!(depth(x, y) > 0)) return 0;
    float nearest = std::numeric_limits<float>::infinity();
    for (int v = std::max(y - 1, 0); v <= std::min(y + 1, depth.height() - 1); ++v)
        for (int u = std::max(x - 1, 0); u <= std::min(x + 1, depth.width() - 1); ++u)
            if (depth(u, v) > 0) nearest = std::min(nearest, depth(u, v));
    return nearest;
}

double share(std::size_t part, std::size_t whole) {
    return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
}

} // namespace

Truth truthOf(const scene::DepthImage& image) {
    Truth truth{image.colour, {image.camera.width, image.camera.height}};
    for (std::size_t i = 0; i < truth.depthMetres.size(); ++i) {
        const std::uint8_t flags = image.flags.pixels()[i];
        if (scene::isSurface(flags) && !scene::isClosed(flags))
            truth.depthMetres.pixels()[i] = 1 / image.disparity.pixels()[i];
    }
    return truth;
}

double psnrOf(const scene::Image<scene::Rgb8>& a, const scene::Image<scene::Rgb8>& b,
              const scene::Image<std::uint8_t>& where) {
    assert(a.size() == b.size() && a.size() == where.size());
    std::uint64_t sum = 0, count = 0;
    const auto squared = [](int difference) { return static_cast<std::uint64_t>(difference * difference); };
    for (std::size_t i = 0; i < a.size(); ++i) {
        if (where.pixels()[i] == 0) continue;
        const scene::Rgb8 p = a.pixels()[i], q = b.pixels()[i];
        sum += squared(p.r - q.r) + squared(p.g - q.g) + squared(p.b - q.b);
        count += 3;
    }
    if (count == 0) return 0;
    if (sum == 0) return kMostDecibels;
    return std::min(kMostDecibels,
                    10 * std::log10(kRange * kRange * static_cast<double>(count) / static_cast<double>(sum)));
}

double ssimOf(const scene::Image<scene::Rgb8>& a, const scene::Image<scene::Rgb8>& b,
              const scene::Image<std::uint8_t>& where) {
    assert(a.size() == b.size() && a.size() == where.size());
    // Sums over each window, nothing beyond the picture: of the weight, p, q, p p, q q, p q.
    std::array<cv::Mat1d, 6> sums;
    for (cv::Mat1d& sum : sums)
        sum.create(where.height(), where.width());
    for (int y = 0; y < where.height(); ++y)
        for (int x = 0; x < where.width(); ++x) {
            const double w = where(x, y) != 0 ? 1 : 0, p = lumaOf(a(x, y)), q = lumaOf(b(x, y));
            const std::array values{w, w * p, w * q, w * p * p, w * q * q, w * p * q};
            for (std::size_t i = 0; i < sums.size(); ++i)
                sums[i](y, x) = values[i];
        }
    for (cv::Mat1d& sum : sums)
        cv::GaussianBlur(sum, sum, {kWindow, kWindow}, kWindowSigma, kWindowSigma, cv::BORDER_CONSTANT);

    constexpr double c1 = kK1 * kRange * kK1 * kRange, c2 = kK2 * kRange * kK2 * kRange;
    double sum = 0;
    std::size_t count = 0;
    for (int y = 0; y < where.height(); ++y)
        for (int x = 0; x < where.width(); ++x) {
            if (where(x, y) == 0) continue;
            const auto mean = [&](std::size_t i) { return sums[i](y, x) / sums[0](y, x); };
            const double p = mean(1), q = mean(2);
            const double varianceP = mean(3) - p * p, varianceQ = mean(4) - q * q, covariance = mean(5) - p * q;
            sum += (2 * p * q + c1) * (2 * covariance + c2) / ((p * p + q * q + c1) * (varianceP + varianceQ + c2));
            ++count;
        }
    return count == 0 ? 0 : sum / static_cast<double>(count);
}

PictureError errorOf(const render::EyeImage& drawn, const Truth& truth) {
    const int width = drawn.colour.width(), height = drawn.colour.height();
    assert(truth.colour.width() == width && truth.colour.height() == height);
    scene::Image<std::uint8_t> covered(width, height), seen(width, height);
    const scene::Image<std::uint8_t> all(width, height, 1);
    const auto depths = truth.depthMetres.pixels();
    const bool hasDepth = std::any_of(depths.begin(), depths.end(), [](float depth) { return depth > 0; });
    std::size_t coveredCount = 0, measured = 0, surfaces = 0, holes = 0, unseen = 0, solid = 0;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const std::uint8_t pixelClass = drawn.pixelClass(x, y);
            const bool covers = isCovered(pixelClass);
            covered(x, y) = covers ? 1 : 0;
            seen(x, y) = pixelClass == render::kClassSeen ? 1 : 0;
            coveredCount += covered(x, y);
            const float nearest = hasDepth ? nearestAround(truth.depthMetres, x, y) : 0;
            const bool isSurface = hasDepth ? nearest > 0 && std::isfinite(truth.depthMetres(x, y)) : true;
            surfaces += isSurface ? 1 : 0;
            holes += isSurface && !covers ? 1 : 0;
            unseen += isSurface && pixelClass == render::kClassUnseen ? 1 : 0;
            if (!(nearest > 0)) continue;
            ++measured;
            const double limit = static_cast<double>(nearest) * (1 - kSolidTolerance);
            if (covers && static_cast<double>(drawn.depthMetres(x, y)) < limit) ++solid;
        }
    PictureError error;
    error.psnrCovered = psnrOf(drawn.colour, truth.colour, covered);
    error.psnrSeen = psnrOf(drawn.colour, truth.colour, seen);
    error.psnrAll = psnrOf(drawn.colour, truth.colour, all);
    error.ssim = ssimOf(drawn.colour, truth.colour, covered);
    error.coveredShare = share(coveredCount, covered.size());
    error.holeShare = share(holes, surfaces);
    error.unseenShare = share(unseen, surfaces);
    error.wronglySolidShare = measured > 0 ? share(solid, measured) : std::numeric_limits<double>::quiet_NaN();
    return error;
}

} // namespace app
