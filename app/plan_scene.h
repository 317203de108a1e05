#pragma once
// revisit plan: where the next scans of a scene should stand (scene/plan/next_scan.h), as JSON and as a picture from
// above.

#include "scene/plan/next_scan.h"

#include <filesystem>

namespace app {

struct PlanOptions {
    std::filesystem::path scene;
    std::filesystem::path out; ///< the JSON file; the picture has the same name with .png
    scene::NextScanOptions next;
};

/// Writes both files, and a line for each proposal to stdout. Throws scene::Failure.
void planScene(const PlanOptions& options);

} // namespace app
