#include "scene/refine/skins.h"

#include "scene/refine/crossing.h"
#include "scene/sample_comparison.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <mutex>

#include <glm/geometric.hpp>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace scene {

namespace {

/// Disparity at (x, y), guesses included; 0 outside the image and where there is no surface.
float surfaceDisparity(const DepthImage& image, int x, int y) {
    if (x < 0 || y < 0 || x >= image.camera.width || y >= image.camera.height) return 0;
    return isDrawable(image.flags(x, y)) ? image.disparity(x, y) : 0;
}

/// Whether disparity jumps from a sample to the next in some direction: more than planarity, and more than the slopes
/// to both sides explain. On a plane the second difference is 0; at a crease it is 0 on one side. 0 is no surface.
bool jumps(float before, float here, float next, float after, float planarity) {
    const float step = next - here, limit = planarity * std::max(here, next);
    const float slopeBefore = before > 0 ? here - before : 0, slopeAfter = after > 0 ? after - next : 0;
    return std::min(std::abs(step - slopeBefore), std::abs(step - slopeAfter)) > limit;
}

/// Disparities of surfaces, guesses included, with a rim of zeros about the image.
class PaddedSurface {
  public:
    explicit PaddedSurface(const DepthImage& image)
        : disparity_(image.camera.width + 2 * kRim, image.camera.height + 2 * kRim, 0.f) {
        for (int y = 0; y < image.camera.height; ++y)
            for (int x = 0; x < image.camera.width; ++x)
                disparity_(x + kRim, y + kRim) = isDrawable(image.flags(x, y)) ? image.disparity(x, y) : 0;
    }

    /// From the row's first sample on; kRim before it and after its last may be read, too, and so many rows.
    const float* row(int y) const { return &disparity_(kRim, y + kRim); }

    /// For each x up to the width: whether disparity jumps from (x + startX, y) to (x + startX + dx, y + dy).
    void findJumps(int y, int startX, int dx, int dy, float planarity, std::vector<std::uint8_t>& found) const {
        const float *before = row(y - dy) + startX - dx, *here = row(y) + startX, *next = row(y + dy) + startX + dx,
                    *after = row(y + 2 * dy) + startX + 2 * dx;
        for (std::size_t x = 0; x < found.size(); ++x)
            found[x] = jumps(before[x], here[x], next[x], after[x], planarity);
    }

    static constexpr int kRim = 2; ///< what findJumps reads beyond the image

