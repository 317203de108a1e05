#pragma once
// Depth images whose every sample is known: a furnished room, and a plane. World: y down, as a level camera
// sees it.

#include "scene/coverage.h"
#include "scene/depth_image.h"
#include "scene/polygon_scene.h"
#include "scene/tile.h"
#include "scene/view.h"

#include <array>
#include <vector>

namespace render {

/// A camera of that size with a horizontal field of view in radians, looking through its middle.
scene::Camera cameraOf(int width, int height, double horizontalFieldOfView);

/// Turned to the right by yaw and down by pitch (radians), at a place in the world (metres).
scene::Pose poseAt(const glm::dvec3& pInWorld, double yaw, double pitch);

/// What a camera takes of a room 8 m wide (x), 3 m high (y) and 6 m deep (z) around the origin, with four
/// balls in it. Triangles that bridge two surfaces are marked as skins. offset moves room and camera
/// together.
scene::DepthImage takeRoom(const scene::Camera& camera, const scene::Pose& worldFromCamera,
                           const glm::dvec3& offset = glm::dvec3(0));

/// A plane dot(normal, pInCamera) = distance before a camera at the origin; colour tells the pixel.
scene::DepthImage takePlane(const scene::Camera& camera, const glm::dvec3& normal, double distance);

/// Depth images cut into tiles, kept together with what lends them.
struct CutScene {
    std::vector<scene::DepthImage> images;
    std::vector<scene::TileSet> sets;
    std::vector<scene::TileBlock> blocks() const;
};
CutScene cut(std::vector<scene::DepthImage> images, int tileSize = scene::kDefaultTileSize);
/// With coarser levels and facets.
CutScene cutInLevels(std::vector<scene::DepthImage> images);

/// Six square faces from the middle of the room, size pixels wide.
CutScene roomFromWithin(int size, int tileSize = scene::kDefaultTileSize);

/// The room from three places near its middle, 0.4 and 0.25 m apart.
std::vector<scene::DepthImage> roomFromThreePlaces();

/// The same; of what the second and third took a quarter stands in the directional tier, a quarter are guesses, a
/// quarter is closed.
CutScene roomInAllTiers();

/// Polygons: a rectangle from a corner along two edges, of one material.
scene::PolygonScene rectangle(const glm::vec3& corner, const glm::vec3& across, const glm::vec3& down,
                              const glm::vec3& colour = glm::vec3(0.5f));

/// The coverage's cube at these places in a cube that has room for 4^levels of them along each edge: nobody saw what is
/// not taken.
scene::Coverage coverageManyTimes(const scene::Coverage& part, const std::vector<std::array<int, 3>>& places,
                                  const glm::dvec3& cornerInWorld, int levels = 1);

/// Samples of all blocks that the points warp draws.
std::size_t pointsOf(const CutScene& scene);

} // namespace render
