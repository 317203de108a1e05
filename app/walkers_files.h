#pragma once
// What walkers left in a scene's folder: it outlives the scene's being built anew.

#include <filesystem>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

namespace app {

/// Notes, and where walks begin. Throws scene::Failure if they cannot be copied.
void carryWalkersFiles(const std::filesystem::path& from, const std::filesystem::path& to);

/// Puts into the new scene.json whether the notes of the scene in that folder are of images that stand elsewhere in the
/// new one, or are not in it (`notes_from_elsewhere`), now or since a build before: what they measured need not be
/// there any more. A sentence for the user then, which is among its remarks, too.
std::optional<std::string> remarkOnNotes(const std::filesystem::path& olderScene, nlohmann::json& manifest);

} // namespace app
