#pragma once
// How a scene is drawn: what render, walk and measure have in common on the command line.

#include "app/quality_file.h"

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace app {

struct DrawOptions {
    std::string quality = kDefaultPreset;                       ///< a preset, or a file of knobs
    std::vector<std::pair<std::string, nlohmann::json>> turned; ///< knobs of their own options: they win
    double eyeDistanceMetres = 0.063;
    std::filesystem::path polygons;       ///< drawn with the scene; empty: none
    bool hideUnseen = false;              ///< space that nobody observed is shown as emptiness
    double coverageCellMetres = 0;        ///< unseen space by cells no smaller than this; 0: as they were built
    std::size_t memoryBytes = 8ull << 30; ///< what of the scene may be on the device at a time
};

/// Throws scene::Failure.
render::Quality qualityOf(const DrawOptions& options);

} // namespace app
