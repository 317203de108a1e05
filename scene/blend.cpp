#include "scene/blend.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace scene {

namespace {

double squared(double x) {
    return x * x;
}

/// How far the eye stands from the camera, as a share of its distance to the surface. Multiplied by disparity, as in
/// scene/preference.cpp: every camera is near for the sky.
double baselineShareOf(const TileMiddle& middle, const glm::dvec3& eyeFromCamera) {
    const double distance = glm::length(middle.rayInWorld - middle.disparity * eyeFromCamera);
    const double baseline = middle.disparity * glm::length(eyeFromCamera);
    return baseline > 0 ? baseline / distance : 0;
}

/// In (0, 1]; 0 for images that are left out.
double confidenceOf(double baselineShare, const BlendOptions& options) {
    const double limit = static_cast<double>(options.baseline);
    if (!(baselineShare < limit)) return baselineShare == 0 ? 1 : 0;
    const double quarter = squared(static_cast<double>(options.quarterBaseline));
    const double fading = 1 - squared(baselineShare / limit); // nothing pops where an image comes in
    return squared(fading) * squared(quarter / (quarter + squared(baselineShare)));
}

double toleranceOf(double baselineShare, const BlendOptions& options) {
    const double parallax = static_cast<double>(options.parallax);
    // A disparity of 0 differs by 1 from any: all that is farther is included then.
    if (baselineShare <= parallax) return 1;
    return std::max(parallax / baselineShare, static_cast<double>(options.depthTolerance));
}

} // namespace

std::optional<BlendSpot> blendSpotOf(const glm::dmat4& c, const SampleBox& box, const TileMiddle& middle,
                                     const glm::dvec3& eyeFromCamera, const BlendOptions& options) {
    const double baselineShare = baselineShareOf(middle, eyeFromCamera);
    const double confidence = confidenceOf(baselineShare, options);
    if (!(confidence > 0)) return std::nullopt;
    const glm::dvec3 cx(c[0]), cy(c[1]), place = 0.5 * (box.least + box.most);
    const glm::dvec3 h = place.x * cx + place.y * cy + glm::dvec3(c[2]) + place.z * glm::dvec3(c[3]);
    if (!(h.z > 0)) return std::nullopt;
    // A source pixel is seen as the parallelogram of (a, b) and (e, f).
    const double u = h.x / h.z, v = h.y / h.z;
    const double a = (cx.x - u * cx.z) / h.z, b = (cx.y - v * cx.z) / h.z;
    const double e = (cy.x - u * cy.z) / h.z, f = (cy.y - v * cy.z) / h.z;
    const double samples = squared(static_cast<double>(options.samplesRadius));
    const double pixels = squared(static_cast<double>(options.pixelsRadius));
    const double xx = samples * (a * a + e * e) + pixels, yy = samples * (b * b + f * f) + pixels;
    const double xy = samples * (a * b + e * f);
    const double determinant = xx * yy - xy * xy, most = static_cast<double>(options.maxRadius);
    if (!(determinant > 0 && xx <= most * most && yy <= most * most)) return std::nullopt;
    const double area = std::abs(a * f - b * e) * samples / std::sqrt(determinant);
    return BlendSpot{static_cast<float>(yy / determinant),
                     static_cast<float>(-2 * xy / determinant),
                     static_cast<float>(xx / determinant),
                     static_cast<float>(std::sqrt(xx)),
                     static_cast<float>(std::sqrt(yy)),
                     static_cast<float>(confidence * std::min(area, 1.0)),
                     static_cast<float>(toleranceOf(baselineShare, options))};
}

float blendUnitOf(std::size_t images) {
    constexpr double kSamples = 8, kSums = 4294967296.0, kColours = 255;
    return static_cast<float>(
        std::clamp(std::floor(kSums / (kSamples * kColours * static_cast<double>(std::max<std::size_t>(images, 1)))),
                   1.0, 65535.0));
}

EyeImage resolve(const ZBuffer& zBuffer, const Image<BlendSums>& sums) {
    EyeImage eye = resolve(zBuffer);
    const auto pixels = sums.pixels();
    for (std::size_t i = 0; i < pixels.size(); ++i) {
        const BlendSums& sum = pixels[i];
        if (sum.weight == 0) continue;
        const auto mean = [&](std::uint32_t total) {
            return static_cast<std::uint8_t>((total + sum.weight / 2) / sum.weight);
        };
        eye.colour.pixels()[i] = {mean(sum.red), mean(sum.green), mean(sum.blue)};
    }
    return eye;
}

} // namespace scene
