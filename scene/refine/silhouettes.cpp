#include "scene/refine/silhouettes.h"

#include "scene/refine/patch_cost.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <span>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace scene {

namespace {

float differenceOf(const glm::vec3& a, const glm::vec3& b) {
    const glm::vec3 d = glm::abs(a - b);
    return (d.x + d.y + d.z) / 3;
}

/// The surfaces on both sides of a jump of range, as disparities, and how far off the sample of the one is that is not
/// the pixel's own; far is 0 where there is no jump.
struct Sides {
    float near = 0, far = 0, pixels = 0;
};

/// Disparity of each surface; 0 where there is none.
Image<float> surfacesOf(const DepthImage& image) {
    Image<float> surfaces(image.camera.width, image.camera.height, 0.f);
    for (std::size_t i = 0; i < surfaces.size(); ++i)
        if (isSurface(image.flags.pixels()[i])) surfaces.pixels()[i] = image.disparity.pixels()[i];
    return surfaces;
}

/// Least and greatest disparity of the surfaces in the window about each pixel; 0 is the greatest where there is none.
struct Extremes {
    Image<float> least, greatest;
};

/// What a window takes of rows of values, each beside the next: a whole row at a time, as vectors like it.
void takeLeast(std::span<float> least, const float* values) {
    for (std::size_t i = 0; i < least.size(); ++i)
        least[i] = values[i] < least[i] ? values[i] : least[i];
}
void takeGreatest(std::span<float> greatest, const float* values) {
    for (std::size_t i = 0; i < greatest.size(); ++i)
        greatest[i] = values[i] > greatest[i] ? values[i] : greatest[i];
}

Extremes findExtremes(const Image<float>& surfaces, int radius) {
    const int width = surfaces.width(), height = surfaces.height();
    constexpr float kNone = std::numeric_limits<float>::infinity();
    Extremes ofRows{Image<float>(width, height, kNone), Image<float>(width, height, 0.f)}, found = ofRows;
    tbb::parallel_for(tbb::blocked_range<int>(0, height), [&](const tbb::blocked_range<int>& rows) {
        const auto reach = static_cast<std::size_t>(radius), wide = static_cast<std::size_t>(width);
        std::vector<float> high(wide + 2 * reach, 0.f), low(high.size(), kNone); // nothing stands beside the image
        for (int y = rows.begin(); y < rows.end(); ++y) {
            for (std::size_t x = 0; x < wide; ++x) {
                const float d = surfaces.row(y)[x];
                high[reach + x] = d, low[reach + x] = d > 0 ? d : kNone;
            }
            for (std::size_t i = 0; i <= 2 * reach; ++i)
                takeLeast(ofRows.least.row(y), &low[i]), takeGreatest(ofRows.greatest.row(y), &high[i]);
        }
    });
    tbb::parallel_for(0, height, [&](int y) {
        for (int j = std::max(y - radius, 0); j <= std::min(y + radius, height - 1); ++j) {
            takeLeast(found.least.row(y), ofRows.least.row(j).data());
            takeGreatest(found.greatest.row(y), ofRows.greatest.row(j).data());
        }
    });
    return found;
}

struct Offset {
    int x, y;
    float pixels;         ///< how far that is
    std::ptrdiff_t index; ///< among the pixels of an image
};

/// Offsets within a window, the nearest first.
std::vector<Offset> offsetsWithin(int radius, int width) {
    std::vector<Offset> offsets;
    for (int y = -radius; y <= radius; ++y)
        for (int x = -radius; x <= radius; ++x)
            offsets.push_back({x, y, std::hypot(static_cast<float>(x), static_cast<float>(y)),
                               static_cast<std::ptrdiff_t>(y) * width + x});
    std::stable_sort(offsets.begin(), offsets.end(),
                     [](const Offset& a, const Offset& b) { return a.x * a.x + a.y * a.y < b.x * b.x + b.y * b.y; });
    return offsets;
}

/// Both sides at each pixel beside a jump: of each the sample nearest in the image, the pixel's own among them.
Image<Sides> findSides(const DepthImage& image, const SilhouetteOptions& options) {
    const int width = image.camera.width, height = image.camera.height, radius = options.radius;
    const Image<float> surfaces = surfacesOf(image);
    const Extremes extremes = findExtremes(surfaces, radius);
    const std::vector<Offset> offsets = offsetsWithin(radius, width);
    Image<Sides> sides(width, height);
    tbb::parallel_for(0, height, [&](int y) {
        const std::span<const float> greatest = extremes.greatest.row(y), least = extremes.least.row(y);
        for (int x = 0; x < width; ++x) {
            const float near = greatest[static_cast<std::size_t>(x)], far = least[static_cast<std::size_t>(x)];
            if (near <= 0 || near - far <= options.jump * near) continue;
            const float middle = (near + far) / 2, *const here = &surfaces(x, y);
            const bool isInside = x >= radius && y >= radius && x < width - radius && y < height - radius;
            Sides found;
            for (const Offset& offset : offsets) {
                const int i = x + offset.x, j = y + offset.y;
                if (!isInside && (i < 0 || j < 0 || i >= width || j >= height)) continue;
                const float d = here[offset.index];
                if (d <= 0) continue;
                float& side = d > middle ? found.near : found.far;
                if (side > 0) continue;
                side = d;
                found.pixels = offset.pixels;
                if (found.near > 0 && found.far > 0) break;
            }
            if (found.far > 0 && found.near - found.far > options.jump * found.near) sides(x, y) = found;
        }
    });
    return sides;
}

/// What is compared: the colours about a pixel, and how much each counts.
void takePatch(const DepthImage& image, int x, int y, const SilhouetteOptions& options, PatchSamples& patch) {
    patch.clear();
    const glm::vec3 middle = colourOf(image, x, y);
    const int r = options.patchRadius;
    for (int j = std::max(y - r, 0); j <= std::min(y + r, image.camera.height - 1); ++j)
        for (int i = std::max(x - r, 0); i <= std::min(x + r, image.camera.width - 1); ++i) {
            const glm::vec3 colour = colourOf(image, i, j);
            const float weight = std::exp(-differenceOf(colour, middle) / options.colourStep);
            if (weight > 0.05f) patch.add(static_cast<float>(i - x), static_cast<float>(j - y), weight, colour);
        }
    patch.pad();
}

/// A photograph that is asked.
struct Witness {
    const DepthImage* image;
    Reprojection into;
};

/// How much the patch's colours differ from the witness's if its middle (x, y) lies at that disparity; below 0 if the
/// witness has no view of it. Patches are small: within one, places in the witness are affine.
float costOf(const Witness& witness, const PatchSamples& patch, float x, float y, float disparity,
             const SilhouetteOptions& options) {
    const DepthImage& image = *witness.image;
    const Sighting middle = sightingOf(witness.into, x, y, disparity);
    if (!(middle.w > 0)) return -1;
    const glm::vec3 &byX = witness.into.columnX, &byY = witness.into.columnY;
    const float perW = 1 / middle.w;
    const float uByX = (byX.x - middle.u * byX.z) * perW, vByX = (byX.y - middle.v * byX.z) * perW;
    const float uByY = (byY.x - middle.u * byY.z) * perW, vByY = (byY.y - middle.v * byY.z) * perW;
    const auto radius = static_cast<float>(options.patchRadius);
    const float reachU = radius * (std::abs(uByX) + std::abs(uByY)) + 1;
    const float reachV = radius * (std::abs(vByX) + std::abs(vByY)) + 1;
    if (!(middle.u >= reachU) || !(middle.v >= reachV) ||
        !(middle.u < static_cast<float>(image.camera.width) - reachU) ||
        !(middle.v < static_cast<float>(image.camera.height) - reachV))
        return -1;
    if (compareWith(image, middle, options.comparison).relation == Relation::behind) return -1;
    const PatchPlaces places{middle.u, middle.v, uByX, uByY, vByX, vByY};
    return sumOfDifferences(image.colour, patch, places, options.mostDifference) / patch.weightOfAll();
}

constexpr std::size_t kLeastWitnesses = 2;

/// The mean of the better half: what hides the surface from some says nothing. Below 0 if too few saw it.
float betterHalf(std::vector<float>& costs) {
    if (costs.size() < kLeastWitnesses) return -1;
    std::sort(costs.begin(), costs.end());
    const std::size_t half = (costs.size() + 1) / 2;
    float sum = 0;
    for (std::size_t i = 0; i < half; ++i)
        sum += costs[i];
    return sum / static_cast<float>(half);
}

/// How much better the far side of (x, y) fits than the near one; NaN where nobody can say.
float gainOfFar(const DepthImage& image, int x, int y, const Sides& side, const std::vector<Witness>& witnesses,
                const SilhouetteOptions& options) {
    static thread_local PatchSamples patch;
    static thread_local std::vector<float> ofNear, ofFar;
    takePatch(image, x, y, options, patch);
    ofNear.clear(), ofFar.clear();
    const float px = static_cast<float>(x) + 0.5f, py = static_cast<float>(y) + 0.5f;
    for (const Witness& witness : witnesses) {
        const float near = costOf(witness, patch, px, py, side.near, options);
        const float far = costOf(witness, patch, px, py, side.far, options);
        if (near >= 0) ofNear.push_back(near);
        if (far >= 0) ofFar.push_back(far);
    }
    const float near = betterHalf(ofNear), far = betterHalf(ofFar);
    return near >= 0 && far >= 0 ? near - far : std::nanf("");
}

/// gainOfFar of every step-th contested pixel in both directions; NaN elsewhere.
Image<float> weigh(const DepthImage& image, const Image<Sides>& sides, const std::vector<Witness>& witnesses, int step,
                   const SilhouetteOptions& options) {
    Image<float> gains(image.camera.width, image.camera.height, std::nanf(""));
    if (witnesses.size() < kLeastWitnesses) return gains;
    tbb::parallel_for(0, (image.camera.height + step - 1) / step, [&](int row) {
        const int y = row * step;
        for (int x = 0; x < image.camera.width; x += step)
            if (sides(x, y).far > 0) gains(x, y) = gainOfFar(image, x, y, sides(x, y), witnesses, options);
    });
    return gains;
}

/// The mean of what its neighbours of like colour say.
float gainAbout(const DepthImage& image, const Image<float>& gains, int x, int y, const SilhouetteOptions& options) {
    const glm::vec3 middle = colourOf(image, x, y);
    float sum = 0, weights = 0;
    const int r = options.patchRadius;
    for (int j = std::max(y - r, 0); j <= std::min(y + r, gains.height() - 1); ++j)
        for (int i = std::max(x - r, 0); i <= std::min(x + r, gains.width() - 1); ++i) {
            if (std::isnan(gains(i, j))) continue;
            const float weight = std::exp(-differenceOf(colourOf(image, i, j), middle) / options.colourStep);
            sum += weight * gains(i, j), weights += weight;
        }
    return weights > 0 ? sum / weights : 0;
}

/// How far near and far lie apart in another photograph, in pixels: the mean over some contested pixels.
float parallaxIn(const Reprojection& into, const Image<Sides>& sides) {
    constexpr int kStep = 5;
    double sum = 0;
    std::int64_t count = 0;
    for (int y = kStep / 2; y < sides.height(); y += kStep)
        for (int x = kStep / 2; x < sides.width(); x += kStep) {
            const Sides& side = sides(x, y);
            if (side.far <= 0) continue;
            const float px = static_cast<float>(x) + 0.5f, py = static_cast<float>(y) + 0.5f;
            const Sighting near = sightingOf(into, px, py, side.near), far = sightingOf(into, px, py, side.far);
            if (!(near.w > 0) || !(far.w > 0)) continue;
            sum += std::hypot(near.u - far.u, near.v - far.v);
            ++count;
        }
    return count > 0 ? static_cast<float>(sum / static_cast<double>(count)) : 0;
}

/// The photographs that can tell near from far, those that share most with the image first, and the leases on them.
struct Witnesses {
    std::vector<ImageStore::Lease> leases;
    std::vector<Witness> all;
};

Witnesses findWitnesses(ImageStore& images, const DepthImage& image, const Image<Sides>& sides,
                        const std::vector<Partner>& partners, const SilhouetteOptions& options) {
    Witnesses found;
    for (const Partner& partner : partners) {
        if (std::ssize(found.all) >= options.maxPartners) break;
        const StoredImage& other = images.at(partner.image);
        const Reprojection into =
            reprojectionInto(other.camera, other.worldFromCamera, image.camera, image.worldFromCamera);
        const float parallax = parallaxIn(into, sides);
        if (parallax < options.leastParallax || parallax > options.mostParallax) continue;
        found.leases.push_back(images.borrow(partner.image));
        found.all.push_back({&*found.leases.back(), into});
    }
    return found;
}

/// Whether more witnesses saw through the sample than agree with it.
bool isSeenThrough(const std::vector<Witness>& witnesses, float x, float y, float disparity,
                   const ComparisonOptions& options) {
    int through = 0, agree = 0;
    for (const Witness& witness : witnesses) {
        const Relation relation =
            compareWith(*witness.image, sightingOf(witness.into, x, y, disparity), options).relation;
        through += relation == Relation::inFront;
        agree += relation == Relation::agrees;
    }
    return through > agree;
}

/// Of every so many pixels one is enough to judge an image by, in both directions.
constexpr int kJudgedStep = 6;

} // namespace

