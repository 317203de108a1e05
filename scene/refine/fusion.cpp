#include "scene/refine/fusion.h"

#include "scene/density.h"
#include "scene/refine/crossing.h"
#include "scene/sample_comparison.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace scene {

namespace {

/// Sums of one sample.
struct Mean {
    glm::vec3 colour{0};
    float colourWeight = 0, disparity = 0, disparityWeight = 0;
    bool isColoured = false; ///< of samples that have colours; those of intensity alone have no say then
    bool isMeasured = false; ///< by any of the samples
};

/// Whether drawing needs this sample: it is kept, or shares a mesh square with one that is.
bool isNeeded(const Image<Keep>& kept, int x, int y) {
    for (int j = std::max(y - 1, 0); j <= std::min(y + 1, kept.height() - 1); ++j)
        for (int i = std::max(x - 1, 0); i <= std::min(x + 1, kept.width() - 1); ++i)
            if (kept(i, j) != Keep::no) return true;
    return false;
}

/// Whether range was measured here, or right beside on the same surface: what lies between samples no farther apart
/// than two pixels is resampled, as the mesh of a scan is.
bool isMeasuredAbout(const DepthImage& image, int x, int y, float sameSurface) {
    if (!isClosed(image.flags(x, y))) return true;
    const float d = image.disparity(x, y);
    for (int j = std::max(y - 1, 0); j <= std::min(y + 1, image.camera.height - 1); ++j)
        for (int i = std::max(x - 1, 0); i <= std::min(x + 1, image.camera.width - 1); ++i)
            if (isSurface(image.flags(i, j)) && !isClosed(image.flags(i, j)) &&
                std::abs(image.disparity(i, j) - d) <= sameSurface * d)
                return true;
    return false;
}

/// What a partner knows about the disparity of a sample of which it sees the same surface: where the sample's ray meets
/// that surface, and how surely, as measurements count by the inverse of their variance (1: as surely as the sample's
/// own image).
struct Evidence {
    float disparity = 0, surety = 0;
};

/// The two differ, in the partner, by what its disparity falls short of the sighting's. Where that difference hardly
/// changes while the sample moves along its ray, the ray runs along the surface, or along the partner's image plane, or
/// the partner stands much farther off: then it says little. The same where the surface slopes steeply, since the
/// partner's samples may be misplaced.
Evidence evidenceOf(const Crossing& crossing, float disparity, const Sighting& at, float partnerDisparity,
                    const ComparisonOptions& options) {
    if (!crossing.isFromFront()) return {disparity, 0};
    const float change = crossing.change, upright = crossing.upright;
    const float least = std::min(change * change, upright * upright);
    const float steepness = std::max(std::abs(crossing.slopes.x), std::abs(crossing.slopes.y));
    const float doubt = steepness > 0 ? options.pixelError * steepness / (options.sameSurface * at.disparity) : 0;
    return {disparity + (partnerDisparity - at.disparity) * crossing.w / change,
            std::min(1.f, least / (1 + doubt * doubt))};
}

std::uint8_t toByte(float value) {
    return static_cast<std::uint8_t>(std::clamp(value + 0.5f, 0.f, 255.f));
}

} // namespace

