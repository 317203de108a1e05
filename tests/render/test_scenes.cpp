#include "tests/render/test_scenes.h"

#include "scene/coverage_levels.h"

#include "scene/pyramid.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

namespace render {

namespace {

struct Hit {
    double t = std::numeric_limits<double>::infinity(); ///< of the ray origin + t direction
    int surface = -1;
};

struct Ball {
    glm::dvec3 centre;
    double radius;
};
const std::array<Ball, 4> kBalls{
    {{{1.5, 0.9, 1.8}, 0.6}, {{-2.0, 0.2, 1.2}, 0.45}, {{0.3, -0.4, 2.3}, 0.3}, {{2.5, 0.5, -1.5}, 0.7}}};
const glm::dvec3 kRoomHalf{4.0, 1.5, 3.0};

/// From inside the room, whose walls are surfaces 0 to 5.
Hit castIntoRoom(const glm::dvec3& from, const glm::dvec3& direction) {
    Hit hit;
    for (int axis = 0; axis < 3; ++axis) {
        if (direction[axis] == 0) continue;
        const double wall = direction[axis] > 0 ? kRoomHalf[axis] : -kRoomHalf[axis];
        const double t = (wall - from[axis]) / direction[axis];
        if (t < hit.t) hit = {t, 2 * axis + (direction[axis] > 0 ? 1 : 0)};
    }
    for (std::size_t i = 0; i < kBalls.size(); ++i) {
        const glm::dvec3 toCentre = kBalls[i].centre - from;
        const double a = glm::dot(direction, direction), b = glm::dot(direction, toCentre);
        const double c = glm::dot(toCentre, toCentre) - kBalls[i].radius * kBalls[i].radius;
        const double root = b * b - a * c;
        if (root <= 0) continue;
        const double t = (b - std::sqrt(root)) / a;
        if (t > 0 && t < hit.t) hit = {t, 6 + static_cast<int>(i)};
    }
    return hit;
}

std::uint8_t byteOf(double value) {
    return static_cast<std::uint8_t>(std::clamp(std::lround(value), 0L, 255L));
}

/// Boards of 25 cm, each surface with its own tint, and a fine ripple that shows where samples lie.
scene::Rgb8 paint(int surface, const glm::dvec3& p) {
    const auto board = [](double v) { return static_cast<int>(std::floor(v * 4 + 0.1)); };
    const bool light = ((board(p.x) + board(p.y) + board(p.z)) & 1) == 0;
    const double ripple = 20 * std::sin(p.x * 31) * std::sin(p.y * 29) * std::sin(p.z * 37);
    const double base = light ? 200 : 120;
    return {byteOf(base + ripple - 20 * (surface % 3)), byteOf(base + ripple - 15 * (surface % 4)),
            byteOf(base + ripple - 25 * (surface % 2))};
}

} // namespace

scene::Camera cameraOf(int width, int height, double horizontalFieldOfView) {
    const double f = width / 2.0 / std::tan(horizontalFieldOfView / 2);
    return {width, height, f, f, width / 2.0, height / 2.0};
}

scene::Pose poseAt(const glm::dvec3& pInWorld, double yaw, double pitch) {
    const double cy = std::cos(yaw), sy = std::sin(yaw), cp = std::cos(pitch), sp = std::sin(pitch);
    const glm::dmat3 turned(glm::dvec3(cy, 0, -sy), glm::dvec3(0, 1, 0), glm::dvec3(sy, 0, cy));
    const glm::dmat3 bent(glm::dvec3(1, 0, 0), glm::dvec3(0, cp, -sp), glm::dvec3(0, sp, cp));
    return {turned * bent, pInWorld};
}

scene::DepthImage takeRoom(const scene::Camera& camera, const scene::Pose& worldFromCamera, const glm::dvec3& offset) {
    scene::DepthImage image;
    image.name = "room";
    image.camera = camera;
    image.worldFromCamera = {worldFromCamera.rotation, worldFromCamera.translation + offset};
    image.colour = {camera.width, camera.height};
    image.disparity = {camera.width, camera.height};
    image.flags = {camera.width, camera.height};
    scene::Image<int> surfaces(camera.width, camera.height);
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x) {
            const glm::dvec3 direction = worldFromCamera.rotation * rayThrough(camera, x + 0.5, y + 0.5);
            const Hit hit = castIntoRoom(worldFromCamera.translation, direction);
            image.disparity(x, y) = static_cast<float>(1 / hit.t);
            image.colour(x, y) = paint(hit.surface, worldFromCamera.translation + hit.t * direction);
            surfaces(x, y) = hit.surface;
        }
    for (int y = 0; y + 1 < camera.height; ++y)
        for (int x = 0; x + 1 < camera.width; ++x) {
            // Walls meet in corners, which the mesh may round off; balls stand before them.
            const auto bridge = [&](int a, int b, int c) { return (a > 5 || b > 5 || c > 5) && (a != b || b != c); };
            const int topRight = surfaces(x + 1, y), bottomLeft = surfaces(x, y + 1);
            if (bridge(surfaces(x, y), topRight, bottomLeft)) image.flags(x, y) |= scene::kSkinUpper;
            if (bridge(topRight, surfaces(x + 1, y + 1), bottomLeft)) image.flags(x, y) |= scene::kSkinLower;
        }
    return image;
}