  private:
    Image<float> disparity_;
};

/// The three corners of a triangle of the square at (x, y), as offsets.
using Corners = std::array<std::array<int, 2>, 3>;
constexpr Corners kUpperCorners{{{0, 0}, {1, 0}, {0, 1}}};
constexpr Corners kLowerCorners{{{1, 0}, {1, 1}, {0, 1}}};

bool hasTriangle(const DepthImage& image, int x, int y, const Corners& corners) {
    return std::all_of(corners.begin(), corners.end(),
                       [&](const auto& c) { return surfaceDisparity(image, x + c[0], y + c[1]) > 0; });
}

/// Calls visit(x, y, bit, corners) for each triangle between surfaces.
template <class Visit>
void forTrianglesOfRow(const DepthImage& image, int y, Visit visit) {
    for (int x = 0; x + 1 < image.camera.width; ++x) {
        if (hasTriangle(image, x, y, kUpperCorners)) visit(x, kSkinUpper, kUpperCorners);
        if (hasTriangle(image, x, y, kLowerCorners)) visit(x, kSkinLower, kLowerCorners);
    }
}

/// A triangle that may be a skin though disparity does not jump.
struct SkinChoice {
    int x = 0;
    SampleFlag skin = kSkinUpper;
    const Corners* corners = nullptr;
};

/// The triangles of each row that are to be asked about, the same for all partners: not cut yet, and deeper than the
/// noise between images. No shallower one can be told from a surface.
std::vector<std::vector<SkinChoice>> findCandidates(const DepthImage& image, const Image<std::uint8_t>& flags,
                                                    float sameSurface) {
    std::vector<std::vector<SkinChoice>> rows(static_cast<std::size_t>(image.camera.height));
    tbb::parallel_for(0, image.camera.height - 1, [&](int y) {
        forTrianglesOfRow(image, y, [&](int x, SampleFlag skin, const Corners& corners) {
            if (flags(x, y) & skin) return;
            float lowest = image.disparity(x + corners[0][0], y + corners[0][1]), highest = lowest;
            for (const auto& c : corners) {
                lowest = std::min(lowest, image.disparity(x + c[0], y + c[1]));
                highest = std::max(highest, image.disparity(x + c[0], y + c[1]));
            }
            if (highest - lowest > sameSurface * highest)
                rows[static_cast<std::size_t>(y)].push_back({x, skin, &corners});
        });
    });
    return rows;
}

/// A long skin may cross many pixels of the partner, which saw through few of them: so many pixels from probe to probe.
constexpr float kProbeSpacing = 2;
constexpr int kMostProbes = 64; ///< along an edge

/// Whether the partner saw farther than the triangle, at its middle or along an edge. Disparity is affine over the
/// triangle, so a mean of corners is a point of it.
bool sawThrough(const DepthImage& partner, const Reprojection& into, const DepthImage& image, int x, int y,
                const Corners& corners, const ComparisonOptions& options) {
    std::array<glm::vec3, 3> p;
    std::array<Sighting, 3> seen;
    for (std::size_t i = 0; i < 3; ++i) {
        const int cx = x + corners[i][0], cy = y + corners[i][1];
        p[i] = {static_cast<float>(cx) + 0.5f, static_cast<float>(cy) + 0.5f, image.disparity(cx, cy)};
        seen[i] = sightingOf(into, p[i].x, p[i].y, p[i].z);
    }
    const auto isThrough = [&](const glm::vec3& probe) {
        return compareWith(partner, sightingOf(into, probe.x, probe.y, probe.z), options).relation == Relation::inFront;
    };
    if (isThrough((p[0] + p[1] + p[2]) / 3.f)) return true;
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t j = (i + 1) % 3;
        const float pixels = std::max(std::abs(seen[j].u - seen[i].u), std::abs(seen[j].v - seen[i].v));
        const bool isBefore = seen[i].w > 0 && seen[j].w > 0; // else its length means nothing
        const int steps =
            isBefore ? static_cast<int>(std::clamp(pixels / kProbeSpacing, 2.f, static_cast<float>(kMostProbes)))
                     : kMostProbes;
        for (int k = 1; k < steps; ++k)
            if (isThrough(p[i] + (p[j] - p[i]) * (static_cast<float>(k) / static_cast<float>(steps)))) return true;
    }
    return false;
}

void compareSamplesOfRow(const DepthImage& image, int y, const DepthImage& partner, const Reprojection& into,
                         const ComparisonOptions& options, SampleComparison& samples) {
    samples.clear();
    for (int x = 0; x < image.camera.width; ++x)
        if (const float d = surfaceDisparity(image, x, y); d > 0)
            samples.add(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f, d);
    samples.compare(partner, into, options);
}

/// Floating samples about which, so many to each side, all others float as well.
std::int64_t countInside(const Image<std::uint8_t>& flags) {
    constexpr int kAbout = 3;
    const auto isFloating = [&](int x, int y) { return (flags(x, y) & kFloating) != 0 && !isOpenSky(flags(x, y)); };
    Image<std::uint8_t> run(flags.width(), flags.height(), 0); // of a row, up to here
    std::int64_t inside = 0;
    for (int y = 0; y < flags.height(); ++y) {
        std::uint8_t length = 0;
        for (int x = 0; x < flags.width(); ++x) {
            length = isFloating(x, y) ? static_cast<std::uint8_t>(std::min(length + 1, 2 * kAbout + 1)) : 0;
            run(x, y) = length;
            bool isInside = y >= 2 * kAbout && length == 2 * kAbout + 1;
            for (int above = 1; above <= 2 * kAbout && isInside; ++above)
                isInside = run(x, y - above) == 2 * kAbout + 1;
            inside += isInside;
        }
    }
    return inside;
}

