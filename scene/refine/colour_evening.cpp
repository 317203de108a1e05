#include "scene/refine/colour_evening.h"

#include "scene/median.h"
#include "scene/srgb.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <Eigen/SparseCholesky>

namespace scene {

namespace {

constexpr int kDarkest = 24, kBrightest = 250; ///< bytes that say how bright a surface is: others are noise or cut off
constexpr double kPairDeviation = 0.01; ///< what no number of samples averages out: shine, and looks from two sides
constexpr double kRobustDeviations = 2; ///< pairs that leave the others by more count less
constexpr int kRobustPasses = 5;
constexpr int kChannels = 3;

/// Of one overlap, for each channel: log(other / image) of linear light, and how sure that is.
struct Ratio {
    std::uint32_t image = 0, other = 0;
    std::array<double, kChannels> log{}, deviation{};
};

bool isTelling(const Rgb8& c) {
    return std::min({c.r, c.g, c.b}) >= kDarkest && std::max({c.r, c.g, c.b}) <= kBrightest;
}

std::optional<Ratio> ratioOf(const DepthImage& image, const DepthImage& other, const ColourEveningOptions& options) {
    const Camera& camera = image.camera;
    const Reprojection into = reprojectionInto(other, image);
    const double pixels = static_cast<double>(camera.width) * camera.height;
    const int step = std::max(1, static_cast<int>(std::sqrt(pixels / options.samplesPerPair)));
    std::array<std::vector<float>, kChannels> logs;
    for (int y = step / 2; y < camera.height; y += step)
        for (int x = step / 2; x < camera.width; x += step) {
            const std::uint8_t flags = image.flags(x, y);
            if (!isSurface(flags) || flags & kNoColour || !isTelling(image.colour(x, y))) continue;
            const Sighting at =
                sightingOf(into, static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f, image.disparity(x, y));
            const Comparison comparison = compareWith(other, at, options.comparison);
            if (comparison.relation != Relation::agrees || !comparison.isSmooth) continue;
            if (!hasColourAt(other, at.u, at.v)) continue;
            const glm::vec3 seen = colourAt(other, at.u, at.v) + 0.5f;
            const Rgb8 there{static_cast<std::uint8_t>(seen.x), static_cast<std::uint8_t>(seen.y),
                             static_cast<std::uint8_t>(seen.z)};
            if (!isTelling(there)) continue;
            const Rgb8 here = image.colour(x, y);
            const std::array<std::uint8_t, kChannels> from{here.r, here.g, here.b}, to{there.r, there.g, there.b};
            for (std::size_t c = 0; c < kChannels; ++c)
                logs[c].push_back(std::log(linearFromSrgb(to[c]) / linearFromSrgb(from[c])));
        }
    if (std::ssize(logs[0]) < options.leastSamples) return std::nullopt;
    Ratio ratio;
    for (std::size_t c = 0; c < kChannels; ++c) {
        ratio.log[c] = medianOf(logs[c]);
        for (float& value : logs[c])
            value = std::abs(value - static_cast<float>(ratio.log[c]));
        const double spread = 1.4826 * medianOf(logs[c]);
        ratio.deviation[c] =
            std::sqrt(kPairDeviation * kPairDeviation + 1.6 * spread * spread / static_cast<double>(logs[c].size()));
    }
    return ratio;
}

/// Logarithms of the factors of one channel: least squares over the pairs, those that leave the rest counting less.
std::vector<double> solve(const std::vector<Ratio>& ratios, std::size_t channel, std::size_t images,
                          double priorDeviation) {
    Eigen::VectorXd logs = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(images));
    for (int pass = 0; pass < kRobustPasses; ++pass) {
        std::vector<Eigen::Triplet<double>> entries;
        Eigen::VectorXd right = Eigen::VectorXd::Zero(logs.size());
        for (Eigen::Index i = 0; i < logs.size(); ++i)
            entries.emplace_back(static_cast<int>(i), static_cast<int>(i), 1 / (priorDeviation * priorDeviation));
        for (const Ratio& ratio : ratios) {
            const int a = static_cast<int>(ratio.image), b = static_cast<int>(ratio.other);
            const double off = (logs[a] - logs[b] - ratio.log[channel]) / ratio.deviation[channel];
            const double robust = pass == 0 ? 1 : 1 / std::max(1.0, std::abs(off) / kRobustDeviations);
            const double weight = robust / (ratio.deviation[channel] * ratio.deviation[channel]);
            entries.emplace_back(a, a, weight), entries.emplace_back(b, b, weight);
            entries.emplace_back(a, b, -weight), entries.emplace_back(b, a, -weight);
            right[a] += weight * ratio.log[channel], right[b] -= weight * ratio.log[channel];
        }
        Eigen::SparseMatrix<double> matrix(logs.size(), logs.size());
        matrix.setFromTriplets(entries.begin(), entries.end());
        logs = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(matrix).solve(right);
    }
    return {logs.data(), logs.data() + logs.size()};
}

/// Mean relative difference of the overlaps' colours once images are multiplied.
double seamOf(const std::vector<Ratio>& ratios, const std::vector<glm::dvec3>& factors) {
    double sum = 0;
    for (const Ratio& ratio : ratios)
        for (std::size_t c = 0; c < kChannels; ++c) {
            const auto channel = static_cast<glm::length_t>(c);
            sum += std::abs(std::expm1(ratio.log[c] + std::log(factors[ratio.other][channel]) -
                                       std::log(factors[ratio.image][channel])));
        }
    return ratios.empty() ? 0 : sum / (kChannels * static_cast<double>(ratios.size()));
}

} // namespace

