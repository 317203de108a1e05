#pragma once
// Files and folders that somebody names for results: what stands there may be a result of before, and nothing else.

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace app {

/// Throws scene::Failure where a JSON file of that name would take the place of a folder, of one of the command's own
/// inputs, or of a file that is not of its kind: one whose text isKind does not know. What is no file, as a pipe or a
/// device, is written to (writeWhole).
void checkReplaceableFile(const std::filesystem::path& file, std::span<const std::filesystem::path> inputs,
                          const std::function<bool(const nlohmann::json&)>& isKind);

/// Report of a run that finished there; null if there is none, or another hand's.
nlohmann::json reportIn(const std::filesystem::path& folder, const std::function<bool(const nlohmann::json&)>& isKind);

/// Throws scene::Failure where a run's report would take the place of another hand's.
void checkReplaceableReport(const std::filesystem::path& folder,
                            const std::function<bool(const nlohmann::json&)>& isKind);

/// Throws scene::Failure where what a run writes under these names would take the place of files that no report of such
/// a run speaks of.
void checkReplaceableBeside(const std::filesystem::path& folder,
                            const std::function<bool(const nlohmann::json&)>& isKind,
                            std::span<const std::string> names);

/// Names of the pictures in a folder; none where there is no folder.
std::vector<std::string> picturesIn(const std::filesystem::path& folder);

/// Of a drawn run: `render` and `walk`.
bool isDrawnReport(const nlohmann::json& report);

} // namespace app
