#include "scene/refine/open_space.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace scene {

namespace {

constexpr float kNothing = std::numeric_limits<float>::infinity();
constexpr int kMarginShare = 8; ///< of the image's width that companions continue it by: one part in so many

int marginOf(const Camera& camera) {
    return std::max(camera.width / kMarginShare, 2);
}

/// A gap between so many samples that prove something, of the eight about it, is one of sampling: its ray went as far
/// as the nearest of theirs. A sample among fewer, itself counted, proves nothing.
constexpr int kFewAbout = 4;

/// The disparity at which a sample's ray ends, infinite if it proves nothing.
float openEndOf(const DepthImage& image, int x, int y) {
    return isDrawable(image.flags(x, y)) ? image.disparity(x, y) : kNothing;
}

bool isEdge(const DepthImage& image, int x, int y) {
    const int right = x + 1, below = y + 1;
    if (right >= image.camera.width || below >= image.camera.height) return true;
    return (image.flags(x, y) & (kSkinUpper | kSkinLower)) != 0 || !isSurface(image.flags(x, y)) ||
           !isSurface(image.flags(right, y)) || !isSurface(image.flags(x, below)) ||
           !isSurface(image.flags(right, below));
}

} // namespace

OpenSpace::OpenSpace(const DepthImage& image, std::size_t companions, const Companion& companion, float tolerance)
    : camera_(image.camera), focal_(std::max(image.camera.fx, image.camera.fy)), tolerance_(tolerance) {
    const int margin = companions == 0 ? 0 : marginOf(image.camera);
    camera_.width += 2 * margin, camera_.height += 2 * margin;
    camera_.cx += margin, camera_.cy += margin;
    levels_.push_back({camera_.width, camera_.height, {}});
    levels_[0].spans.assign(static_cast<std::size_t>(camera_.width) * static_cast<std::size_t>(camera_.height),
                            {kNothing, kNothing, true});
    for (int y = 0; y < image.camera.height; ++y)
        for (int x = 0; x < image.camera.width; ++x) {
            const float end = openEndOf(image, x, y);
            levels_[0].spans[static_cast<std::size_t>(y + margin) * static_cast<std::size_t>(camera_.width) +
                             static_cast<std::size_t>(x + margin)] = {end, end, isEdge(image, x, y)};
        }
    if (margin > 0) continueRim(margin);
    for (std::size_t i = 0; i < companions; ++i)
        continuePast(image, companion(i), margin);
    closeGaps();
    widenToPatches();
    buildPyramid();
}

bool OpenSpace::mayContinue(const Camera& camera, const glm::dmat3& worldFromCamera, const Camera& companion,
                            const glm::dmat3& worldFromCompanion) {
    if (camera == companion && worldFromCamera == worldFromCompanion) return false;
    const int margin = marginOf(camera);
    const double right = std::max(camera.width + margin - camera.cx, camera.cx + margin) / camera.fx,
                 down = std::max(camera.height + margin - camera.cy, camera.cy + margin) / camera.fy;
    // Of rays of depth 1, the most along the companion's axis.
    const glm::dvec3 along = glm::transpose(worldFromCamera) * worldFromCompanion[2];
    return right * std::abs(along.x) + down * std::abs(along.y) + along.z > 0;
}

/// The last row and column have no square of their own within the image: with others beyond them they are no edge.
void OpenSpace::continueRim(int margin) {
    const int right = camera_.width - margin - 1, bottom = camera_.height - margin - 1;
    for (int y = margin; y <= bottom; ++y)
        for (int x = y == bottom ? margin : right; x <= right; ++x) {
            Span& span = levels_[0].spans[static_cast<std::size_t>(y) * static_cast<std::size_t>(camera_.width) +
                                          static_cast<std::size_t>(x)];
            if (span.nearest < kNothing) span.hasEdge = false;
        }
}

