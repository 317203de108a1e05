#pragma once
// JSON that people write and programs read.

#include <filesystem>

#include <nlohmann/json.hpp>

namespace scene {

/// Throws Failure if there is no such file, or it is not JSON: with the byte where it goes wrong.
nlohmann::json readJsonFile(const std::filesystem::path& path);

} // namespace scene
