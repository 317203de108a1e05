#pragma once
// Draws a scene without a display, along a path or from given cameras, into picture files.

#include "scene/preference.h"

#include <filesystem>
#include <string>

namespace app {

struct RenderOptions {
    std::filesystem::path scene, out, path, cameras; ///< path or cameras; neither: the held-out cameras
    int width = 0, height = 0;                       ///< 0: the cameras' own; 640x480 for paths
    int eyes = 0;                                    ///< 0: one for cameras, two for paths
    bool aux = false;
    std::string warp = "points"; ///< points or mesh
    double eyeDistanceMetres = 0.063;
    double nearBaseline = scene::PreferenceOptions{}.nearBaseline;
    int maxFootprint = 0;                 ///< 0: as Quality has it
    std::size_t memoryBytes = 8ull << 30; ///< what the scene may take on the device
};

/// Throws scene::Failure.
void renderScene(const RenderOptions& options);

} // namespace app
