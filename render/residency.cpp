#include "render/residency.h"

#include "render/shaders/shared/detail.h"
#include "render/source_views.h"

#include <glm/geometric.hpp>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace render {

namespace {

constexpr double kInView = 8;    ///< how much more a chunk is wanted that is looked at
constexpr double kLeast = 1e-12; ///< whatever is wanted at all is so by this
/// How much less a chunk is wanted that unseen space hides: after all others, since doors are only some steps away.
constexpr double kBehindUnseen = 1e-15;
constexpr double kTurnRadians = 0.35; ///< so far beyond the edge counts as looked at: heads turn
/// Of the width that is asked for: where all samples are narrower, the coarser level is drawn alone (shared/detail.h).
constexpr double kReplacedWhole =
    (0.5 - 0.5 * static_cast<double>(kDetailOverlap)) / (1 + static_cast<double>(kDetailBand));

constexpr double kMostPixels = 64; ///< pixels: wider, nobody can tell more
static_assert(kMostPixels * kInView * kBehindUnseen < kLeast);

/// Half the angle that an eye's picture spans, corner to corner, from the direction of its axis.
double reachOfView(const scene::Camera& camera) {
    const double x = std::max(camera.cx, camera.width - camera.cx) / camera.fx,
                 y = std::max(camera.cy, camera.height - camera.cy) / camera.fy;
    return std::atan(std::hypot(x, y));
}

double wantOf(const SceneIndex& index, const IndexedChunk& chunk, const scene::View& eye, const Quality& quality) {
    const ResidentImage& image = index.images[index.tiles[chunk.firstTile].image];
    const glm::dvec3 eyeInWorld = eye.worldFromEye.translation;
    if (!scene::isForAllEyes(chunk.chunk.tier)) {
        scene::PreferenceOptions near = quality.preference;
        if (quality.isBlended)
            near.nearBaseline = std::max(near.nearBaseline, static_cast<float>(quality.blend.baseline));
        if (!scene::mayBeNear(glm::length(eyeInWorld - image.worldFromCamera.translation), chunk.reach, near)) return 0;
    }
    const double focal = std::sqrt(eye.camera.fx * eye.camera.fy);
    double pixels = chunk.spacing * focal, widest = chunk.widestSpacing * focal;
    bool isInView = true;
    if (std::isfinite(chunk.radius)) {
        const glm::dvec3 toCentre = chunk.centre - eyeInWorld;
        const double distance = glm::length(toCentre);
        if (distance > chunk.radius) {
            pixels /= distance - chunk.radius, widest /= distance - chunk.radius;
            const double half = std::asin(chunk.radius / distance);
            const double turn =
                std::acos(std::clamp(glm::dot(toCentre, eye.worldFromEye.rotation[2]) / distance, -1.0, 1.0));
            isInView = turn - half <= reachOfView(eye.camera) + kTurnRadians;
        } else {
            pixels = widest = kMostPixels;
        }
    }
    const double warped = widest * quality.resolutionScale;                              // pixels
    if (image.hasCoarser && warped < kReplacedWhole * detailPixelsOf(quality)) return 0; // the coarser level suffices
    return std::clamp(pixels, kLeast, kMostPixels) * (isInView ? kInView : 1);
}

/// besideRay of the eye whose rays pass farthest beside what they show, in the pictures that are warped.
double mostBeside(const LookedAt& looked) {
    double most = 0;
    for (scene::View eye : looked.eyes) {
        eye.camera.fx *= looked.quality.resolutionScale, eye.camera.fy *= looked.quality.resolutionScale;
        most = std::max(most, besideRay(eye, looked.quality));
    }
    return most;
}

bool isBehindUnseen(const scene::WorldExtent& box, const scene::OpenWays& ways, double beside) {
    return box.isFinite() && !ways.mayMeet(box.least, box.most, beside);
}

/// By captured image, whether unseen space hides all of it.
std::vector<std::uint8_t> imagesBehindUnseen(const SceneIndex& index, const scene::OpenWays& ways, double beside) {
    std::vector<std::uint8_t> hidden(index.capturedImages, 0);
    tbb::parallel_for(std::size_t{0}, hidden.size(),
                      [&](std::size_t i) { hidden[i] = isBehindUnseen(index.spheres[i].box, ways, beside) ? 1 : 0; });
    return hidden;
}

} // namespace

