#pragma once
// A scene is put in place of what stands under its name. What stands there may be a scene of before, and nothing else:
// no input, no file that somebody laid into it.

#include <filesystem>
#include <span>

namespace app {

/// Throws scene::Failure where putting a scene under that name would lose what no build can make again: where something
/// stands there that is no scene, an input in it, or a file of another hand; and where a disk is mounted there.
void checkReplaceable(const std::filesystem::path& output, std::span<const std::filesystem::path> inputs);

/// The folder in which a scene is made before it is put under its name.
std::filesystem::path unfinishedSceneOf(const std::filesystem::path& output);

/// Where a scene of that name goes: a link stays, and what it leads to is replaced.
std::filesystem::path placeOfScene(const std::filesystem::path& output);

/// Puts a whole folder in place of another in one step; nothing else ever stands under the name. Where the file system
/// knows no such step (some of networks), the older one stands beside it for a moment. Throws scene::Failure.
void putInPlace(const std::filesystem::path& part, const std::filesystem::path& output);

} // namespace app