SilhouetteVerdict judgeSilhouettes(ImageStore& images, const std::vector<std::vector<Partner>>& partners,
                                   const SilhouetteOptions& options) {
    const std::size_t count = std::min(images.size(), static_cast<std::size_t>(options.judged));
    SilhouetteVerdict verdict;
    // One after the other: each is held with all it asks.
    for (std::size_t k = 0; k < count; ++k) {
        const std::size_t index = (2 * k + 1) * images.size() / (2 * count);
        const ImageStore::Lease image = images.borrow(index);
        const Image<Sides> sides = findSides(*image, options);
        const Witnesses witnesses = findWitnesses(images, *image, sides, partners[index], options);
        const Image<float> gains = weigh(*image, sides, witnesses.all, kJudgedStep, options);
        for (int y = 0; y < gains.height(); ++y)
            for (int x = 0; x < gains.width(); ++x) {
                if (std::isnan(gains(x, y)) || !isSurface(image->flags(x, y))) continue;
                const bool isNear = image->disparity(x, y) == sides(x, y).near;
                const float forOther = isNear ? gains(x, y) : -gains(x, y);
                (forOther > 0 ? verdict.forOther : verdict.forOwn) += std::abs(forOther);
                ++verdict.samples;
                if (!isNear) continue;
                ++verdict.near;
                verdict.seenThrough +=
                    isSeenThrough(witnesses.all, static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f,
                                  image->disparity(x, y), options.comparison);
            }
    }
    return verdict;
}

