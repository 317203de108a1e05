#pragma once
// What some exporters say of glass in MTL files, and Assimp does not read: opacity as the fourth number of Kd.

#include <filesystem>
#include <map>
#include <string>

namespace scene {

/// By the material's name; only materials that have a fourth number. What else is in the file does not matter.
std::map<std::string, double> readMtlOpacities(const std::filesystem::path& path);

} // namespace scene
