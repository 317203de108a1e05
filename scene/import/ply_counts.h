#pragma once
// A PLY file's header, looked at before Assimp is: it takes memory for as many elements as the header claims.

#include <filesystem>

namespace scene {

/// Throws Failure if the file is too short for the elements that its header claims. Whatever else is wrong with it, or
/// is no PLY at all, is left to Assimp.
void checkPlyCounts(const std::filesystem::path& path);

} // namespace scene
