#include "scene/pick.h"

#include "scene/coverage_ray.h"
#include "scene/tile_chunks.h"
#include "scene/tile_warp.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <tbb/parallel_for.h>

namespace scene {

namespace {

/// The widest square that stands for a lone sample, in pixels of the narrow eye.
constexpr int kLoneFootprint = 8;

View narrowEye(const Ray& ray, const PickOptions& options) {
    const glm::dvec3 z = glm::normalize(ray.direction);
    const glm::dvec3 least = std::abs(z.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    const glm::dvec3 x = glm::normalize(glm::cross(least, z));
    const double half = options.pixels / 2.0;
    const double f = half / std::tan(options.fieldOfViewRadians / 2);
    return {{options.pixels, options.pixels, f, f, half, half},
            {glm::dmat3(x, glm::cross(z, x), z), ray.originInWorld}};
}

/// What the eye can see of an image, as planes in its (x, y, d): inside is dot(plane, (x, y, 1, d)) >= 0.
using Planes = std::array<glm::dvec4, 5>;

Planes planesOf(const View& eye, const glm::dmat4& c) {
    const double low = -kLoneFootprint / 2.0 - 1, high = eye.camera.width + kLoneFootprint / 2.0 + 1;
    const glm::dmat4 rows = glm::transpose(c); // u w, v w, w, d
    return {rows[0] - low * rows[2], high * rows[2] - rows[0], rows[1] - low * rows[2], high * rows[2] - rows[1],
            rows[2]};
}

/// False only if no vertex of the tile can be inside: its box in (x, y, d) lies beyond one plane.
bool mayBeSeen(const Tile& tile, const Planes& planes) {
    const double x0 = tile.x0 + 0.5, x1 = x0 + tile.width, y0 = tile.y0 + 0.5, y1 = y0 + tile.height;
    const auto d0 = static_cast<double>(tile.minDisparity), d1 = static_cast<double>(tile.maxDisparity);
    return std::all_of(planes.begin(), planes.end(), [&](const glm::dvec4& p) {
        return p.x * (p.x > 0 ? x1 : x0) + p.y * (p.y > 0 ? y1 : y0) + p.z + p.w * (p.w > 0 ? d1 : d0) >= 0;
    });
}

/// Tiles of one image that may be in the ray's way. lone: as points, the samples that no triangle holds.
struct Candidates {
    std::vector<Tile> seen, lone, unmeasured, loneUnmeasured;
};

/// Of a tile, as one that has no other samples; none if there are none.
std::optional<Tile> loneOf(const Tile& tile) {
    if (tile.loneCount == 0) return std::nullopt;
    Tile points = tile;
    points.firstVertex = firstLoneOf(tile);
    points.pointCount = points.vertexCount = tile.loneCount;
    points.firstQuad = points.quadCount = 0;
    return points;
}

Candidates collect(const TileBlock& block, const View& eye, const PreferenceOptions& shownGuesses) {
    Candidates found;
    const Planes planes = planesOf(eye, eyeImageFromSourceImage(eye, block.camera, block.worldFromCamera));
    SoundTiles sound(block);
    for (std::size_t i = 0; i < block.tiles.size(); ++i) {
        const Tile& tile = block.tiles[i];
        if (tile.tier == Tier::directional || !mayBeSeen(tile, planes) || !sound.isSound(i)) continue;
        if (tile.tier == Tier::base) {
            found.seen.push_back(tile);
            if (const std::optional<Tile> lone = loneOf(tile)) found.lone.push_back(*lone);
        } else if (orderLevelOf(tile, block.camera, block.worldFromCamera, eye, shownGuesses)) {
            const auto addTo = [](std::vector<Tile>& tiles, Tile unmeasured) {
                unmeasured.tier = Tier::base; // drawn in plain z order as everything here
                tiles.push_back(unmeasured);
            };
            addTo(found.unmeasured, tile);
            if (const std::optional<Tile> lone = loneOf(tile); lone && tile.tier == Tier::closed)
                addTo(found.loneUnmeasured, *lone);
        }
    }
    return found;
}

/// Disparities of what is drawn; negative where there is nothing.
Image<double> disparitiesOf(const ZBuffer& zBuffer) {
    Image<double> disparities(zBuffer.width(), zBuffer.height(), -1);
    for (std::size_t i = 0; i < zBuffer.size(); ++i) {
        const std::uint64_t key = zBuffer.pixels()[i];
        if (key != 0) disparities.pixels()[i] = static_cast<double>(eyeDisparityOf(key));
    }
    return disparities;
}

struct Pixel {
    int x = 0, y = 0;
};

/// The covered pixel nearest to the middle, no farther from it than so many pixels; the nearer surface of several.
std::optional<Pixel> coveredNearMiddle(const Image<double>& disparities, double most) {
    const double middle = disparities.width() / 2.0;
    std::optional<Pixel> best;
    double bestAway = most;
    for (int y = 0; y < disparities.height(); ++y)
        for (int x = 0; x < disparities.width(); ++x) {
            const double away = std::hypot(x + 0.5 - middle, y + 0.5 - middle);
            if (disparities(x, y) < 0 || away > bestAway) continue;
            if (best && away == bestAway && disparities(x, y) <= disparities(best->x, best->y)) continue;
            best = {x, y}, bestAway = away;
        }
    return best;
}

/// Pixels of the surface that a pixel is of: those reached from it without a jump in disparity.
std::vector<Pixel> surfaceAround(const Image<double>& disparities, const Pixel& start) {
    constexpr double kJump = 0.03; // of disparity, from pixel to pixel: 87 degrees from square at a tenth of a degree
    Image<std::uint8_t> isReached(disparities.width(), disparities.height(), 0);
    std::vector<Pixel> reached{start};
    isReached(start.x, start.y) = 1;
    for (std::size_t i = 0; i < reached.size(); ++i) {
        const Pixel from = reached[i];
        for (const Pixel step : {Pixel{1, 0}, Pixel{-1, 0}, Pixel{0, 1}, Pixel{0, -1}}) {
            const Pixel to{from.x + step.x, from.y + step.y};
            if (to.x < 0 || to.y < 0 || to.x >= disparities.width() || to.y >= disparities.height()) continue;
            const double here = disparities(from.x, from.y), there = disparities(to.x, to.y);
            if (isReached(to.x, to.y) || !(there > 0) || std::abs(there - here) > kJump * here) continue;
            isReached(to.x, to.y) = 1;
            reached.push_back(to);
        }
    }
    return reached;
}

/// The plane n . p = 1 in the eye's coordinates: disparity is n . ray, so it is a linear fit, repeated with less weight
/// on what does not agree (Tukey's biweight). Nothing if the pixels do not span a plane.
std::optional<glm::dvec3> planeThrough(const Image<double>& disparities, const std::vector<Pixel>& pixels,
                                       const Camera& camera) {
    constexpr std::size_t kFewest = 9;
    if (pixels.size() < kFewest) return std::nullopt;
    const auto rayOf = [&](const Pixel& pixel) { return rayThrough(camera, pixel.x + 0.5, pixel.y + 0.5); };
    std::vector<double> weights(pixels.size(), 1), residuals(pixels.size()), sorted;
    glm::dvec3 n(0);
    // In pixels, which are of the size of 1, the sums are well scaled.
    const glm::dmat3 rayFromPixel(glm::dvec3(1 / camera.fx, 0, 0), glm::dvec3(0, 1 / camera.fy, 0),
                                  glm::dvec3(0, 0, 1));
    const glm::dmat3 pixelFromRay = glm::inverse(rayFromPixel);
    for (int round = 0; round < 5; ++round) {
        glm::dmat3 sum(0.0);
        glm::dvec3 right(0);
        for (std::size_t i = 0; i < pixels.size(); ++i) {
            const glm::dvec3 q = pixelFromRay * rayOf(pixels[i]);
            sum += weights[i] * glm::outerProduct(q, q);
            right += weights[i] * disparities(pixels[i].x, pixels[i].y) * q;
        }
        if (!(std::abs(glm::determinant(sum)) > 1e-6)) return std::nullopt;
        n = glm::transpose(pixelFromRay) * (glm::inverse(sum) * right);
        for (std::size_t i = 0; i < pixels.size(); ++i)
            residuals[i] = std::abs(glm::dot(n, rayOf(pixels[i])) - disparities(pixels[i].x, pixels[i].y));
        sorted = residuals;
        std::nth_element(sorted.begin(), sorted.begin() + sorted.size() / 2, sorted.end());
        // Never below the grain of a key's disparity (orderBitsOf).
        const double reach = std::max(6 * sorted[sorted.size() / 2], 4e-6 * glm::length(n));
        for (std::size_t i = 0; i < pixels.size(); ++i) {
            const double share = 1 - std::min(residuals[i] / reach, 1.0) * std::min(residuals[i] / reach, 1.0);
            weights[i] = share * share;
        }
    }
    return n;
}

Pick pickAt(const View& eye, const Image<double>& disparities, const Pixel& pixel, bool isSeen) {
    const glm::dvec3 pInEye = rayThrough(eye.camera, pixel.x + 0.5, pixel.y + 0.5) / disparities(pixel.x, pixel.y);
    Pick hit{eye.worldFromEye * pInEye, std::nullopt, glm::length(pInEye), isSeen};
    const auto plane = planeThrough(disparities, surfaceAround(disparities, pixel), eye.camera);
    // n . p = 1 on the plane: n points away from the eye.
    if (plane && glm::length(*plane) > 0) hit.normal = eye.worldFromEye.rotation * -glm::normalize(*plane);
    return hit;
}

} // namespace

std::optional<Pick> pick(std::span<const TileBlock> blocks, const Ray& ray, const PickOptions& options) {
    const double length = glm::length(ray.direction);
    const glm::dvec3& o = ray.originInWorld;
    if (!(length > 0) || !std::isfinite(length) || !std::isfinite(o.x + o.y + o.z)) return std::nullopt;
    const View eye = narrowEye(ray, options);

    std::vector<Candidates> candidates(blocks.size());
    tbb::parallel_for(std::size_t{0}, blocks.size(),
                      [&](std::size_t i) { candidates[i] = collect(blocks[i], eye, options.shownGuesses); });
    std::vector<TileBlock> seen, lone, unmeasured, loneUnmeasured;
    for (std::size_t i = 0; i < blocks.size(); ++i) {
        const TileBlock& block = blocks[i];
        const auto lend = [&](std::vector<TileBlock>& into, std::span<const Tile> tiles) {
            if (!tiles.empty())
                into.push_back({block.camera,
                                block.worldFromCamera,
                                tiles,
                                {},
                                block.vertices,
                                block.quads,
                                {},
                                {},
                                {},
                                nullptr,
                                false});
        };
        lend(seen, candidates[i].seen);
        lend(unmeasured, candidates[i].unmeasured);
        lend(loneUnmeasured, candidates[i].loneUnmeasured);
        lend(lone, candidates[i].lone);
    }

    const WarpOptions plain{.preference = {.nearBaseline = 0}, .maxFootprint = kLoneFootprint};
    ZBuffer seenKeys(options.pixels, options.pixels), guessKeys(options.pixels, options.pixels);
    warpMesh(seen, eye, plain, seenKeys);
    warpPoints(lone, eye, plain, seenKeys);
    warpMesh(unmeasured, eye, plain, guessKeys);
    warpPoints(loneUnmeasured, eye, plain, guessKeys);
    const Image<double> seenDisparities = disparitiesOf(seenKeys), guessDisparities = disparitiesOf(guessKeys);

    const double snapPixels = eye.camera.fx * std::tan(options.snapRadians);
    const auto seenAt = coveredNearMiddle(seenDisparities, snapPixels);
    const auto guessAt = coveredNearMiddle(guessDisparities, 0.71); // no snapping to what nobody measured
    const auto unlessHidden = [&](const Pick& hit) {
        const bool isHidden = options.shownUnseen != nullptr &&
                              firstUnseen(*options.shownUnseen, o, glm::normalize(hit.position - o),
                                          hit.distanceMetres * (1 - kSurfaceSlack), options.unseenPocketMetres);
        return isHidden ? std::nullopt : std::optional(hit);
    };
    if (guessAt) {
        constexpr double kSameSurface = 0.02; // as ComparisonOptions
        const double guess = guessDisparities(guessAt->x, guessAt->y);
        if (guess > 0 && (!seenAt || guess > seenDisparities(seenAt->x, seenAt->y) * (1 + kSameSurface)))
            return unlessHidden(pickAt(eye, guessDisparities, *guessAt, false));
    }
    if (!seenAt || !(seenDisparities(seenAt->x, seenAt->y) > 0)) return std::nullopt;
    return unlessHidden(pickAt(eye, seenDisparities, *seenAt, true));
}

} // namespace scene
