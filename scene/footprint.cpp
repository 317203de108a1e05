#include "scene/footprint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <glm/common.hpp>
#include <glm/matrix.hpp>

namespace scene {

SampleBox boxOf(const Tile& tile, const Camera& camera) {
    // The border stands one sample outside the tile, but never outside the image.
    const int right = std::min(tile.x0 + tile.width, camera.width - 1);
    const int bottom = std::min(tile.y0 + tile.height, camera.height - 1);
    return {{tile.x0 + 0.5, tile.y0 + 0.5, static_cast<double>(tile.minDisparity)},
            {right + 0.5, bottom + 0.5, static_cast<double>(tile.maxDisparity)}};
}

SampleBox typicalOf(const SampleBox& box, std::uint32_t placeBits) {
    if (placeBits != kScrapPlaceBits) return box;
    const glm::dvec3 middle = 0.5 * (box.least + box.most);
    return {middle, middle};
}

namespace {

/// extent: of the samples' disparities.
BoxInEye boxInEye(const glm::dmat4& c, const SampleBox& box, double extent) {
    const glm::dvec3 cx(c[0]), cy(c[1]), c1(c[2]), cd(c[3]);
    constexpr std::size_t kCorners = 8;
    std::array<double, kCorners> u{}, v{}, perW{}; // of the corners
    double nearest = std::numeric_limits<double>::infinity();
    std::size_t corner = 0;
    for (const double d : {box.least.z, box.most.z})
        for (const double y : {box.least.y, box.most.y})
            for (const double x : {box.least.x, box.most.x}) {
                const glm::dvec3 h = x * cx + y * cy + c1 + d * cd; // (u w, v w, w)
                u[corner] = h.x, v[corner] = h.y, perW[corner] = h.z;
                nearest = std::min(nearest, h.z);
                ++corner;
            }
    if (nearest <= 0) {
        constexpr double kInfinite = std::numeric_limits<double>::infinity();
        return {kInfinite, kInfinite, kInfinite};
    }
    for (std::size_t i = 0; i < kCorners; ++i) {
        perW[i] = 1 / perW[i];
        u[i] *= perW[i], v[i] *= perW[i];
    }
    double widest = 0, farthest = 0; // farthest: squared, for each unit of disparity
    double left = u[0], right = u[0], top = v[0], bottom = v[0];
    for (std::size_t i = 0; i < kCorners; ++i) {
        const double across = std::abs(cx.x - u[i] * cx.z) + std::abs(cy.x - u[i] * cy.z);
        const double down = std::abs(cx.y - v[i] * cx.z) + std::abs(cy.y - v[i] * cy.z);
        const double stepX = (cd.x - u[i] * cd.z) * perW[i], stepY = (cd.y - v[i] * cd.z) * perW[i];
        widest = std::max(widest, std::max(across, down) * perW[i]);
        farthest = std::max(farthest, stepX * stepX + stepY * stepY);
        left = std::min(left, u[i]), right = std::max(right, u[i]);
        top = std::min(top, v[i]), bottom = std::max(bottom, v[i]);
    }
    return {widest, std::sqrt(farthest) * extent, (right - left) * (bottom - top)};
}

} // namespace

BoxInEye boxInEye(const glm::dmat4& c, const SampleBox& box) {
    return boxInEye(c, box, box.most.z - box.least.z);
}

BoxInEye typicalInEye(const glm::dmat4& c, const SampleBox& box, std::uint32_t placeBits) {
    return boxInEye(c, typicalOf(box, placeBits), box.most.z - box.least.z);
}

double sampleAreaInEye(const glm::dmat4& c, const SampleBox& box) {
    const glm::dvec3 cx(c[0]), cy(c[1]), place = 0.5 * (box.least + box.most);
    const glm::dvec3 h = place.x * cx + place.y * cy + glm::dvec3(c[2]) + place.z * glm::dvec3(c[3]);
    if (!(h.z > 0)) return std::numeric_limits<double>::infinity();
    const double u = h.x / h.z, v = h.y / h.z;
    return std::abs((cx.x - u * cx.z) * (cy.y - v * cy.z) - (cx.y - v * cx.z) * (cy.x - u * cy.z)) / (h.z * h.z);
}

float splatRadiusOf(const glm::dmat4& c, const SampleBox& box, double scale, int maxRadius) {
    // Circles meet at the corners of a square of neighbours, half its diagonal away.
    constexpr double kHalfDiagonal = 0.7071067811865476;
    // w is affine in (x, y, disparity): at one corner it is least.
    const glm::dvec3 perSample(c[0].z, c[1].z, c[3].z);
    double w = c[2].z;
    for (int axis = 0; axis < 3; ++axis)
        w += std::min(perSample[axis] * box.least[axis], perSample[axis] * box.most[axis]);
    const auto most = static_cast<double>(maxRadius);
    const double spacing = scale * std::sqrt(std::abs(glm::determinant(glm::dmat3(c))));
    const double radius = spacing < w * most ? kHalfDiagonal * spacing / w : most;
    return std::clamp(static_cast<float>(radius), kLeastSplat, std::max(static_cast<float>(most), kLeastSplat));
}

int footprintOf(double sampleWidth, double scale, int maxFootprint) {
    if (maxFootprint <= 1) return 1;
    // A hundredth of a pixel of slack: what is as dense as the screen stays one pixel wide in spite of rounding.
    const double side = std::ceil(scale * sampleWidth - 0.01);
    return static_cast<int>(std::clamp(side, 1.0, static_cast<double>(maxFootprint)));
}

} // namespace scene
