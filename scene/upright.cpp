#include "scene/upright.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Dense>
#include <Eigen/Eigenvalues>

#include <glm/geometric.hpp>

namespace scene {

namespace {

constexpr double kDegree = 0.017453292519943295;
constexpr std::uint32_t kLeastSamples = 64; ///< of a tile
constexpr double kMostOff = 0.005;          ///< root mean square of disparity about a plane, relative
constexpr double kMostSlanting = 0.1;       ///< least cosine between a surface's normal and the ray: seen at a glance
/// What counts is narrowed step by step: furniture stands askew, too.
constexpr std::array kWithinDegrees{20., 20., 10., 10., 5., 5., 3., 3., 3.};
constexpr double kSharpDegrees = 3, kLeastShare = 0.2, kMostMovedDegrees = 25;
constexpr double kGuessShare = 0.005;
constexpr double kFarMetres = 10; ///< surfaces that are farther count as if they were no farther than that

/// How much is level or upright, the more the exacter: nothing counts that is off by as much as kSharpDegrees.
double agreementWith(const glm::dvec3& up, std::span<const Facing> facings) {
    const double most = std::sin(kSharpDegrees * kDegree);
    double agreement = 0;
    for (const Facing& facing : facings) {
        const double along = std::abs(glm::dot(facing.normal, up));
        const double off = std::min(along, std::sqrt(std::max(1 - along * along, 0.0))) / most;
        agreement += facing.area * std::max(1 - off * off, 0.0);
    }
    return agreement;
}

} // namespace

void addFacings(const TileBlock& block, std::vector<Facing>& facings) {
    const Camera& camera = block.camera;
    for (const Tile& tile : block.tiles) {
        if (tile.tier != Tier::base || tile.pointCount < kLeastSamples) continue;
        // Disparity of a plane is affine over the image: d = a + b x + c y, least squares about the middle.
        double x = 0, y = 0, d = 0;
        const auto forSamples = [&](const auto& visit) {
            for (std::uint32_t i = 0; i < tile.pointCount; ++i) {
                const TileVertex& vertex = block.vertices[tile.firstVertex + i];
                const VertexPlace place = placeOf(tile, vertex);
                visit(tile.x0 + place.x + 0.5, tile.y0 + place.y + 0.5, static_cast<double>(disparityOf(tile, vertex)));
            }
        };
        forSamples([&](double px, double py, double pd) { x += px, y += py, d += pd; });
        const double count = tile.pointCount;
        x /= count, y /= count, d /= count;
        if (!(d > 0)) continue;
        double xx = 0, xy = 0, yy = 0, xd = 0, yd = 0, dd = 0;
        forSamples([&](double px, double py, double pd) {
            const double dx = px - x, dy = py - y, off = pd - d;
            xx += dx * dx, xy += dx * dy, yy += dy * dy, xd += dx * off, yd += dy * off, dd += off * off;
        });
        const double determinant = xx * yy - xy * xy;
        if (determinant <= 0.02 * (xx + yy) * (xx + yy)) continue; // a line of samples
        const double b = (xd * yy - yd * xy) / determinant, c = (yd * xx - xd * xy) / determinant;
        const double left = dd - b * xd - c * yd;
        if (left > count * kMostOff * kMostOff * d * d) continue;
        // n . P = 1 with P = ray / d.
        const glm::dvec3 n(b * camera.fx, c * camera.fy, d + b * (camera.cx - x) + c * (camera.cy - y));
        const glm::dvec3 ray = rayThrough(camera, x, y);
        const double length = glm::length(n), slant = glm::dot(n, ray) / (length * glm::length(ray));
        if (!(std::abs(slant) > kMostSlanting)) continue;
        // What is far, or was cut off at a greatest range, is large and says little.
        const double near = std::max(d, 1 / kFarMetres);
        const double area = count * glm::length(ray) / (near * near * camera.fx * camera.fy * std::abs(slant));
        facings.push_back({block.worldFromCamera.rotation * (n / length), area});
    }
}

glm::dvec3 levelled(const glm::dvec3& guess, std::span<const Facing> facings) {
    double all = 0;
    for (const Facing& facing : facings)
        all += facing.area;
    glm::dvec3 up = guess;
    for (const double degrees : kWithinDegrees) {
        const double cosine = std::cos(degrees * kDegree), sine = std::sin(degrees * kDegree);
        Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
        for (const Facing& facing : facings) {
            const Eigen::Vector3d n(facing.normal.x, facing.normal.y, facing.normal.z);
            const double along = std::abs(glm::dot(facing.normal, up));
            if (along > cosine) spread -= facing.area * n * n.transpose();
            if (along < sine) spread += facing.area * n * n.transpose();
        }
        // Of walls that all run one way a whole plane of directions is upright: the guess decides among those.
        const Eigen::Vector3d g(guess.x, guess.y, guess.z);
        spread -= kGuessShare * all * g * g.transpose();
        const Eigen::Vector3d v = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors().col(0);
        const glm::dvec3 found(v.x(), v.y(), v.z());
        if (!(std::abs(glm::dot(found, guess)) > std::cos(kMostMovedDegrees * kDegree))) return guess;
        up = glm::dot(found, guess) < 0 ? -found : found;
    }
    const double before = agreementWith(guess, facings), after = agreementWith(up, facings);
    const bool isSure = after > kLeastShare * all && after > before;
    return isSure ? up : guess;
}

} // namespace scene
