#pragma once
// What a scene is and what was built into it.

#include <filesystem>

namespace app {

/// Prints to stdout: for people, or scene.json's content, notes and what is on disk as JSON. Throws scene::Failure.
void printInfo(const std::filesystem::path& scene, bool asJson);

} // namespace app