scene::DepthImage takePlane(const scene::Camera& camera, const glm::dvec3& normal, double distance) {
    scene::DepthImage image;
    image.name = "plane";
    image.camera = camera;
    image.colour = {camera.width, camera.height};
    image.disparity = {camera.width, camera.height};
    image.flags = {camera.width, camera.height};
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x) {
            image.disparity(x, y) =
                static_cast<float>(glm::dot(normal, rayThrough(camera, x + 0.5, y + 0.5)) / distance);
            image.colour(x, y) = {static_cast<std::uint8_t>(x & 255), static_cast<std::uint8_t>(y & 255),
                                  static_cast<std::uint8_t>(128 + (x >> 8) + 4 * (y >> 8))};
        }
    return image;
}

std::vector<scene::TileBlock> CutScene::blocks() const {
    std::vector<scene::TileBlock> lent;
    for (std::size_t i = 0; i < images.size(); ++i)
        lent.push_back(scene::lend(sets[i], images[i].camera, images[i].worldFromCamera));
    for (scene::TileBlock& block : lent)
        block.samplesInWorld =
            scene::boxAroundSamples(block, static_cast<double>(scene::PyramidOptions{}.facetTolerance));
    return lent;
}

CutScene cut(std::vector<scene::DepthImage> images, int tileSize) {
    CutScene scene;
    scene.images = std::move(images);
    for (const scene::DepthImage& image : scene.images)
        scene.sets.push_back(scene::cutIntoTiles(image, tileSize));
    return scene;
}

CutScene cutInLevels(std::vector<scene::DepthImage> images) {
    CutScene scene;
    scene.images = std::move(images);
    for (const scene::DepthImage& image : scene.images)
        scene.sets.push_back(scene::cutIntoLevels(image, {}));
    return scene;
}

CutScene roomFromWithin(int size, int tileSize) {
    const double quarter = std::acos(0.0);
    const scene::Camera camera = cameraOf(size, size, quarter);
    std::vector<scene::DepthImage> images;
    for (int turn = 0; turn < 4; ++turn)
        images.push_back(takeRoom(camera, poseAt({0.2, 0.1, -0.3}, turn * quarter, 0)));
    for (const int tilt : {-1, 1})
        images.push_back(takeRoom(camera, poseAt({0.2, 0.1, -0.3}, 0, tilt * quarter)));
    return cut(std::move(images), tileSize);
}

