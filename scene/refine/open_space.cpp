#include "scene/refine/open_space.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <tbb/parallel_for.h>

namespace scene {

namespace {

constexpr float kNothing = RayEnd::kNothing;

/// A gap between so many samples that prove something, of the eight about it, is one of sampling: its ray went as far
/// as the nearest of theirs. A sample among fewer, itself counted, proves nothing.
constexpr int kFewAbout = 4;

/// Of the camera's body: half the diagonal of the smallest boxes that are asked whether it stood in parts of them.
constexpr double kBodyShare = 1.0 / 16;

} // namespace

inline OpenSpace::Span OpenSpace::Level::spanOf(int left, int top, int right, int bottom) const {
    float nearest = 0, farthest = kNothing;
    bool hasEdge = false;
    for (int y = top; y <= bottom; ++y) {
        const Span* row = &at(left, y);
        for (int x = 0; x <= right - left; ++x) {
            nearest = std::max(nearest, row[x].nearest);
            farthest = std::min(farthest, row[x].farthest.disparity());
            hasEdge |= row[x].farthest.hasEdge();
        }
    }
    return {nearest, {farthest, hasEdge}};
}

std::size_t OpenSpace::Buffers::bytesOf(const Camera& camera, int margin) {
    const auto samples =
        static_cast<std::size_t>(camera.width + 2 * margin) * static_cast<std::size_t>(camera.height + 2 * margin);
    return samples * (6 * sizeof(End) + 4 * sizeof(Span)) / 3; // coarser levels are a third of the finest
}

OpenSpace::OpenSpace(const DepthImage& image, const Rim* rim, float tolerance, double bodyMetres, Buffers& buffers)
    : camera_(rim ? rim->widened() : image.camera), focal_(std::max(image.camera.fx, image.camera.fy)),
      tolerance_(tolerance), bodyMetres_(bodyMetres), buffers_(buffers) {
    const auto longest = static_cast<unsigned>(std::max(camera_.width, camera_.height));
    buffers_.levels.resize(static_cast<std::size_t>(std::bit_width(longest - 1)) + 1);
    for (std::size_t level = 0; level < buffers_.levels.size(); ++level) {
        Level& of = buffers_.levels[level];
        const auto halved = [&](int size) { return ((size - 1) >> level) + 1; };
        of.width = halved(camera_.width), of.height = halved(camera_.height);
        of.spans.resize(static_cast<std::size_t>(of.width) * static_cast<std::size_t>(of.height));
    }
    buffers_.ends.resize(buffers_.levels[0].spans.size());
    buffers_.closed.resize(buffers_.levels[0].spans.size());
    takeEnds(image, rim);
    closeGaps();
    widenToPatches();
    buildPyramid();
}

void OpenSpace::takeEnds(const DepthImage& image, const Rim* rim) {
    const int margin = rim ? rim->margin() : 0, width = image.camera.width, height = image.camera.height;
    const auto endOf = [&](int x, int y) -> RayEnd {
        if (x < 0 || y < 0 || x >= width || y >= height) return rim->at(x + margin, y + margin);
        RayEnd end = rayEndOf(image, x, y);
        // The last row and column have no square of their own within the image: with others beyond they are no edge.
        if (rim && (x == width - 1 || y == height - 1) && end.provesSomething()) end.isEdge = false;
        return end;
    };
    tbb::parallel_for(0, camera_.height, [&](int y) {
        End* row = buffers_.ends.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(camera_.width);
        for (int x = 0; x < camera_.width; ++x) {
            const RayEnd end = endOf(x - margin, y - margin);
            row[x] = {end.disparity, end.isEdge};
        }
    });
}

void OpenSpace::closeGaps() {
    const int width = camera_.width, height = camera_.height;
    const auto indexOf = [&](int x, int y) {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
    };
    tbb::parallel_for(0, height, [&](int y) {
        for (int x = 0; x < width; ++x) {
            int proving = 0;
            float nearest = 0;
            for (int ny = std::max(y - 1, 0); ny <= std::min(y + 1, height - 1); ++ny)
                for (int nx = std::max(x - 1, 0); nx <= std::min(x + 1, width - 1); ++nx) {
                    const float end = buffers_.ends[indexOf(nx, ny)].disparity();
                    if (!(end < kNothing)) continue;
                    ++proving;
                    nearest = std::max(nearest, end);
                }
            End end = buffers_.ends[indexOf(x, y)];
            const bool proves = end.disparity() < kNothing;
            if (!proves && proving >= kFewAbout) end = {nearest, true};
            if (proves && proving < kFewAbout) end = {kNothing, true};
            buffers_.closed[indexOf(x, y)] = end;
        }
    });
}

void OpenSpace::widenToPatches() {
    const int width = camera_.width, height = camera_.height;
    const auto indexOf = [&](int x, int y) {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
    };
    const auto at = [&](int x, int y) { return buffers_.closed[indexOf(x, y)]; };
    // Between neighbours that a square without a silhouette joins, half of what lies between them is this sample's.
    const auto isJoined = [&](int x, int y, int alongX) {
        if (x < 0 || y < 0 || x + alongX >= width || y + 1 - alongX >= height) return false;
        const int before = alongX == 1 ? y - 1 : x - 1;
        return !at(x, y).hasEdge() || (before >= 0 && !(alongX == 1 ? at(x, before) : at(before, y)).hasEdge());
    };
    tbb::parallel_for(0, height, [&](int y) {
        for (int x = 0; x < width; ++x) {
            Span& patch = buffers_.levels[0].spans[indexOf(x, y)];
            const End end = at(x, y);
            const float own = end.disparity();
            patch = {own, end};
            if (!(own < kNothing)) continue;
            float reach = 0;
            for (const int alongX : {0, 1}) {
                float steps = 0;
                for (const int back : {0, 1}) {
                    const int px = x - back * alongX, py = y - back * (1 - alongX);
                    if (!isJoined(px, py, alongX)) continue;
                    const float other = (back == 1 ? at(px, py) : at(x + alongX, y + 1 - alongX)).disparity();
                    if (other < kNothing) steps = std::max(steps, std::abs(other - own));
                }
                reach += steps / 2;
            }
            patch = {own + reach, {std::max(own - reach, 0.0f), end.hasEdge()}};
        }
    });
}

void OpenSpace::buildPyramid() {
    for (std::size_t level = 1; level < buffers_.levels.size(); ++level) {
        const Level& fine = buffers_.levels[level - 1];
        Level& coarse = buffers_.levels[level];
        tbb::parallel_for(0, coarse.height, [&](int y) {
            for (int x = 0; x < coarse.width; ++x)
                coarse.spans[static_cast<std::size_t>(y) * static_cast<std::size_t>(coarse.width) +
                             static_cast<std::size_t>(x)] =
                    fine.spanOf(2 * x, 2 * y, std::min(2 * x + 1, fine.width - 1),
                                std::min(2 * y + 1, fine.height - 1));
        });
    }
}

OpenSpace::Rectangle OpenSpace::rectangleOf(const BoxInCamera& box, double overNear, double overFar) const {
    const auto lowest = [&](double p) { return p * (p < 0 ? overNear : overFar); };
    const auto highest = [&](double p) { return p * (p > 0 ? overNear : overFar); };
    const double left = camera_.fx * lowest(box.centre.x - box.half.x) + camera_.cx;
    const double right = camera_.fx * highest(box.centre.x + box.half.x) + camera_.cx;
    const double top = camera_.fy * lowest(box.centre.y - box.half.y) + camera_.cy;
    const double bottom = camera_.fy * highest(box.centre.y + box.half.y) + camera_.cy;
    if (right <= 0 || bottom <= 0 || left >= camera_.width || top >= camera_.height) return {};
    return {static_cast<int>(std::max(left, 0.0)), static_cast<int>(std::max(top, 0.0)),
            static_cast<int>(std::min(right, camera_.width - 1.0)),
            static_cast<int>(std::min(bottom, camera_.height - 1.0)),
            left >= 0 && top >= 0 && right <= camera_.width && bottom <= camera_.height};
}

bool OpenSpace::holdsSample(const BoxInCamera& box) const {
    const double zNear = box.centre.z - box.half.z, zFar = box.centre.z + box.half.z;
    if (zNear <= 0) return false;
    const double overNear = 1 / zNear, overFar = 1 / zFar;
    const Rectangle in = rectangleOf(box, overNear, overFar);
    if (in.isEmpty()) return false;
    const auto boxNear = static_cast<float>(overNear), boxFar = static_cast<float>(overFar);
    const std::size_t level = levelOf(in);
    for (int y = in.top >> level; y <= in.bottom >> level; ++y)
        for (int x = in.left >> level; x <= in.right >> level; ++x)
            if (holdsSampleBelow(in, level, x, y, boxNear, boxFar)) return true;
    return false;
}

bool OpenSpace::holdsSampleBelow(const Rectangle& in, std::size_t level, int x, int y, float boxNear,
                                 float boxFar) const {
    const Span& span = buffers_.levels[level].at(x, y);
    if (!(span.nearest > 0 && span.nearest >= boxFar && span.farthest.disparity() <= boxNear))
        return false; // none of it does
    if (level == 0) return span.nearest < kNothing;
    const std::size_t finer = level - 1;
    for (int fy = std::max(2 * y, in.top >> finer); fy <= std::min(2 * y + 1, in.bottom >> finer); ++fy)
        for (int fx = std::max(2 * x, in.left >> finer); fx <= std::min(2 * x + 1, in.right >> finer); ++fx)
            if (holdsSampleBelow(in, finer, fx, fy, boxNear, boxFar)) return true;
    return false;
}

std::size_t OpenSpace::levelOf(const Rectangle& in) {
    std::size_t level = 0;
    while ((in.right >> level) - (in.left >> level) > 2 || (in.bottom >> level) - (in.top >> level) > 2)
        ++level;
    return level;
}

BoxSight OpenSpace::look(const BoxInCamera& box) const {
    if (bodyMetres_ > 0 && glm::length(glm::abs(box.centre) + box.half) <= bodyMetres_) return {Sight::all, false};
    BoxSight sight = lookPastBody(box);
    const bool isInReach = glm::length(glm::max(glm::abs(box.centre) - box.half, glm::dvec3(0))) < bodyMetres_;
    // The body's rim is nothing that anybody saw: no cell is divided for it below a share of its size.
    const bool isLarge = glm::length(box.half) > kBodyShare * bodyMetres_;
    if (sight.sight == Sight::none && isInReach && isLarge) sight = {Sight::part, true};
    return sight;
}

BoxSight OpenSpace::lookPastBody(const BoxInCamera& box) const {
    const double zNear = box.centre.z - box.half.z, zFar = box.centre.z + box.half.z;
    if (zFar <= 0) return {};
    if (zNear <= 0) { // beside the camera, or about it
        const bool isBeside = box.centre.x - box.half.x > zFar * (camera_.width - camera_.cx) / camera_.fx ||
                              box.centre.x + box.half.x < -zFar * camera_.cx / camera_.fx ||
                              box.centre.y - box.half.y > zFar * (camera_.height - camera_.cy) / camera_.fy ||
                              box.centre.y + box.half.y < -zFar * camera_.cy / camera_.fy;
        return isBeside ? BoxSight{} : BoxSight{Sight::part, true};
    }
    const double overNear = 1 / zNear, overFar = 1 / zFar;
    const Rectangle in = rectangleOf(box, overNear, overFar);
    if (in.isEmpty()) return {};
    const std::size_t level = levelOf(in);
    const Level& pyramid = buffers_.levels[level];
    const auto boxNear = static_cast<float>(overNear), boxFar = static_cast<float>(overFar);
    BoxSight sight;
    const Span span = pyramid.spanOf(in.left >> level, in.top >> level, in.right >> level, in.bottom >> level);
    sight.hasEdge = !in.isWhole || span.farthest.hasEdge();
    if (boxNear < span.farthest.disparity() * (1 - tolerance_))
        sight.sight = Sight::none;
    else if (in.isWhole && boxFar > span.nearest)
        sight.sight = Sight::all;
    else
        sight.sight = Sight::part;
    return sight;
}

} // namespace scene
