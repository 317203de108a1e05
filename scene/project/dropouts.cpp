#include "scene/project/dropouts.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <vector>

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

namespace scene {

namespace {

/// Weight of a sample so many pixels off, in one direction: the tent of bilinear support.
float supportOf(int offset, int radius) {
    return static_cast<float>(radius + 1 - std::abs(offset));
}

/// Euclidean, of 255 a channel.
std::size_t squareOfDifference(const Rgb8& a, const Rgb8& b) {
    const int r = a.r - b.r, g = a.g - b.g, blue = a.b - b.b;
    return static_cast<std::size_t>(r * r + g * g + blue * blue);
}

/// How alike colours are, by the square of their difference: there are fewer squares than pairs of pixels.
std::vector<float> likenesses(float colourStep) {
    std::vector<float> table(3 * 255 * 255 + 1);
    for (std::size_t i = 0; i < table.size(); ++i)
        table[i] = std::exp(-std::sqrt(static_cast<float>(i)) / colourStep);
    return table;
}

struct Neighbour {
    int dx, dy;
    float disparity, weight;
};

/// Sums for the plane d = a + b dx + c dy through the members of a cluster, by weighted least squares.
struct PlaneSums {
    double w = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0, d = 0, xd = 0, yd = 0;

    void add(const Neighbour& n) {
        const double weight = n.weight, dx = n.dx, dy = n.dy, disparity = n.disparity;
        w += weight, x += weight * dx, y += weight * dy;
        xx += weight * dx * dx, xy += weight * dx * dy, yy += weight * dy * dy;
        d += weight * disparity, xd += weight * dx * disparity, yd += weight * dy * disparity;
    }

    /// Disparity of the plane at the centre; the weighted mean where the members do not span a plane.
    double atCentre() const {
        const double mx = x / w, my = y / w, md = d / w;
        const double sxx = xx / w - mx * mx, sxy = xy / w - mx * my, syy = yy / w - my * my;
        const double sxd = xd / w - mx * md, syd = yd / w - my * md;
        const double determinant = sxx * syy - sxy * sxy;
        if (determinant < 1e-3 * (sxx + syy) * (sxx + syy) || sxx + syy < 0.25) return md;
        const double b = (sxd * syy - syd * sxy) / determinant, c = (syd * sxx - sxd * sxy) / determinant;
        return md - b * mx - c * my;
    }
};

/// Whether the pixel lies between members: within their convex hull. Their directions are gathered into a cone from
/// first to last, counter-clockwise and narrower than half a turn; a member in the opposite cone closes the hull about
/// the pixel.
bool isSurrounded(const std::vector<Neighbour>& members) {
    const auto cross = [](const Neighbour& a, const Neighbour& b) { return a.dx * b.dy - a.dy * b.dx; };
    const auto dot = [](const Neighbour& a, const Neighbour& b) { return a.dx * b.dx + a.dy * b.dy; };
    Neighbour first = members.front(), last = first;
    for (const Neighbour& n : members) {
        const int fromFirst = cross(first, n), fromLast = cross(last, n);
        if (fromFirst > 0 && fromLast > 0)
            last = n;
        else if (fromFirst < 0 && fromLast < 0)
            first = n;
        else if (fromFirst <= 0 && fromLast >= 0 && (dot(first, n) < 0 || dot(last, n) < 0))
            return true;
    }
    return false;
}

/// Neighbours of one surface: those whose disparity is between these two.
struct Patch {
    float least = 0, most = 0;
    int count = 0;

    bool has(const Neighbour& n) const { return n.disparity >= least && n.disparity <= most; }
};

/// Finds the heaviest of the clusters that a pixel's neighbours fall into: within one, nobody is farther from the next
/// than sameSurface times its disparity. Disparities are sorted into bins that are no wider than that, by their upper
/// bits, and bins alone are put in order: there are many neighbours, and few bins that hold any.
class ClusterFinder {
  public:
    /// sameSurface: 1/4096 at least.
    explicit ClusterFinder(float sameSurface) : sameSurface_(sameSurface) {
        assert(sameSurface * (1 << kMostPerOctave) >= 1);
        while (perOctave_ < kMostPerOctave && std::ldexp(1.f, -perOctave_) > sameSurface)
            ++perOctave_;
        bins_.resize(std::size_t{1} << (kExponentBits + perOctave_));
    }

