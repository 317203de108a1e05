#include "render/visibility.h"

#include "scene/footprint.h"

#include <glm/common.hpp>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace render {

namespace {

/// As its tiles are tested, all together: planes are moved out by more than is lost in single precision.
bool isOutside(const scene::SampleBox& box, const ImagePlanes& planes) {
    return std::any_of(planes.inside.begin(), planes.inside.end(), [&](const glm::vec4& plane) {
        const glm::dvec4 p(plane);
        return std::max(p.x * box.least.x, p.x * box.most.x) + std::max(p.y * box.least.y, p.y * box.most.y) + p.z +
                   std::max(p.w * box.least.z, p.w * box.most.z) <
               0;
    });
}

} // namespace

void TileBounds::append(const scene::Tile& tile, const scene::Camera& camera) {
    const scene::SampleBox box = scene::boxOf(tile, camera);
    xMin.push_back(static_cast<float>(box.least.x));
    xMax.push_back(static_cast<float>(box.most.x));
    yMin.push_back(static_cast<float>(box.least.y));
    yMax.push_back(static_cast<float>(box.most.y));
    dMin.push_back(tile.minDisparity);
    dMax.push_back(tile.maxDisparity);
}

BoundsExtent TileBounds::extentOf(std::size_t first, std::size_t count) const {
    BoundsExtent extent;
    for (std::size_t i = first; i < first + count; ++i) {
        extent.x = std::max(extent.x, xMax[i]);
        extent.y = std::max(extent.y, yMax[i]);
        extent.disparity = std::max(extent.disparity, dMax[i]);
    }
    return extent;
}

scene::SampleBox TileBounds::boxAround(std::size_t first, std::size_t count) const {
    scene::SampleBox box{glm::dvec3(std::numeric_limits<double>::infinity()),
                         glm::dvec3(-std::numeric_limits<double>::infinity())};
    for (std::size_t i = first; i < first + count; ++i) {
        box.least = glm::min(box.least, glm::dvec3(xMin[i], yMin[i], dMin[i]));
        box.most = glm::max(box.most, glm::dvec3(xMax[i], yMax[i], dMax[i]));
    }
    return box;
}

ImagePlanes planesOf(const glm::dmat4& eyeImageFromSource, int width, int height, double marginPixels,
                     const BoundsExtent& extent) {
    const auto row = [&](int i) {
        return glm::dvec4(eyeImageFromSource[0][i], eyeImageFromSource[1][i], eyeImageFromSource[2][i],
                          eyeImageFromSource[3][i]);
    };
    const glm::dvec4 u = row(0), v = row(1), w = row(2);
    const std::array<glm::dvec4, 5> exact{u + marginPixels * w, (width + marginPixels) * w - u, v + marginPixels * w,
                                          (height + marginPixels) * w - v, w};
    ImagePlanes planes;
    for (std::size_t i = 0; i < exact.size(); ++i) {
        const glm::dvec4& p = exact[i];
        // Four coefficients and three products and sums, each rounded to 2^-24 of at most this sum; twice
        // that for safety.
        const double magnitude =
            std::abs(p.x) * extent.x + std::abs(p.y) * extent.y + std::abs(p.z) + std::abs(p.w) * extent.disparity;
        planes.inside[i] = glm::vec4(glm::dvec4(p.x, p.y, p.z + magnitude * 16 * 0x1p-24, p.w));
    }
    return planes;
}

std::vector<std::uint32_t> numbersOf(std::span<const TilePiece> pieces) {
    std::vector<std::uint32_t> numbers(pieces.size());
    std::iota(numbers.begin(), numbers.end(), 0u);
    return numbers;
}

void cull(const TileBounds& bounds, std::span<const TilePiece> pieces, const PlanesFor& planesFor,
          VisibleTiles& visible) {
    visible.slots.resize(bounds.size());
    visible.counts.assign(visible.pieces.size(), 0);
    tbb::parallel_for(std::size_t{0}, visible.pieces.size(), [&](std::size_t i) {
        const TilePiece& piece = pieces[visible.pieces[i]];
        const std::optional<ImagePlanes> planes = planesFor(piece);
        if (!planes || isOutside(piece.box, *planes)) return;
        visible.counts[i] = static_cast<std::uint32_t>(
            findVisible(bounds, piece.first, piece.count, *planes, visible.slots.data() + piece.first));
    });
}

} // namespace render
