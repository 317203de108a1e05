#pragma once
// Where to look from, as files say it: cameras files and path files.

#include "scene/scene.h"

#include <filesystem>
#include <string>
#include <vector>

namespace app {

/// A picture to draw: a camera in the world (one eye), or a head between two eyes.
struct NamedView {
    std::string name; ///< becomes a file name
    scene::Camera camera;
    scene::Pose worldFromCamera;
    double seconds = 0;
};

/// Cameras file: {"cameras": [{"name", "width", "height", "fx", "fy", "cx", "cy", "world_from_camera": [16,
/// row-major]}]}. Throws scene::Failure naming the file and the camera.
std::vector<NamedView> readCamerasFile(const std::filesystem::path& path);

/// Path file: {"space": "walk"|"world", "poses": [{"t", "position": [x, y, z], "orientation": [x, y, z, w]}]}. In walk
/// space a head has x right, y up, z back; in world space too, in the world's coordinates. Names are pose-0000, ...;
/// the camera is the one given (cameras look along +z with y down). Throws scene::Failure.
std::vector<NamedView> readPathFile(const std::filesystem::path& path, const scene::Pose& walkFromWorld,
                                    const scene::Camera& camera);

/// The cameras kept out of the scene.
std::vector<NamedView> heldOutViews(const scene::Scene& scene);

} // namespace app
