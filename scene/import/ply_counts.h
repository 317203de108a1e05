#pragma once
// A PLY file's header, looked at before Assimp does: it takes memory for as many elements as the header claims, and
// never ends where the header does not.

#include <filesystem>

namespace scene {

/// Throws Failure if the header has no end within 64 KiB, or the file is too short for the elements that it claims.
/// Whatever else is wrong with it, or is no PLY at all, is left to Assimp.
void checkPlyCounts(const std::filesystem::path& path);

} // namespace scene
