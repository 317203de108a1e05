#include "scene/samples_about.h"

#include "scene/tile_chunks.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scene {

namespace {

constexpr double kSameSurface = 0.02; // of disparity, as ComparisonOptions
constexpr double kBeside = 2;         // samples
constexpr double kReach = 4;          // samples, of those that a plane is laid through
constexpr std::size_t kFewest = 12;   // of them
constexpr double kSteepest = 0.1;     // cosine; what is seen at a narrower angle is not measured

struct Sample {
    double x = 0, y = 0, d = 0; ///< from the place: pixels, and disparity as it is
};

/// In the image's coordinates; nothing if it is not in its view.
std::optional<glm::dvec3> placeInImage(const TileBlock& block, const glm::dvec3& placeInWorld) {
    const glm::dvec3 p = inverse(block.worldFromCamera) * placeInWorld;
    if (!(p.z > 0)) return std::nullopt;
    const Camera& c = block.camera;
    const glm::dvec3 place(c.fx * p.x / p.z + c.cx, c.fy * p.y / p.z + c.cy, 1 / p.z);
    const bool isWithin =
        place.x > -kReach && place.y > -kReach && place.x < c.width + kReach && place.y < c.height + kReach;
    return isWithin ? std::optional(place) : std::nullopt;
}

std::vector<Sample> samplesNear(const TileBlock& block, const glm::dvec3& place) {
    std::vector<Sample> samples;
    SoundTiles sound(block);
    for (std::size_t i = 0; i < block.tiles.size(); ++i) {
        const Tile& tile = block.tiles[i];
        const double left = tile.x0 + 0.5, top = tile.y0 + 0.5;
        if (tile.tier != Tier::base || place.x < left - kReach || place.x > left + tile.width + kReach ||
            place.y < top - kReach || place.y > top + tile.height + kReach ||
            place.z < (1 - kSameSurface) * double{tile.minDisparity} ||
            place.z > (1 + kSameSurface) * double{tile.maxDisparity} || !sound.isSound(i))
            continue;
        for (std::uint32_t v = 0; v < tile.pointCount; ++v) { // the others are those of neighbours
            const TileVertex& vertex = block.vertices[tile.firstVertex + v];
            const VertexPlace at = placeOf(tile, vertex);
            const Sample sample{left + at.x - place.x, top + at.y - place.y, double{disparityOf(tile, vertex)}};
            if (std::max(std::abs(sample.x), std::abs(sample.y)) <= kReach &&
                std::abs(sample.d - place.z) <= kSameSurface * place.z)
                samples.push_back(sample);
        }
    }
    return samples;
}

/// d = a x + b y + c, by least squares: a plane's disparity. False if the samples leave it open.
bool fitPlane(const std::vector<Sample>& samples, glm::dvec3& plane) {
    glm::dmat3 sum(0.0);
    glm::dvec3 right(0);
    for (const Sample& s : samples) {
        const glm::dvec3 q(s.x, s.y, 1);
        sum += glm::outerProduct(q, q);
        right += s.d * q;
    }
    if (!(glm::determinant(sum) > 1e-6)) return false;
    plane = glm::inverse(sum) * right;
    return true;
}

SamplesAbout judge(const TileBlock& block, const glm::dvec3& place, const std::vector<Sample>& samples) {
    const Camera& c = block.camera;
    const double z = 1 / place.z;
    const glm::dvec3 ray((place.x - c.cx) / c.fx, (place.y - c.cy) / c.fy, 1);
    SamplesAbout about;
    about.rangeMetres = z * glm::length(ray);
    double cosine = 1;
    glm::dvec3 plane(0);
    if (samples.size() >= kFewest && fitPlane(samples, plane)) {
        double squares = 0;
        for (const Sample& s : samples) {
            const double off = plane.x * s.x + plane.y * s.y + plane.z - s.d;
            squares += off * off;
        }
        const double inDisparity = std::sqrt(squares / static_cast<double>(samples.size() - 3));
        about.scatterMetres = inDisparity * z * about.rangeMetres;
        // n . p = 1 on the plane in the camera's coordinates, where disparity is n . (x, y, 1) of the ray.
        const glm::dvec3 n(plane.x * c.fx, plane.y * c.fy,
                           plane.z + plane.x * (c.cx - place.x) + plane.y * (c.cy - place.y));
        if (glm::length(n) > 0) cosine = std::abs(glm::dot(n, ray)) / (glm::length(n) * glm::length(ray));
    }
    about.spacingMetres = z / std::min(c.fx, c.fy) / std::max(cosine, kSteepest);
    return about;
}

} // namespace

std::optional<SamplesAbout> samplesAbout(std::span<const TileBlock> blocks, const glm::dvec3& placeInWorld) {
    std::optional<SamplesAbout> nearest;
    double least = 0;
    for (std::size_t i = 0; i < blocks.size(); ++i) {
        const auto place = placeInImage(blocks[i], placeInWorld);
        if (!place) continue;
        const std::vector<Sample> samples = samplesNear(blocks[i], *place);
        for (const Sample& s : samples) {
            // How far the sample itself is from the place; of several images one is nearest.
            const double beside = std::hypot(s.x, s.y);
            if (beside > kBeside) continue;
            const double away = std::hypot(beside / blocks[i].camera.fx / place->z, 1 / s.d - 1 / place->z);
            if (nearest && away >= least) continue;
            least = away;
            if (!nearest || nearest->image != i) {
                nearest = judge(blocks[i], *place, samples);
                nearest->image = i;
            }
        }
    }
    return nearest;
}

} // namespace scene
