#pragma once
// A polygon scene whose every wall is known, as a file.

#include <filesystem>

#include <glm/vec3.hpp>

namespace app {

/// A room of 6 x 3 x 8 m about the middle of its floor, open above, with a solid pillar about (1, 1.5, 1) from there.
void writeRoom(const std::filesystem::path& path, const glm::dvec3& middle = glm::dvec3(0));

} // namespace app
