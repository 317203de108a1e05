#pragma once
// What an eye was shown, as picture files.

#include "render/readback.h"

#include <filesystem>
#include <string>
#include <vector>

namespace app {

/// FOLDER/NAME.png, and with aux FOLDER/NAME-depth.tiff (float32, metres along z, 0 = nothing) and
/// FOLDER/NAME-class.png (0 background, 1 seen, 2 filled, 3 unseen). Throws scene::Failure.
/// Returns the names of the files.
std::vector<std::string> writePictures(const render::EyeImage& image, const std::filesystem::path& folder,
                                       const std::string& name, bool aux);

} // namespace app
