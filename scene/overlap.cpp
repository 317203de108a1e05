#include "scene/overlap.h"

#include "scene/reprojection.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <tbb/parallel_for.h>

namespace scene {

namespace {

constexpr int kOutlineColumns = 24, kOutlineRows = 18;
/// The outlines are coarse: surfaces within this relative difference of disparity may well be the same.
constexpr float kRoughlySame = 0.3f;
/// Bounds are drawn wider by this share of the range: a wall along an axis has none of its own, and registration is
/// off.
constexpr double kSlack = 0.02;

struct WorldBox {
    glm::dvec3 lowest{std::numeric_limits<double>::max()}, highest{std::numeric_limits<double>::lowest()};
    bool meets(const WorldBox& other) const {
        for (int axis = 0; axis < 3; ++axis)
            if (lowest[axis] > other.highest[axis] || highest[axis] < other.lowest[axis]) return false;
        return true;
    }
};

int sampleColumn(const ImageOutline& outline, int column) {
    return std::min(outline.camera.width - 1, (2 * column + 1) * outline.camera.width / (2 * outline.columns));
}
int sampleRow(const ImageOutline& outline, int row) {
    return std::min(outline.camera.height - 1, (2 * row + 1) * outline.camera.height / (2 * outline.rows));
}

WorldBox boundsOf(const ImageOutline& outline) {
    WorldBox box;
    for (int row = 0; row < outline.rows; ++row)
        for (int column = 0; column < outline.columns; ++column) {
            const float d = outline.disparity[static_cast<std::size_t>(row * outline.columns + column)];
            if (d <= 0) continue;
            const glm::dvec3 ray =
                rayThrough(outline.camera, sampleColumn(outline, column) + 0.5, sampleRow(outline, row) + 0.5);
            const glm::dvec3 p = outline.worldFromCamera * (ray / static_cast<double>(d));
            const double slack = kSlack * glm::length(ray) / static_cast<double>(d);
            for (int axis = 0; axis < 3; ++axis) {
                box.lowest[axis] = std::min(box.lowest[axis], p[axis] - slack);
                box.highest[axis] = std::max(box.highest[axis], p[axis] + slack);
            }
        }
    return box;
}

float shareSeen(const ImageOutline& source, const ImageOutline& target) {
    const Reprojection into =
        reprojectionInto(target.camera, target.worldFromCamera, source.camera, source.worldFromCamera);
    int seen = 0, all = 0;
    for (int row = 0; row < source.rows; ++row)
        for (int column = 0; column < source.columns; ++column) {
            const float d = source.disparity[static_cast<std::size_t>(row * source.columns + column)];
            if (d <= 0) continue;
            ++all;
            const Sighting at = sightingOf(into, static_cast<float>(sampleColumn(source, column)) + 0.5f,
                                           static_cast<float>(sampleRow(source, row)) + 0.5f, d);
            if (!(at.w > 0) || !(at.u >= 0) || !(at.v >= 0)) continue;
            const float x = at.u * static_cast<float>(target.columns) / static_cast<float>(target.camera.width);
            const float y = at.v * static_cast<float>(target.rows) / static_cast<float>(target.camera.height);
            if (!(x < static_cast<float>(target.columns)) || !(y < static_cast<float>(target.rows))) continue;
            const float there =
                target.disparity[static_cast<std::size_t>(static_cast<int>(y) * target.columns + static_cast<int>(x))];
            if (there > 0 && std::abs(there - at.disparity) <= kRoughlySame * std::max(there, at.disparity)) ++seen;
        }
    return all > 0 ? static_cast<float>(seen) / static_cast<float>(all) : 0.f;
}

} // namespace

ImageOutline outlineOf(const DepthImage& image) {
    ImageOutline outline{image.camera,
                         image.worldFromCamera,
                         std::min(kOutlineColumns, image.camera.width),
                         std::min(kOutlineRows, image.camera.height),
                         {}};
    for (int row = 0; row < outline.rows; ++row)
        for (int column = 0; column < outline.columns; ++column) {
            // Sparse depth: the first sample found near the place stands for it.
            const int x0 = sampleColumn(outline, column), y0 = sampleRow(outline, row);
            float found = 0;
            for (int y = y0; y < std::min(y0 + 4, image.camera.height) && found == 0; ++y)
                for (int x = x0; x < std::min(x0 + 4, image.camera.width) && found == 0; ++x)
                    if (isSurface(image.flags(x, y))) found = image.disparity(x, y);
            outline.disparity.push_back(found);
        }
    return outline;
}

std::vector<std::vector<Partner>> findPartners(const std::vector<ImageOutline>& outlines, float minShare) {
    const std::size_t count = outlines.size();
    std::vector<WorldBox> boxes(count);
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) { boxes[i] = boundsOf(outlines[i]); });

    // Sweep along the axis on which the capture is longest: only boxes that meet there are looked at.
    WorldBox all;
    for (const WorldBox& box : boxes) {
        all.lowest = glm::min(all.lowest, box.lowest);
        all.highest = glm::max(all.highest, box.highest);
    }
    const glm::dvec3 extent = all.highest - all.lowest;
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    std::vector<std::uint32_t> byStart(count);
    std::iota(byStart.begin(), byStart.end(), 0u);
    std::stable_sort(byStart.begin(), byStart.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return boxes[a].lowest[axis] < boxes[b].lowest[axis]; });

    std::vector<std::vector<std::uint32_t>> meeting(count);
    for (std::size_t i = 0; i < count; ++i)
        for (std::size_t j = i + 1; j < count && boxes[byStart[j]].lowest[axis] <= boxes[byStart[i]].highest[axis]; ++j)
            if (boxes[byStart[i]].meets(boxes[byStart[j]])) {
                meeting[byStart[i]].push_back(byStart[j]);
                meeting[byStart[j]].push_back(byStart[i]);
            }

    std::vector<std::vector<Partner>> partners(count);
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
        for (const std::uint32_t other : meeting[i]) {
            const float share =
                std::max(shareSeen(outlines[i], outlines[other]), shareSeen(outlines[other], outlines[i]));
            if (share >= minShare) partners[i].push_back({other, share});
        }
        std::sort(partners[i].begin(), partners[i].end(), [](const Partner& a, const Partner& b) {
            return a.share != b.share ? a.share > b.share : a.image < b.image;
        });
    });
    return partners;
}

} // namespace scene
