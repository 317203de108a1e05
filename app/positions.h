#pragma once
// Which reference positions a build of polygons is asked for.

#include "scene/import/capture.h"

#include <filesystem>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

namespace app {

/// How many, to be spread over free space or to be searched for, or the file that names them; neither: nothing was
/// said.
struct PositionsWish {
    int count = 0;
    std::filesystem::path file;
    bool isSearched = false; ///< count is then the most
};

inline constexpr int kMostSearched = 16; ///< unless --count says otherwise

/// "8", "auto", or the path of a file. Throws CLI::ValidationError for 0 and numbers below.
PositionsWish parsePositions(const std::string& text);

/// Three numbers that are a direction. Throws CLI::ValidationError.
glm::dvec3 parseDirection(const std::vector<double>& numbers);

/// Polygons need positions, and nothing else takes any. Throws scene::Failure.
void checkPositionsWish(const PositionsWish& wish, const scene::Capture& capture);

/// {"positions": [[x, y, z], ...]} in world coordinates. Throws scene::Failure.
std::vector<glm::dvec3> readPositionsFile(const std::filesystem::path& path);

} // namespace app