    /// All must have a positive disparity.
    Patch heaviestOf(const std::vector<Neighbour>& neighbours) {
        for (const Neighbour& n : neighbours) {
            const std::uint32_t place = std::bit_cast<std::uint32_t>(n.disparity) >> (kMantissaBits - perOctave_);
            Bin& bin = bins_[place];
            if (bin.count == 0) {
                used_.push_back(place);
                bin.least = bin.most = n.disparity;
            }
            bin.least = std::min(bin.least, n.disparity), bin.most = std::max(bin.most, n.disparity);
            bin.weight += static_cast<double>(n.weight);
            ++bin.count;
        }
        std::sort(used_.begin(), used_.end());
        Bin here, best;
        for (const std::uint32_t place : used_) {
            Bin& bin = bins_[place];
            if (here.count == 0 || bin.least - here.most > sameSurface_ * bin.least) here = {bin.least, bin.most, 0, 0};
            here.most = bin.most, here.weight += bin.weight, here.count += bin.count;
            if (here.weight > best.weight) best = here;
            bin = {};
        }
        used_.clear();
        return {best.least, best.most, best.count};
    }

  private:
    static constexpr int kExponentBits = 8, kMantissaBits = 23;
    static constexpr int kMostPerOctave = 12; ///< as a power of two

    struct Bin {
        float least = 0, most = 0;
        double weight = 0;
        int count = 0;
    };

