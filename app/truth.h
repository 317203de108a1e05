#pragma once
// Where to look from to measure a scene, and what a camera took there.

#include "app/picture_error.h"
#include "app/view_files.h"

#include <filesystem>
#include <functional>
#include <vector>

namespace app {

/// A camera and how to read what it took (which throws scene::Failure): pictures of many cameras need not be held at
/// once.
struct TruthSource {
    NamedView view;
    std::function<Truth()> read;
};

/// The cameras that were kept out of the scene, from its own folder. Throws scene::Failure if there are none, or the
/// scene was built without their pictures.
std::vector<TruthSource> heldOutTruths(const scene::Scene& scene);

/// The cameras of a cameras file with the pictures beside it: NAME.tiff, a depth image as scenes have them, or
/// NAME.png, .jpg or .jpeg, with NAME-depth.tiff (float32, metres along z, 0 = not known) where there is one, and with
/// NAME-class.png, which says where that depth was seen: what `render --aux` writes. Throws scene::Failure if a camera
/// has neither.
std::vector<TruthSource> truthsBeside(const std::filesystem::path& camerasFile);

} // namespace app