CoarserChunks coarserChunksOf(const SceneIndex& index) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs; // finer, coarser
    for (std::uint32_t i = 0; i < index.tiles.size(); ++i)
        for (const std::uint32_t finer : index.finerThan(i))
            pairs.emplace_back(finer, index.tiles[i].chunk);
    std::sort(pairs.begin(), pairs.end());
    pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
    CoarserChunks found;
    found.first.assign(1, 0);
    std::size_t next = 0;
    for (std::uint32_t i = 0; i < index.chunks.size(); ++i) {
        for (; next < pairs.size() && pairs[next].first == i; ++next)
            found.coarser.push_back(pairs[next].second);
        found.first.push_back(static_cast<std::uint32_t>(found.coarser.size()));
    }
    return found;
}

std::vector<std::uint32_t> chunksToKeep(const SceneIndex& index, std::size_t budgetBytes) {
    std::vector<std::uint8_t> coarsest(index.capturedImages, 0);
    for (const ResidentImage& image : index.images)
        coarsest[image.captured] = std::max(coarsest[image.captured], static_cast<std::uint8_t>(image.level));
    const auto isKept = [&](const IndexedChunk& chunk, int finest) {
        return chunk.chunk.tier != scene::Tier::directional &&
               chunk.chunk.level >= std::min<int>(finest, coarsest[chunk.captured]);
    };
    const auto bytesOf = [&](int finest) {
        std::size_t bytes = 0;
        for (const IndexedChunk& chunk : index.chunks)
            bytes += isKept(chunk, finest) ? chunk.chunk.bytes() : 0;
        return bytes;
    };
    int finest = scene::kMaxLevels;
    while (finest > 0 && static_cast<double>(bytesOf(finest - 1)) <= kKeptShare * static_cast<double>(budgetBytes))
        --finest;
    std::vector<std::uint32_t> kept;
    for (std::uint32_t i = 0; i < index.chunks.size(); ++i)
        if (isKept(index.chunks[i], finest)) kept.push_back(i);
    return kept;
}

std::vector<std::uint32_t> chunksWanted(const SceneIndex& index, const CoarserChunks& coarser, const LookedAt& looked) {
    std::vector<double> wants(index.chunks.size(), 0.0);
    const bool mayHide = looked.ways != nullptr && looked.ways->isKnown();
    const double beside = mostBeside(looked);
    const std::vector<std::uint8_t> hidden =
        mayHide ? imagesBehindUnseen(index, *looked.ways, beside) : std::vector<std::uint8_t>(index.capturedImages, 0);
    tbb::parallel_for(std::size_t{0}, wants.size(), [&](std::size_t i) {
        const IndexedChunk& chunk = index.chunks[i];
        if (!looked.shares.empty() && looked.shares[chunk.captured] <= 0) return;
        for (const scene::View& eye : looked.eyes)
            wants[i] = std::max(wants[i], wantOf(index, chunk, eye, looked.quality));
        if (wants[i] <= 0 || !mayHide) return;
        const bool isBounded = std::isfinite(chunk.radius);
        if (hidden[chunk.captured] != 0 ||
            (isBounded && isBehindUnseen({chunk.least, chunk.most}, *looked.ways, beside)))
            wants[i] *= kBehindUnseen;
    });
    // Chunks of a block ascend by level, so that what stands for a chunk comes later.
    for (std::uint32_t i = 0; i < wants.size(); ++i)
        for (const std::uint32_t standIn : coarser.of(i))
            wants[standIn] = std::max(wants[standIn], wants[i] * (1 + 1e-9));
    std::vector<std::uint32_t> wanted;
    for (std::uint32_t i = 0; i < wants.size(); ++i)
        if (wants[i] > 0) wanted.push_back(i);
    std::stable_sort(wanted.begin(), wanted.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return wants[a] > wants[b]; });
    return wanted;
}

bool wantAboutTheSame(const LookedAt& a, const LookedAt& b) {
    constexpr double kSameMetres = 0.005, kSameTurnRadians = 0.0087; // a head that is held still
    const auto isSameEye = [&](const scene::View& one, const scene::View& other) {
        const scene::Pose &from = one.worldFromEye, &to = other.worldFromEye;
        return one.camera == other.camera && glm::distance(from.translation, to.translation) <= kSameMetres &&
               glm::dot(from.rotation[2], to.rotation[2]) >= std::cos(kSameTurnRadians);
    };
    const Quality &p = a.quality, &q = b.quality;
    return detailPixelsOf(p) * q.resolutionScale == detailPixelsOf(q) * p.resolutionScale &&
           p.preference.nearBaseline == q.preference.nearBaseline && p.isBlended == q.isBlended &&
           p.blend.baseline == q.blend.baseline && mostBeside(a) == mostBeside(b) &&
           std::ranges::equal(a.shares, b.shares) && std::ranges::equal(a.eyes, b.eyes, isSameEye);
}

} // namespace render
