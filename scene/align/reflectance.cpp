#include "scene/align/reflectance.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/geometric.hpp>

namespace scene {

namespace {

constexpr int kBins = 48;
constexpr double kBinsPerOctave = 4, kFirstOctave = -4; ///< of range, from 1/16 m
constexpr std::size_t kLeastInBin = 200;

double binOf(const glm::vec3& point) {
    const double range = std::max(double{glm::length(point)}, 1e-3);
    return std::clamp((std::log2(range) - kFirstOctave) * kBinsPerOctave, 0.0, kBins - 1.001);
}

} // namespace

std::vector<Rgb8> evenedReflectance(const ScanWithIntensity& from) {
    const auto& points = from.scan.pointsInScanner;
    std::vector<Rgb8> greys(points.size(), Rgb8{128, 128, 128});
    if (from.intensities.size() != points.size()) return greys;
    std::array<std::vector<float>, kBins> octaves;
    const auto isGood = [&](std::size_t i) { return std::isfinite(from.intensities[i]) && from.intensities[i] > 0; };
    for (std::size_t i = 0; i < points.size(); ++i)
        if (isGood(i)) octaves[static_cast<std::size_t>(binOf(points[i]))].push_back(std::log2(from.intensities[i]));
    // The median of each bin; bins with too little take that of the nearest with enough.
    std::array<double, kBins> median{};
    std::array<bool, kBins> isKnown{};
    for (std::size_t b = 0; b < kBins; ++b) {
        if (octaves[b].size() < kLeastInBin) continue;
        const auto middle = octaves[b].begin() + std::ssize(octaves[b]) / 2;
        std::nth_element(octaves[b].begin(), middle, octaves[b].end());
        median[b] = *middle;
        isKnown[b] = true;
    }
    for (int b = 0; b < kBins; ++b)
        for (int away = 0; away < kBins && !isKnown[static_cast<std::size_t>(b)]; ++away)
            for (const int other : {b - away, b + away})
                if (other >= 0 && other < kBins && octaves[static_cast<std::size_t>(other)].size() >= kLeastInBin)
                    median[static_cast<std::size_t>(b)] = median[static_cast<std::size_t>(other)],
                    isKnown[static_cast<std::size_t>(b)] = true;
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (!isGood(i)) continue;
        const double bin = binOf(points[i]) - 0.5;
        const auto low = static_cast<std::size_t>(std::max(bin, 0.0));
        const double part = std::clamp(bin - static_cast<double>(low), 0.0, 1.0);
        const double usual = (1 - part) * median[low] + part * median[std::min<std::size_t>(low + 1, kBins - 1)];
        const double above = (std::log2(double{from.intensities[i]}) - usual) / kGreyOctaves;
        const auto grey = static_cast<std::uint8_t>(std::clamp(std::lround(128 + 255 * above), 0L, 255L));
        greys[i] = {grey, grey, grey};
    }
    return greys;
}

} // namespace scene