constexpr int kApartEvery = 4; ///< samples, across and down

/// Of a sample that agrees; the sky is nowhere, and of something thin the other side is another surface.
void addApart(const SampleComparison& samples, int k, const DepthImage& partner, const Reprojection& into,
              float sameSurface, std::vector<float>& apartMetres) {
    const Comparison comparison = samples.comparison(k);
    const Sighting at = samples.sighting(k);
    if (!comparison.isSmooth || !(at.disparity > 0 && comparison.disparity > 0)) return;
    const Crossing crossing =
        crossingOf(partner, into, samples.x(k), samples.y(k), samples.disparity(k), at, sameSurface);
    if (crossing.isFromBehind()) return;
    // The partner's surface about there is the plane n . p = 1 in its camera. Along the ray it would be farther the
    // more that runs along the surface: metres of a floor far away, which nobody's pose is off by. (Noise makes slopes
    // of its own, so that of samples as dense as they scatter a tenth of the distance is lost.)
    const Camera& c = partner.camera;
    const glm::dvec3 n(c.fx * double{crossing.slopes.x}, c.fy * double{crossing.slopes.y},
                       double{comparison.disparity} + (c.cx - double{at.u}) * double{crossing.slopes.x} +
                           (c.cy - double{at.v}) * double{crossing.slopes.y});
    const double off = double{comparison.disparity} / double{at.disparity} - 1;
    apartMetres.push_back(static_cast<float>(std::abs(off) / glm::length(n)));
}

/// What a partner says, gathered by many threads.
struct Words {
    std::int64_t agrees = 0, sawThrough = 0;
    std::vector<float> apartMetres; ///< of some of those that agree

    void add(const Words& other) {
        agrees += other.agrees, sawThrough += other.sawThrough;
        apartMetres.insert(apartMetres.end(), other.apartMetres.begin(), other.apartMetres.end());
    }
    double medianApartMetres() {
        if (apartMetres.empty()) return 0;
        const auto middle = apartMetres.begin() + std::ssize(apartMetres) / 2;
        std::nth_element(apartMetres.begin(), middle, apartMetres.end());
        return static_cast<double>(*middle);
    }
};

/// A guess that others measured is a surface, one that they saw through is nothing.
void judgeGuess(std::uint8_t& flags, bool isFloating, bool isMeasured, SkinFigures& figures) {
    if (isFloating) {
        flags = static_cast<std::uint8_t>(flags & ~kInterpolated);
        ++figures.refuted;
    } else if (isMeasured) {
        flags = static_cast<std::uint8_t>(flags & ~kNoSurface);
        ++figures.confirmed;
    } else {
        ++figures.guesses;
    }
}

} // namespace

Image<std::uint8_t> markPlanarSkins(const DepthImage& image, float planarity, SkinFigures& figures) {
    Image<std::uint8_t> flags = image.flags;
    const PaddedSurface surface(image);
    // Of each square: along its upper and lower sides, from its upper right corner to the lower left, and down its
    // left side; of the right one the next square knows.
    const auto width = static_cast<std::size_t>(image.camera.width);
    std::vector<std::uint8_t> upper(width), lower(width), diagonal(width), left(width);
    surface.findJumps(0, 0, 1, 0, planarity, lower);
    for (int y = 0; y < image.camera.height; ++y) {
        figures.samples += std::count_if(image.flags.row(y).begin(), image.flags.row(y).end(), isSurface);
        if (y + 1 == image.camera.height) break;
        upper.swap(lower);
        surface.findJumps(y + 1, 0, 1, 0, planarity, lower);
        surface.findJumps(y, 1, -1, 1, planarity, diagonal);
        surface.findJumps(y, 0, 0, 1, planarity, left);
        const float *here = surface.row(y), *below = surface.row(y + 1);
        for (std::size_t x = 0; x + 1 < width; ++x) {
            if (!(here[x + 1] > 0 && below[x] > 0)) continue; // both triangles have these corners
            std::uint8_t skins = 0;
            if (here[x] > 0) {
                ++figures.triangles;
                if (diagonal[x] | upper[x] | left[x]) skins |= kSkinUpper;
            }
            if (below[x + 1] > 0) {
                ++figures.triangles;
                if (diagonal[x] | lower[x] | left[x + 1]) skins |= kSkinLower;
            }
            if (skins == 0) continue;
            figures.planarSkins += std::popcount(skins);
            std::uint8_t& flag = flags(static_cast<int>(x), y);
            flag = static_cast<std::uint8_t>(flag | skins);
        }
    }
    return flags;
}

