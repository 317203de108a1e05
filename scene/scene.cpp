#include "scene/scene.h"

#include "scene/upright.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scene {

namespace {

/// The direction that the cameras' x axes are most level to, pointing where most of them have their up.
glm::dvec3 uprightOfCameras(const std::vector<SceneImage>& images) {
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    glm::dvec3 meanUp(0);
    for (const SceneImage& image : images) {
        const glm::dvec3& right = image.worldFromCamera.rotation[0];
        meanUp -= image.worldFromCamera.rotation[1];
        const Eigen::Vector3d r(right.x, right.y, right.z);
        spread += r * r.transpose();
    }
    // Cameras that all look one way leave a plane of candidates: a little of the mean up decides among those.
    const double length = glm::length(meanUp);
    if (length > 0) meanUp /= length;
    const Eigen::Vector3d u(meanUp.x, meanUp.y, meanUp.z);
    spread -= 0.5 * static_cast<double>(images.size()) * u * u.transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread);
    const Eigen::Vector3d v = solver.eigenvectors().col(0);
    const glm::dvec3 upright(v.x(), v.y(), v.z());
    return glm::dot(upright, meanUp) < 0 ? -upright : upright;
}

glm::dvec3 findUpright(const std::vector<SceneImage>& images, const std::vector<TileBlock>& blocks) {
    std::vector<Facing> facings;
    for (const TileBlock& block : blocks)
        addFacings(block, facings);
    return levelled(uprightOfCameras(images), facings);
}

/// Heights of some of the samples above the world's origin, ascending.
std::vector<double> heightsOf(const std::vector<TileBlock>& blocks, const glm::dvec3& up) {
    constexpr std::size_t kStep = 97; // samples are far more than a floor needs
    std::vector<double> heights;
    for (const TileBlock& block : blocks)
        for (const Tile& tile : block.tiles) {
            if (tile.tier != Tier::base) continue;
            for (std::size_t i = 0; i < tile.pointCount; i += kStep) {
                const TileVertex& vertex = block.vertices[tile.firstVertex + i];
                const double disparity = disparityOf(tile, vertex);
                if (!(disparity > 0)) continue;
                const VertexPlace place = placeOf(tile, vertex);
                const glm::dvec3 ray = rayThrough(block.camera, tile.x0 + place.x + 0.5, tile.y0 + place.y + 0.5);
                heights.push_back(glm::dot(up, block.worldFromCamera * (ray / disparity)));
            }
        }
    std::sort(heights.begin(), heights.end());
    return heights;
}

} // namespace

Pose findWalkSpace(const std::vector<SceneImage>& images, const std::vector<TileBlock>& blocks,
                   const glm::dvec3& uprightInWorld, const WalkStart& start) {
    if (images.empty()) return {};
    const glm::dvec3 up =
        glm::length(uprightInWorld) > 0 ? glm::normalize(uprightInWorld) : findUpright(images, blocks);
    const Pose& first = images.at(start.image).worldFromCamera;

    // Level forward of the first camera; one that looks straight down has its image's top ahead.
    glm::dvec3 forward = first.rotation[2] - up * glm::dot(first.rotation[2], up);
    if (glm::length(forward) < 0.05) forward = -first.rotation[1] + up * glm::dot(first.rotation[1], up);
    forward = glm::normalize(forward);
    const glm::dvec3 right = glm::cross(forward, up);

    const std::vector<double> heights = start.eyeMetres ? std::vector<double>() : heightsOf(blocks, up);
    const double eyeHeight = glm::dot(up, first.translation);
    constexpr double kFloorShare = 0.02; // lower samples are strays
    double floor = heights.empty()
                       ? eyeHeight - start.eyeMetres.value_or(1.6)
                       : heights[static_cast<std::size_t>(kFloorShare * static_cast<double>(heights.size()))];
    floor = std::min(floor, eyeHeight);

    Pose worldFromWalk;
    worldFromWalk.rotation = glm::dmat3(right, up, -forward);
    worldFromWalk.translation = first.translation + up * (floor - eyeHeight);
    return inverse(worldFromWalk);
}

} // namespace scene
