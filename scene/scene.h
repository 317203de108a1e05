#pragma once
// A scene that was built: its images, how walk space lies in the world, and its tiles, mapped from disk.

#include "scene/coverage.h"
#include "scene/mapped_file.h"
#include "scene/tile.h"

#include <atomic>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace scene {

/// An image of the scene by its camera; its pixels stand in images/NAME.tiff.
struct SceneImage {
    std::string name;
    Camera camera;
    Pose worldFromCamera;
    WorldExtent samplesInWorld{}; ///< as in its block
};

/// Owns the mapping that blocks point into; move only.
struct Scene {
    std::filesystem::path folder;
    std::vector<SceneImage> images;
    std::vector<SceneImage> heldOut; ///< cameras kept out of the scene, to compare with
    bool hasWholeImages = false;     ///< each image holds all that it saw: redundancy was not culled
    Pose walkFromWorld;              ///< metres, +Y up, floor at Y = 0, the start at the origin
    std::string manifest;            ///< scene.json as it was written
    MappedFile tilesFile;
    std::vector<std::size_t> damaged; ///< images whose blocks are empty since nobody can read them any more
    std::vector<TileBlock> blocks;    ///< one for each image, in the same order
    std::vector<std::unique_ptr<std::atomic<std::uint8_t>[]>> verdicts; ///< that the blocks point to
    std::optional<Coverage> coverage; ///< what was observed; scenes of before have none
};

/// Where a walk begins.
struct WalkStart {
    std::size_t image = 0;           ///< under which one stands, and where it looks
    std::optional<double> eyeMetres; ///< how high its camera is above the floor, where known: none is looked for then
};

/// Walk space for a capture: up is what the cameras hold upright on average (their x axes lie level), made exact by
/// what floors and walls say (scene/upright.h), the floor is the lowest surface with a fair share of samples, the
/// origin is on the floor under the camera of the start, which looks towards -Z. uprightInWorld: the capture's own up
/// if its format has one (scans: +Z), else zero.
Pose findWalkSpace(const std::vector<SceneImage>& images, const std::vector<TileBlock>& blocks,
                   const glm::dvec3& uprightInWorld, const WalkStart& start = {});

} // namespace scene