    float sameSurface_;
    int perOctave_ = 0; ///< bins, as a power of two
    std::vector<Bin> bins_;
    std::vector<std::uint32_t> used_;
};

/// Disparity at the centre of the plane through the members of a cluster. On a plane the pixel may stand out
/// from all members a little, as at the image's rim; noise gets no farther.
float planeAtCentre(const std::vector<Neighbour>& neighbours, const Patch& cluster) {
    PlaneSums plane;
    for (const Neighbour& n : neighbours)
        if (cluster.has(n)) plane.add(n);
    const double least = cluster.least, most = cluster.most;
    return static_cast<float>(std::clamp(plane.atCentre(), least - (most - least), most + (most - least)));
}

/// Disparity of what was measured; 0 elsewhere.
Image<float> measuredIn(const DepthImage& image) {
    Image<float> measured = image.disparity;
    for (std::size_t i = 0; i < measured.size(); ++i)
        if (!isSurface(image.flags.pixels()[i])) measured.pixels()[i] = 0;
    return measured;
}

/// Takes back what hangs in the middle of a gap: one wider than the support is surrounded there and nowhere else, and
/// may be a dark pole before a wall. What stays joins surface on both sides of its row or of its column, or on one side
/// of each, without a break.
void removeHanging(const DepthImage& image, Image<float>& filled) {
    const int width = filled.width(), height = filled.height();
    constexpr int kJoinsEnough = 2;
    Image<std::uint8_t> alongRow(width, height, std::uint8_t{0}), alongColumn = alongRow;
    // place(i, k): the pixel at k of line i.
    const auto markRuns = [&](int lines, int length, Image<std::uint8_t>& joins, auto place) {
        tbb::parallel_for(0, lines, [&](int i) {
            const auto isSurfaceAt = [&](int k) {
                if (k < 0 || k >= length) return false;
                const auto [x, y] = place(i, k);
                return isSurface(image.flags(x, y)) && image.disparity(x, y) > 0;
            };
            const auto isFilled = [&](int k) {
                const auto [x, y] = place(i, k);
                return filled(x, y) > 0;
            };
            for (int first = 0; first < length; ++first) {
                if (!isFilled(first)) continue;
                int end = first + 1;
                while (end < length && isFilled(end))
                    ++end;
                int ends = isSurfaceAt(first - 1) + isSurfaceAt(end);
                if (first == 0 || end == length) ends *= 2; // beyond the image it may go on
                for (; first < end; ++first) {
                    const auto [x, y] = place(i, first);
                    joins(x, y) = static_cast<std::uint8_t>(ends);
                }
            }
        });
    };
    // What goes may have been what joined another.
    for (bool isDone = false; !isDone;) {
        std::ranges::fill(alongRow.pixels(), std::uint8_t{0});
        std::ranges::fill(alongColumn.pixels(), std::uint8_t{0});
        markRuns(height, width, alongRow, [](int y, int x) { return std::array{x, y}; });
        markRuns(width, height, alongColumn, [](int x, int y) { return std::array{x, y}; });
        isDone = true;
        for (std::size_t i = 0; i < filled.size(); ++i)
            if (filled.pixels()[i] > 0 && alongRow.pixels()[i] + alongColumn.pixels()[i] < kJoinsEnough)
                filled.pixels()[i] = 0, isDone = false;
    }
}

/// Puts new disparities (those over 0) into the image, their flags set by `flag`. Returns how many.
template <class Flag>
std::int64_t putInto(DepthImage& image, const Image<float>& filled, Flag flag) {
    std::int64_t count = 0;
    for (std::size_t i = 0; i < filled.size(); ++i) {
        if (filled.pixels()[i] <= 0) continue;
        image.disparity.pixels()[i] = filled.pixels()[i];
        image.flags.pixels()[i] = flag(image.flags.pixels()[i]);
        ++count;
    }
    return count;
}

} // namespace

std::int64_t fillDropouts(DepthImage& image, const DropoutOptions& options) {
    const int width = image.camera.width, height = image.camera.height, radius = options.radius;
    const Image<float> measured = measuredIn(image);
    tbb::enumerable_thread_specific<ClusterFinder> finders(options.sameSurface);
    Image<float> filled(width, height, 0.f);
    tbb::parallel_for(0, height, [&](int y) {
        std::vector<Neighbour> neighbours, members;
        ClusterFinder& finder = finders.local();
        for (int x = 0; x < width; ++x) {
            if ((image.flags(x, y) & kNoSurface) == 0) continue;
            neighbours.clear();
            for (int j = std::max(y - radius, 0); j <= std::min(y + radius, height - 1); ++j)
                for (int i = std::max(x - radius, 0); i <= std::min(x + radius, width - 1); ++i)
                    if (const float disparity = measured(i, j); disparity > 0)
                        neighbours.push_back(
                            {i - x, j - y, disparity, supportOf(i - x, radius) * supportOf(j - y, radius)});
            if (std::ssize(neighbours) < options.minSamples) continue;
            const Patch cluster = finder.heaviestOf(neighbours);
            if (cluster.count < options.minSamples) continue;
            members.clear();
            std::copy_if(neighbours.begin(), neighbours.end(), std::back_inserter(members),
                         [&](const Neighbour& n) { return cluster.has(n); });
            if (isSurrounded(members)) filled(x, y) = planeAtCentre(members, cluster);
        }
    });
    removeHanging(image, filled);
    return putInto(image, filled,
                   [](std::uint8_t flags) { return static_cast<std::uint8_t>((flags & ~kNoSurface) | kInterpolated); });
}

std::int64_t guessRange(DepthImage& image, const GuessOptions& options) {
    const int width = image.camera.width, height = image.camera.height, radius = options.radius;
    if (radius <= 0) return 0;
    const std::vector<float> likenessOf = likenesses(options.colourStep);
    const Image<float> measured = measuredIn(image);
    tbb::enumerable_thread_specific<ClusterFinder> finders(options.sameSurface);
    Image<float> guessed(width, height, 0.f);
    tbb::parallel_for(0, height, [&](int y) {
        std::vector<Neighbour> neighbours;
        ClusterFinder& finder = finders.local();
        // Of the window's columns or rows about one the first that is in the image.
        const auto firstWithin = [&](int at) {
            return -radius + (std::max(radius - at, 0) + options.step - 1) / options.step * options.step;
        };
        for (int x = 0; x < width; ++x) {
            if ((image.flags(x, y) & kNoSurface) == 0) continue;
            neighbours.clear();
            const Rgb8 colour = image.colour(x, y);
            const int lastDx = std::min(radius, width - 1 - x), lastDy = std::min(radius, height - 1 - y);
            for (int dy = firstWithin(y); dy <= lastDy; dy += options.step) {
                const float supportOfRow = supportOf(dy, radius);
                for (int dx = firstWithin(x); dx <= lastDx; dx += options.step) {
                    const float disparity = measured(x + dx, y + dy);
                    if (!(disparity > 0)) continue;
                    const float likeness = likenessOf[squareOfDifference(colour, image.colour(x + dx, y + dy))];
                    neighbours.push_back({dx, dy, disparity, likeness * supportOf(dx, radius) * supportOfRow});
                }
            }
            if (std::ssize(neighbours) < options.minSamples) continue;
            const Patch cluster = finder.heaviestOf(neighbours);
            if (cluster.count >= options.minSamples) guessed(x, y) = planeAtCentre(neighbours, cluster);
        }
    });
    return putInto(image, guessed, [](std::uint8_t flags) { return static_cast<std::uint8_t>(flags | kInterpolated); });
}

} // namespace scene