Image<std::uint8_t> markSkins(ImageStore& images, std::size_t index, const std::vector<Partner>& partners,
                              const SkinOptions& options, SkinFigures& figures) {
    const ImageStore::Lease lease = images.borrow(index);
    const DepthImage& image = *lease;
    Image<std::uint8_t> flags = markPlanarSkins(image, options.planarity, figures);
    Image<std::uint8_t> agreed(image.camera.width, image.camera.height, 0), seenThrough = agreed;

    const std::vector<std::vector<SkinChoice>> candidates =
        findCandidates(image, flags, options.comparison.sameSurface);
    const std::size_t asked = std::min(partners.size(), static_cast<std::size_t>(options.maxPartners));
    for (std::size_t i = 0; i < asked; ++i) {
        // Faces and layers of one scan look from one place: what they hold apart is no evidence against either.
        if (images.at(partners[i].image).worldFromCamera.translation == image.worldFromCamera.translation) continue;
        const ImageStore::Lease partnerLease = images.borrow(partners[i].image);
        const DepthImage& partner = *partnerLease;
        const Reprojection into = reprojectionInto(partner, image);
        std::mutex adding;
        Words words;
        tbb::parallel_for(tbb::blocked_range<int>(0, image.camera.height), [&](const tbb::blocked_range<int>& rows) {
            SampleComparison samples(image.camera.width);
            Words here;
            for (int y = rows.begin(); y < rows.end(); ++y) {
                compareSamplesOfRow(image, y, partner, into, options.comparison, samples);
                for (int k = 0; k < samples.count(); ++k) {
                    const Relation relation = samples.relation(k);
                    const int x = static_cast<int>(samples.x(k));
                    const int measured = isGuess(image.flags(x, y)) ? 0 : 1;
                    if (relation == Relation::agrees) {
                        ++agreed(x, y), here.agrees += measured;
                        if (measured != 0 && x % kApartEvery == 0 && y % kApartEvery == 0)
                            addApart(samples, k, partner, into, options.comparison.sameSurface, here.apartMetres);
                    }
                    if (relation == Relation::inFront) ++seenThrough(x, y), here.sawThrough += measured;
                }
                for (const SkinChoice& triangle : candidates[static_cast<std::size_t>(y)])
                    if (!(flags(triangle.x, y) & triangle.skin) &&
                        sawThrough(partner, into, image, triangle.x, y, *triangle.corners, options.comparison))
                        flags(triangle.x, y) = static_cast<std::uint8_t>(flags(triangle.x, y) | triangle.skin);
            }
            const std::lock_guard lock(adding);
            words.add(here);
        });
        figures.words.push_back({partners[i].image, words.agrees, words.sawThrough, words.medianApartMetres()});
    }

    std::int64_t cut = 0;
    for (int y = 0; y < image.camera.height; ++y)
        for (int x = 0; x < image.camera.width; ++x) {
            cut += ((flags(x, y) & kSkinUpper) != 0) + ((flags(x, y) & kSkinLower) != 0);
            const bool isFloating = seenThrough(x, y) > agreed(x, y);
            std::uint8_t& mine = flags(x, y);
            if (isGuess(mine)) {
                judgeGuess(mine, isFloating, agreed(x, y) > 0, figures);
            } else if (isFloating) {
                mine = static_cast<std::uint8_t>(mine | kFloating);
                ++figures.floating;
            }
        }
    figures.seenThrough = cut - figures.planarSkins;
    figures.floatingInside = countInside(flags);
    return flags;
}

} // namespace scene