void OpenSpace::continuePast(const DepthImage& image, const DepthImage& companion, int margin) {
    for (int y = 0; y < camera_.height; ++y)
        for (int x = 0; x < camera_.width; ++x) {
            if (x >= margin && y >= margin && x < camera_.width - margin && y < camera_.height - margin) continue;
            Span& span = levels_[0].spans[static_cast<std::size_t>(y) * static_cast<std::size_t>(camera_.width) +
                                          static_cast<std::size_t>(x)];
            if (span.nearest < kNothing) continue; // a companion before this one saw it
            const glm::dvec3 ray = rayThrough(camera_, x + 0.5, y + 0.5);
            const glm::dvec3 inWorld = image.worldFromCamera.rotation * ray;
            const glm::dvec3 there = glm::transpose(companion.worldFromCamera.rotation) * inWorld;
            if (there.z <= 0) continue;
            const glm::dvec2 at = project(companion.camera, there);
            const Camera& other = companion.camera;
            if (!(at.x >= 0 && at.y >= 0 && at.x < other.width && at.y < other.height)) continue;
            const int ox = static_cast<int>(at.x), oy = static_cast<int>(at.y);
            const float end = openEndOf(companion, ox, oy);
            if (!(end < kNothing)) continue;
            // Depths of one point along two axes are as the ray's lengths along them.
            const auto here = static_cast<float>(end * there.z);
            const bool isBorder = ox + 1 >= other.width || oy + 1 >= other.height;
            span = {here, here, !isBorder && isEdge(companion, ox, oy)};
        }
}

void OpenSpace::closeGaps() {
    const Level& raw = levels_[0];
    std::vector<Span> closed = raw.spans;
    for (int y = 0; y < raw.height; ++y)
        for (int x = 0; x < raw.width; ++x) {
            int proving = 0;
            float nearest = 0;
            for (int ny = std::max(y - 1, 0); ny <= std::min(y + 1, raw.height - 1); ++ny)
                for (int nx = std::max(x - 1, 0); nx <= std::min(x + 1, raw.width - 1); ++nx) {
                    const float end = raw.spans[static_cast<std::size_t>(ny) * static_cast<std::size_t>(raw.width) +
                                                static_cast<std::size_t>(nx)]
                                          .nearest;
                    if (!(end < kNothing)) continue;
                    ++proving;
                    nearest = std::max(nearest, end);
                }
            Span& span =
                closed[static_cast<std::size_t>(y) * static_cast<std::size_t>(raw.width) + static_cast<std::size_t>(x)];
            const bool proves = span.nearest < kNothing;
            if (!proves && proving >= kFewAbout) span = {nearest, nearest, true};
            if (proves && proving < kFewAbout) span = {kNothing, kNothing, true};
        }
    levels_[0].spans = std::move(closed);
}

void OpenSpace::widenToPatches() {
    const Level& raw = levels_[0];
    std::vector<Span> patches = raw.spans;
    const auto at = [&](int x, int y) -> const Span& {
        return raw
            .spans[static_cast<std::size_t>(y) * static_cast<std::size_t>(raw.width) + static_cast<std::size_t>(x)];
    };
    // Between neighbours that a square without a silhouette joins, half of what lies between them is this sample's.
    const auto isJoined = [&](int x, int y, int alongX) {
        if (x < 0 || y < 0 || x + alongX >= raw.width || y + 1 - alongX >= raw.height) return false;
        const int before = alongX == 1 ? y - 1 : x - 1;
        return !at(x, y).hasEdge || (before >= 0 && !(alongX == 1 ? at(x, before) : at(before, y)).hasEdge);
    };
    for (int y = 0; y < raw.height; ++y)
        for (int x = 0; x < raw.width; ++x) {
            const float own = at(x, y).nearest;
            if (!(own < kNothing)) continue;
            float reach = 0;
            for (const int alongX : {0, 1}) {
                float steps = 0;
                for (const int back : {0, 1}) {
                    const int px = x - back * alongX, py = y - back * (1 - alongX);
                    if (!isJoined(px, py, alongX)) continue;
                    const float other = (back == 1 ? at(px, py) : at(x + alongX, y + 1 - alongX)).nearest;
                    if (other < kNothing) steps = std::max(steps, std::abs(other - own));
                }
                reach += steps / 2;
            }
            Span& patch = patches[static_cast<std::size_t>(y) * static_cast<std::size_t>(raw.width) +
                                  static_cast<std::size_t>(x)];
            patch.nearest = own + reach, patch.farthest = std::max(own - reach, 0.0f);
        }
    levels_[0].spans = std::move(patches);
}

