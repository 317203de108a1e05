#pragma once
// A glTF file's nodes, looked at before Assimp goes through them: it follows children by recursion, and draws a child
// of two parents twice, so that a few kilobytes could take any amount of memory.

#include <filesystem>

namespace scene {

/// Throws Failure if a node is a child of two nodes, which glTF forbids, or stands more than `deepest` nodes deep.
/// Whatever else is wrong with the file, or is no glTF at all, is left to Assimp.
void checkGltfNodes(const std::filesystem::path& path, int deepest);

} // namespace scene
