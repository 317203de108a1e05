#pragma once
// A scene is put in place of what stands under its name. What stands there may be a scene of before, and nothing else:
// no input, no file that somebody laid into it.

#include <filesystem>
#include <span>

namespace app {

/// Throws scene::Failure where putting a scene under that name would lose what no build can make again: where something
/// stands there that is no scene, an input in it, or a file of another hand.
void checkReplaceable(const std::filesystem::path& output, std::span<const std::filesystem::path> inputs);

/// The folder in which a scene is made before it is put under its name.
std::filesystem::path unfinishedSceneOf(const std::filesystem::path& output);

} // namespace app