void OpenSpace::buildPyramid() {
    while (levels_.back().width > 1 || levels_.back().height > 1) {
        const Level& fine = levels_.back();
        Level coarse{(fine.width + 1) / 2, (fine.height + 1) / 2, {}};
        coarse.spans.reserve(static_cast<std::size_t>(coarse.width) * static_cast<std::size_t>(coarse.height));
        for (int y = 0; y < coarse.height; ++y)
            for (int x = 0; x < coarse.width; ++x) {
                Span span{0, kNothing, false};
                for (int fy = 2 * y; fy < std::min(2 * y + 2, fine.height); ++fy)
                    for (int fx = 2 * x; fx < std::min(2 * x + 2, fine.width); ++fx) {
                        const Span& of =
                            fine.spans[static_cast<std::size_t>(fy) * static_cast<std::size_t>(fine.width) +
                                       static_cast<std::size_t>(fx)];
                        span.nearest = std::max(span.nearest, of.nearest);
                        span.farthest = std::min(span.farthest, of.farthest);
                        span.hasEdge = span.hasEdge || of.hasEdge;
                    }
                coarse.spans.push_back(span);
            }
        levels_.push_back(std::move(coarse));
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
    const auto boxNear = static_cast<float>(overNear), boxFar = static_cast<float>(overFar);
    for (int y = in.top; y <= in.bottom; ++y)
        for (int x = in.left; x <= in.right; ++x) {
            const Span& patch = levels_[0].spans[static_cast<std::size_t>(y) * static_cast<std::size_t>(camera_.width) +
                                                 static_cast<std::size_t>(x)];
            if (patch.nearest > 0 && patch.nearest < kNothing && patch.nearest >= boxFar && patch.farthest <= boxNear)
                return true;
        }
    return false;
}

BoxSight OpenSpace::look(const BoxInCamera& box) const {
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
    int x0 = in.left, y0 = in.top, x1 = in.right, y1 = in.bottom;
    std::size_t level = 0;
    while (x1 - x0 > 2 || y1 - y0 > 2)
        x0 >>= 1, x1 >>= 1, y0 >>= 1, y1 >>= 1, ++level;

    const Level& pyramid = levels_[level];
    const auto boxNear = static_cast<float>(overNear), boxFar = static_cast<float>(overFar);
    BoxSight sight;
    Span span{0, kNothing, !in.isWhole};
    for (int y = y0; y <= y1; ++y)
        for (int x = x0; x <= x1; ++x) {
            const Span& of = pyramid.spans[static_cast<std::size_t>(y) * static_cast<std::size_t>(pyramid.width) +
                                           static_cast<std::size_t>(x)];
            span.nearest = std::max(span.nearest, of.nearest);
            span.farthest = std::min(span.farthest, of.farthest);
            span.hasEdge = span.hasEdge || of.hasEdge;
        }
    sight.hasEdge = span.hasEdge;
    if (boxNear < span.farthest * (1 - tolerance_))
        sight.sight = Sight::none;
    else if (in.isWhole && boxFar > span.nearest)
        sight.sight = Sight::all;
    else
        sight.sight = Sight::part;
    return sight;
}

} // namespace scene
