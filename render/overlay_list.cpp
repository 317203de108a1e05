#include "render/overlay_list.h"

#include "render/glyphs.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace render {

namespace {

/// Pixels: nothing is drawn wider or higher.
constexpr double kWidestStroke = 4096;

/// A point on the screen.
struct Seen {
    glm::dvec2 place{0};  ///< pixels
    double disparity = 0; ///< 1/m
};

Seen mix(const Seen& a, const Seen& b, double t) {
    return {glm::mix(a.place, b.place, t), glm::mix(a.disparity, b.disparity, t)};
}

bool isFinite(const glm::dvec3& p) {
    return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

/// The positions are subtracted first: exact where they are near each other, however far the world's origin is.
glm::dvec3 inEye(const scene::View& eye, const glm::dvec3& pInWorld) {
    return glm::transpose(eye.worldFromEye.rotation) * (pInWorld - eye.worldFromEye.translation);
}

Seen seenFrom(const scene::Camera& camera, const glm::dvec3& pInEye) {
    return {scene::project(camera, pInEye), 1 / pInEye.z};
}

std::uint32_t packColour(const scene::Rgb8& colour, double opacity) {
    const auto byte = static_cast<std::uint32_t>(std::lround(255 * std::clamp(opacity, 0.0, 1.0)));
    return static_cast<std::uint32_t>(colour.r) | static_cast<std::uint32_t>(colour.g) << 8 |
           static_cast<std::uint32_t>(colour.b) << 16 | byte << 24;
}

/// How a stroke looks.
struct Ink {
    double halfWidth = 1; ///< pixels
    double whenHidden = 0;
    std::uint32_t colour = 0;
};

/// Strokes go into a list that has room for so many.
class StrokeList {
  public:
    StrokeList(const scene::Camera& camera, OverlayList& list) : camera_(camera), list_(list) {}

    /// Cuts off what is beyond the picture: far outside, single precision has no fractions of a pixel left.
    void add(Seen a, Seen b, const Ink& ink) {
        const double margin = ink.halfWidth + 1;
        double from = 0, to = 1;
        const glm::dvec2 along = b.place - a.place;
        if (!std::isfinite(along.x + along.y + a.place.x + a.place.y)) return drop();
        const glm::dvec2 size(camera_.width, camera_.height);
        for (int axis = 0; axis < 2; ++axis) {
            const double low = -margin - a.place[axis], high = size[axis] + margin - a.place[axis];
            if (along[axis] == 0) {
                if (low > 0 || high < 0) return;
                continue;
            }
            const double tLow = low / along[axis], tHigh = high / along[axis];
            from = std::max(from, std::min(tLow, tHigh)), to = std::min(to, std::max(tLow, tHigh));
        }
        if (!(from <= to)) return;
        const Seen first = mix(a, b, from), last = mix(a, b, to);
        OverlayStroke stroke{};
        stroke.a = first.place, stroke.b = last.place;
        stroke.disparities = {static_cast<float>(first.disparity), static_cast<float>(last.disparity)};
        stroke.halfWidth = static_cast<float>(ink.halfWidth);
        stroke.whenHidden = static_cast<float>(std::clamp(ink.whenHidden, 0.0, 1.0));
        stroke.colour = ink.colour;
        touchBins(stroke);
    }

    void drop() { ++list_.dropped; }

  private:
    /// Row by row of bins: where the part of the stroke that is near the row lies.
    void touchBins(const OverlayStroke& stroke) {
        const std::size_t touchesBefore = list_.touches.size();
        const auto index = static_cast<std::uint32_t>(list_.strokes.size());
        const glm::dvec2 a(stroke.a), b(stroke.b);
        const double reach = static_cast<double>(stroke.halfWidth) + 1;
        const int columns = static_cast<int>(binsAlong(camera_.width));
        const int rows = static_cast<int>(binsAlong(camera_.height));
        const auto binOf = [](double pixel) { return static_cast<int>(std::floor(pixel / kBinSide)); };
        const int firstRow = std::max(binOf(std::min(a.y, b.y) - reach), 0);
        const int lastRow = std::min(binOf(std::max(a.y, b.y) + reach), rows - 1);
        for (int row = firstRow; row <= lastRow; ++row) {
            double from = 0, to = 1;
            if (a.y != b.y) {
                const double top = (row * static_cast<double>(kBinSide) - reach - a.y) / (b.y - a.y);
                const double bottom = ((row + 1) * static_cast<double>(kBinSide) + reach - a.y) / (b.y - a.y);
                from = std::clamp(std::min(top, bottom), 0.0, 1.0), to = std::clamp(std::max(top, bottom), 0.0, 1.0);
            }
            const double x0 = glm::mix(a.x, b.x, from), x1 = glm::mix(a.x, b.x, to);
            const int first = std::max(binOf(std::min(x0, x1) - reach), 0);
            const int last = std::min(binOf(std::max(x0, x1) + reach), columns - 1);
            for (int column = first; column <= last; ++column)
                list_.touches.push_back({static_cast<std::uint32_t>(row * columns + column), index,
                                         disparityNear(stroke, (glm::dvec2(column, row) + 0.5) * double(kBinSide))});
        }
        if (list_.strokes.size() == kMaxStrokes || list_.touches.size() > kMaxEntries) {
            list_.touches.resize(touchesBefore);
            drop();
        } else if (list_.touches.size() > touchesBefore) {
            list_.strokes.push_back(stroke);
        }
    }

    static float disparityNear(const OverlayStroke& stroke, const glm::dvec2& place) {
        const glm::dvec2 a(stroke.a), along = glm::dvec2(stroke.b) - a;
        const double length2 = glm::dot(along, along);
        const double t = length2 > 0 ? std::clamp(glm::dot(place - a, along) / length2, 0.0, 1.0) : 0.0;
        return glm::mix(stroke.disparities.x, stroke.disparities.y, static_cast<float>(t));
    }

    const scene::Camera& camera_;
    OverlayList& list_;
};

void addSegment(const Segment& segment, const scene::View& eye, double scale, StrokeList& strokes) {
    glm::dvec3 a = inEye(eye, segment.a), b = inEye(eye, segment.b);
    if (!isFinite(a) || !isFinite(b) || !(segment.widthPixels > 0) || segment.widthPixels > kWidestStroke)
        return strokes.drop();
    if (a.z < kOverlayNearMetres && b.z < kOverlayNearMetres) return;
    const auto cutAtNear = [](const glm::dvec3& hidden, const glm::dvec3& seen) {
        glm::dvec3 cut = glm::mix(hidden, seen, (kOverlayNearMetres - hidden.z) / (seen.z - hidden.z));
        cut.z = kOverlayNearMetres;
        return cut;
    };
    if (a.z < kOverlayNearMetres) a = cutAtNear(a, b);
    if (b.z < kOverlayNearMetres) b = cutAtNear(b, a);
    strokes.add(seenFrom(eye.camera, a), seenFrom(eye.camera, b),
                {scale * static_cast<double>(segment.widthPixels) / 2, static_cast<double>(segment.whenHidden),
                 packColour(segment.colour, static_cast<double>(segment.opacity))});
}

void addLabel(const Label& label, const scene::View& eye, double scale, StrokeList& strokes) {
    const glm::dvec3 at = inEye(eye, label.at);
    const double height = label.heightPixels > 0 ? scale * static_cast<double>(label.heightPixels)
                                                 : eye.camera.fy * static_cast<double>(label.heightRadians);
    if (!isFinite(at) || !(height > 0) || height > kWidestStroke) return strokes.drop();
    if (at.z < kOverlayNearMetres || label.text.empty()) return;
    const Seen anchor = seenFrom(eye.camera, at);
    const double unit = height / kGlyphHeight;
    const double width =
        (static_cast<double>(label.text.size()) * kGlyphAdvance - (kGlyphAdvance - kGlyphWidth)) * unit;
    // The text stands a line's height above its point.
    const glm::dvec2 topLeft = anchor.place + glm::dvec2(-width / 2, -2 * height);
    const auto seen = [&](const glm::dvec2& offset) { return Seen{topLeft + offset, anchor.disparity}; };

    // A dark ground behind the letters: they are read before any wall.
    const double hidden = static_cast<double>(label.whenHidden);
    strokes.add(seen({0, height / 2}), seen({width, height / 2}),
                {0.9 * height, hidden, packColour(scene::Rgb8{16, 16, 20}, 0.6)});
    const Ink ink{std::max(0.075 * height, 0.5), hidden, packColour(label.colour, 1)};
    double left = 0;
    for (const char letter : label.text) {
        for (const GlyphStroke& stroke : strokesOf(letter))
            strokes.add(seen(glm::dvec2(left, 0) + unit * glm::dvec2(stroke.a)),
                        seen(glm::dvec2(left, 0) + unit * glm::dvec2(stroke.b)), ink);
        left += kGlyphAdvance * unit;
    }
}

/// The ellipse stands around the direction straight ahead and is the same for both eyes, whose pictures reach farther
/// to their outer sides.
OverlayConstants constantsOf(const scene::Camera& camera, float vignette) {
    constexpr float kNone = 1e9f;
    // From beyond the corners to a third of the way to the edges.
    constexpr float kOuter = 1.42f, kInner = 0.3f;
    const float strength = vignette > 0 ? std::min(vignette, 1.f) : 0.f;
    OverlayConstants constants{};
    constants.width = camera.width, constants.height = camera.height;
    constants.clear = strength > 0 ? kOuter + strength * (kInner - kOuter) : kNone;
    constants.centre = glm::dvec2(camera.cx, camera.cy);
    constants.perRadius =
        1.0 / glm::dvec2(std::max(camera.cx, camera.width - camera.cx), std::max(camera.cy, camera.height - camera.cy));
    return constants;
}

/// Whether the rim's darkness reaches any pixel of a bin.
bool isInRim(const OverlayConstants& constants, std::uint32_t column, std::uint32_t row) {
    const glm::vec2 first = glm::vec2(column, row) * static_cast<float>(kBinSide), last = first + float(kBinSide);
    const glm::vec2 farthest = glm::max(glm::abs(first - constants.centre), glm::abs(last - constants.centre));
    return glm::length(farthest * constants.perRadius) > constants.clear;
}

/// Touches to entries, bin by bin.
void fillBins(OverlayList& list) {
    const std::uint32_t columns = binsAlong(list.constants.width), rows = binsAlong(list.constants.height);
    list.firstOfBin.assign(std::size_t{columns} * rows + 1, 0);
    for (const OverlayList::Touch& touch : list.touches)
        ++list.firstOfBin[touch.bin + 1];
    for (std::size_t i = 1; i < list.firstOfBin.size(); ++i)
        list.firstOfBin[i] += list.firstOfBin[i - 1];
    std::sort(list.touches.begin(), list.touches.end(), [](const OverlayList::Touch& a, const OverlayList::Touch& b) {
        if (a.bin != b.bin) return a.bin < b.bin;
        return a.disparity != b.disparity ? a.disparity < b.disparity : a.stroke < b.stroke;
    });
    for (const OverlayList::Touch& touch : list.touches)
        list.entries.push_back(touch.stroke);
    for (std::uint32_t row = 0; row < rows; ++row)
        for (std::uint32_t column = 0; column < columns; ++column) {
            const std::uint32_t bin = row * columns + column;
            const std::uint32_t first = list.firstOfBin[bin], count = list.firstOfBin[bin + 1] - first;
            if (count > 0 || isInRim(list.constants, column, row))
                list.bins.push_back({column | row << 16, first, count, 0});
        }
}

} // namespace

void listOverlay(const Overlay& overlay, const scene::View& eye, OverlayList& list, double scale) {
    list.strokes.clear(), list.entries.clear(), list.bins.clear(), list.touches.clear();
    list.dropped = 0;
    list.constants = constantsOf(eye.camera, overlay.vignette);
    StrokeList strokes(eye.camera, list);
    for (const Segment& segment : overlay.segments)
        addSegment(segment, eye, scale, strokes);
    for (const Label& label : overlay.labels)
        addLabel(label, eye, scale, strokes);
    fillBins(list);
}

} // namespace render