DepthImage fuse(ImageStore& images, std::size_t index, const std::vector<Partner>& partners, const Image<Keep>& kept,
                const FusionOptions& options) {
    DepthImage fused = *images.borrow(index);
    const DepthImage& image = fused; // read while sums gather elsewhere
    const Camera& camera = image.camera;
    Image<Mean> means(camera.width, camera.height);
    const float perAngle = 1 / (options.angleRadians * options.angleRadians);
    const float perColour = 1 / (options.colourStep * options.colourStep);

    // What is the same for all partners is worked out once: which samples are needed, and the rays through them.
    Image<std::uint8_t> needed(camera.width, camera.height, 0);
    std::vector<float> rayX(static_cast<std::size_t>(camera.width)), rayY(static_cast<std::size_t>(camera.height));
    for (int x = 0; x < camera.width; ++x)
        rayX[static_cast<std::size_t>(x)] = static_cast<float>(rayThrough(camera, x + 0.5, 0).x);
    tbb::parallel_for(0, camera.height, [&](int y) {
        rayY[static_cast<std::size_t>(y)] = static_cast<float>(rayThrough(camera, 0, y + 0.5).y);
        for (int x = 0; x < camera.width; ++x)
            needed(x, y) = isSurface(image.flags(x, y)) && isNeeded(kept, x, y) ? 1 : 0;
    });
    const auto forNeeded = [&](const auto& visit) {
        tbb::parallel_for(0, camera.height, [&](int y) {
            for (int x = 0; x < camera.width; ++x)
                if (needed(x, y)) visit(x, y);
        });
    };
    // Weights are relative to the sample's own, which is 1.
    const auto hasOwnColour = [&](int x, int y) { return (image.flags(x, y) & kNoColour) == 0; };
    forNeeded([&](int x, int y) {
        means(x, y) = {colourOf(image, x, y), 1,
                       image.disparity(x, y), 1,
                       hasOwnColour(x, y),    isMeasuredAbout(image, x, y, options.comparison.sameSurface)};
    });

    const std::size_t asked = std::min(partners.size(), static_cast<std::size_t>(options.maxPartners));
    for (std::size_t i = 0; i < asked; ++i) {
        const ImageStore::Lease lease = images.borrow(partners[i].image);
        const DepthImage& partner = *lease;
        const Reprojection into = reprojectionInto(partner, image);
        const glm::vec3 partnerInCamera((inverse(image.worldFromCamera) * partner.worldFromCamera).translation);
        const auto take = [&](const SampleComparison& samples, int k) {
            const Comparison comparison = samples.comparison(k);
            if (comparison.relation != Relation::agrees || !comparison.isSmooth) return;
            const float px = samples.x(k), py = samples.y(k), d = samples.disparity(k);
            const int x = static_cast<int>(px), y = static_cast<int>(py);
            const Sighting at = samples.sighting(k);
            const Crossing crossing = crossingOf(partner, into, px, py, d, at, options.comparison.sameSurface);
            if (crossing.isFromBehind()) return; // the other side of something thin

            // To the point, from here and from the partner; both times disparity, so that the sky needs no special
            // case.
            const glm::vec3 fromHere(rayX[static_cast<std::size_t>(x)], rayY[static_cast<std::size_t>(y)], 1.f);
            const glm::vec3 fromPartner = fromHere - d * partnerInCamera;
            const float here = glm::dot(fromHere, fromHere), there = glm::dot(fromPartner, fromPartner);
            const float cosine = glm::dot(fromHere, fromPartner) / std::sqrt(here * there);
            const float angleSquared = 2 * (1 - std::min(cosine, 1.f));
            // Samples taken from nearer are sharper and their range is surer.
            const float nearness = std::min(1.f, here / there);

            Mean& mean = means(x, y);
            const Evidence evidence = evidenceOf(crossing, d, at, comparison.disparity, options.comparison);
            // Beyond that it is another surface, or no number at all.
            if (std::abs(evidence.disparity - d) <= 2 * options.comparison.sameSurface * d) {
                mean.disparity += evidence.surety * evidence.disparity;
                mean.disparityWeight += evidence.surety;
            }
            const std::uint8_t partnersFlags = partner.flags(static_cast<int>(at.u), static_cast<int>(at.v));
            mean.isMeasured |= !isClosed(partnersFlags);
            const bool isColoured = hasColourAt(partner, at.u, at.v);
            if (mean.isColoured && !isColoured) return;
            if (isColoured && !mean.isColoured) {
                mean.colour = glm::vec3(0), mean.colourWeight = 0;
                mean.isColoured = true;
            }
            const glm::vec3 colour = colourAt(partner, at.u, at.v);
            float doubts = angleSquared * perAngle;
            if (isColoured == hasOwnColour(x, y)) { // else there is nothing to compare with
                const glm::vec3 change = colour - colourOf(image, x, y);
                doubts += glm::dot(change, change) * perColour;
            }
            const float weight = nearness * std::exp(-doubts);
            mean.colour += weight * colour;
            mean.colourWeight += weight;
        };
        tbb::parallel_for(tbb::blocked_range<int>(0, camera.height), [&](const tbb::blocked_range<int>& rows) {
            SampleComparison samples(camera.width);
            for (int y = rows.begin(); y < rows.end(); ++y) {
                samples.clear();
                for (int x = 0; x < camera.width; ++x)
                    if (needed(x, y))
                        samples.add(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f, image.disparity(x, y));
                samples.compare(partner, into, options.comparison);
                for (int k = 0; k < samples.count(); ++k)
                    take(samples, k);
            }
        });
    }

    Image<Rgb8> colour = fused.colour;
    Image<float> disparity = fused.disparity;
    Image<std::uint8_t> flags = fused.flags;
    forNeeded([&](int x, int y) {
        const Mean& mean = means(x, y);
        if (mean.colourWeight > 0) {
            const glm::vec3 c = mean.colour / mean.colourWeight;
            colour(x, y) = {toByte(c.x), toByte(c.y), toByte(c.z)};
            if (mean.isColoured) flags(x, y) = static_cast<std::uint8_t>(flags(x, y) & ~kNoColour);
        }
        disparity(x, y) = mean.disparity / mean.disparityWeight;
        if (mean.isMeasured) flags(x, y) = static_cast<std::uint8_t>(flags(x, y) & ~kInterpolated);
    });
    fused.colour = std::move(colour);
    fused.disparity = std::move(disparity);
    fused.flags = std::move(flags);
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x)
            if (kept(x, y) != Keep::base)
                fused.flags(x, y) =
                    static_cast<std::uint8_t>(fused.flags(x, y) | (kept(x, y) == Keep::no ? kRedundant : kDirectional));
    return fused;
}

} // namespace scene
