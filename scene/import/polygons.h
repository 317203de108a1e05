#pragma once
// Polygon scenes of other programs (OBJ, glTF, and whatever else Assimp reads).
//
//   axes      as in the file: +Y up for glTF and OBJ, right-handed
//   unit      the file's, taken for the metre; a remark says so where the file has another, or none is likely

#include "scene/polygon_scene.h"

#include <filesystem>

namespace scene {

/// By its ending alone.
bool isPolygonFile(const std::filesystem::path& path);

/// Reads a scene with all that it names in its own folder. Textures that are missing, damaged or outside of that folder
/// are drawn grey and named in a remark; so are corners that are no numbers. Throws Failure: not readable, damaged, no
/// triangle, too large for single precision rays.
PolygonScene readPolygons(const std::filesystem::path& path);

} // namespace scene