scene::PolygonScene rectangle(const glm::vec3& corner, const glm::vec3& across, const glm::vec3& down,
                              const glm::vec3& colour) {
    scene::PolygonScene polygons;
    polygons.materials.push_back({.name = "paint", .baseColour = colour});
    scene::PolygonMesh mesh;
    mesh.positions = {corner, corner + across, corner + across + down, corner + down};
    mesh.texturePlaces = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    polygons.meshes.push_back(mesh);
    polygons.instances.push_back({0, glm::dmat4(1.0)});
    return polygons;
}

std::size_t pointsOf(const CutScene& scene) {
    std::size_t points = 0;
    for (const scene::TileSet& set : scene.sets)
        for (const scene::Tile& tile : set.tiles)
            points += tile.pointCount;
    return points;
}

std::vector<scene::DepthImage> roomFromThreePlaces() {
    std::vector<scene::DepthImage> images;
    for (const double x : {-0.3, 0.1, 0.35})
        images.push_back(takeRoom(cameraOf(200, 150, 1.4), poseAt({x, 0.1 * x, 0.2}, 0.4 * x, 0.05)));
    return images;
}

CutScene roomInAllTiers() {
    constexpr std::array<unsigned, 4> kTierFlags{0, scene::kDirectional, scene::kNoSurface | scene::kInterpolated,
                                                 scene::kInterpolated};
    std::vector<scene::DepthImage> images = roomFromThreePlaces();
    std::mt19937 random(5);
    for (std::size_t i = 1; i < images.size(); ++i)
        for (std::uint8_t& flags : images[i].flags.pixels())
            flags = static_cast<std::uint8_t>(flags | kTierFlags[random() % kTierFlags.size()]);
    return cut(std::move(images));
}

scene::Coverage coverageManyTimes(const scene::Coverage& part, const std::vector<std::array<int, 3>>& places,
                                  const glm::dvec3& cornerInWorld, int levels) {
    scene::Coverage all{cornerInWorld, std::exp2(2 * levels) * part.edgeMetres, {}};
    // Cubes above the part's, level by level.
    std::vector<std::array<int, 3>> cubes{{0, 0, 0}};
    for (int level = 0; level < levels; ++level) {
        const int cell = 1 << (2 * (levels - level - 1)); // in cubes of the part
        const std::size_t firstBelow = all.nodes.size() + cubes.size();
        std::vector<std::array<int, 3>> below;
        for (const std::array<int, 3>& cube : cubes) {
            scene::CoverageNode node;
            node.firstChild = static_cast<std::uint32_t>(firstBelow + below.size());
            for (int bit = 0; bit < 64; ++bit) {
                const std::array<int, 3> at{cube[0] + bit % 4 * cell, cube[1] + bit / 4 % 4 * cell,
                                            cube[2] + bit / 16 * cell};
                const auto isIn = [&](const std::array<int, 3>& p) {
                    return p[0] / cell == at[0] / cell && p[1] / cell == at[1] / cell && p[2] / cell == at[2] / cell;
                };
                if (std::none_of(places.begin(), places.end(), isIn)) continue;
                node.children |= scene::coverageMask(bit);
                below.push_back(at);
            }
            node.unseen = ~node.children;
            all.nodes.push_back(node);
        }
        cubes = std::move(below);
    }
    // The part's levels, one after the other, each as often as it stands there.
    const std::vector<std::size_t> firsts = scene::firstNodesOf(part);
    for (std::size_t level = 0; level + 1 < firsts.size(); ++level) {
        const std::size_t count = firsts[level + 1] - firsts[level],
                          below = level + 2 < firsts.size() ? firsts[level + 2] - firsts[level + 1] : 0,
                          firstBelow = all.nodes.size() + count * places.size();
        for (std::size_t copy = 0; copy < places.size(); ++copy) // all alike, so that their order is nothing
            for (std::size_t i = firsts[level]; i < firsts[level + 1]; ++i) {
                all.nodes.push_back(part.nodes[i]);
                if (part.nodes[i].children == 0) continue;
                all.nodes.back().firstChild = static_cast<std::uint32_t>(firstBelow + copy * below +
                                                                         part.nodes[i].firstChild - firsts[level + 1]);
            }
    }
    return all;
}

} // namespace render
