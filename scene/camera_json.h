#pragma once
// A camera as all our files have it: scene.json, depth images, cameras files.

#include "scene/camera.h"
#include "scene/pose.h"

#include <string>

#include <nlohmann/json.hpp>

namespace scene {

/// The pose as a matrix, 16 numbers row by row.
nlohmann::json rowMajor(const Pose& pose);

/// {"name", "width", "height", "fx", "fy", "cx", "cy", "world_from_camera": [16, row-major]}
nlohmann::json describeCamera(const std::string& name, const Camera& camera, const Pose& worldFromCamera);

} // namespace scene
