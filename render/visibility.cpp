#include "render/visibility.h"

#include "scene/footprint.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace render {

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

void cull(const TileBounds& bounds, std::span<const TilePiece> pieces, std::span<const ImagePlanes> planesOfImages,
          VisibleTiles& visible) {
    visible.slots.resize(bounds.size());
    visible.counts.resize(pieces.size());
    tbb::parallel_for(std::size_t{0}, pieces.size(), [&](std::size_t i) {
        const TilePiece& piece = pieces[i];
        visible.counts[i] = 0;
        if (planesOfImages[piece.image].isOut) return;
        visible.counts[i] = static_cast<std::uint32_t>(findVisible(
            bounds, piece.first, piece.count, planesOfImages[piece.image], visible.slots.data() + piece.first));
    });
}

} // namespace render