DepthImage settleSilhouettes(ImageStore& images, std::size_t index, const std::vector<Partner>& partners,
                             const SilhouetteOptions& options, SilhouetteFigures& figures) {
    const ImageStore::Lease lease = images.borrow(index);
    const DepthImage& image = *lease;
    DepthImage settled = image;
    const Image<Sides> sides = findSides(image, options);
    const Witnesses witnesses = findWitnesses(images, image, sides, partners, options);
    const Image<float> gains = weigh(image, sides, witnesses.all, options.step, options);
    std::atomic<std::int64_t> contested = 0, moved = 0, guessed = 0;
    tbb::parallel_for(0, image.camera.height, [&](int y) {
        for (int x = 0; x < image.camera.width; ++x) {
            const Sides& side = sides(x, y);
            if (side.far <= 0) continue;
            ++contested;
            const float gain = gainAbout(image, gains, x, y, options);
            // Edges are off by little: the farther, the better must the other side fit.
            const float pixels = isSurface(image.flags(x, y)) ? std::max(side.pixels, 1.f) : 1.f;
            if (std::abs(gain) < options.leastGain * pixels) continue;
            const float better = gain > 0 ? side.far : side.near;
            if (better == image.disparity(x, y)) continue;
            settled.disparity(x, y) = better;
            std::uint8_t& flags = settled.flags(x, y);
            ++(isSurface(flags) ? moved : guessed);
            flags = static_cast<std::uint8_t>(flags | kInterpolated);
        }
    });
    figures.contested = contested, figures.moved = moved, figures.guessed = guessed;
    return settled;
}

} // namespace scene