ColourEvening evenColours(ImageStore& images, const std::vector<std::vector<Partner>>& partners,
                          const ColourEveningOptions& options, const std::function<void()>& onImage) {
    std::vector<std::vector<Ratio>> ratiosOf(images.size());
    visitEach(images, 2, [&](std::size_t i) { // the image and a partner
        const ImageStore::Lease image = images.borrow(i);
        const std::size_t asked = std::min(partners[i].size(), static_cast<std::size_t>(options.maxPartners));
        for (std::size_t k = 0; k < asked; ++k) {
            const std::uint32_t other = partners[i][k].image;
            const ImageStore::Lease lease = images.borrow(other);
            if (auto ratio = ratioOf(*image, *lease, options)) {
                ratio->image = static_cast<std::uint32_t>(i), ratio->other = other;
                ratiosOf[i].push_back(*ratio);
            }
        }
        if (onImage) onImage();
    });
    std::vector<Ratio> ratios;
    for (const std::vector<Ratio>& some : ratiosOf)
        ratios.insert(ratios.end(), some.begin(), some.end());

    ColourEvening result;
    result.factors.assign(images.size(), glm::dvec3(1));
    result.pairs = std::ssize(ratios);
    result.seamBefore = result.seamAfter = seamOf(ratios, result.factors);
    std::vector<glm::dvec3> factors(images.size(), glm::dvec3(1));
    std::vector<std::uint8_t> isLimited(images.size(), 0);
    double greatest = 0;
    for (std::size_t c = 0; c < kChannels; ++c) {
        const std::vector<double> logs = solve(ratios, c, images.size(), options.priorStops * std::log(2.0));
        for (std::size_t i = 0; i < logs.size(); ++i) {
            const double most = options.mostStops * std::log(2.0);
            if (logs[i] > most) isLimited[i] = 1;
            factors[i][static_cast<glm::length_t>(c)] = std::exp(std::min(logs[i], most));
            greatest = std::max(greatest, std::abs(std::expm1(std::min(logs[i], most))));
        }
    }
    if (greatest <= options.leastChange) return result;
    result.factors = factors;
    result.seamAfter = seamOf(ratios, factors);
    result.changed =
        std::count_if(factors.begin(), factors.end(), [](const glm::dvec3& f) { return f != glm::dvec3(1); });
    result.limited = std::count(isLimited.begin(), isLimited.end(), 1);
    return result;
}

void applyFactors(Image<Rgb8>& colour, const glm::dvec3& factors) {
    std::array<std::array<std::uint8_t, 256>, kChannels> tables{};
    for (std::size_t c = 0; c < kChannels; ++c)
        for (int value = 0; value < 256; ++value) {
            const double linear = linearFromSrgb(static_cast<std::uint8_t>(value));
            const double factor = factors[static_cast<glm::length_t>(c)];
            tables[c][static_cast<std::size_t>(value)] = encoded(glm::dvec3(linear * factor)).r;
        }
    for (Rgb8& pixel : colour.pixels())
        pixel = {tables[0][pixel.r], tables[1][pixel.g], tables[2][pixel.b]};
}

} // namespace scene
