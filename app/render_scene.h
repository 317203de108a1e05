#pragma once
// Draws a scene without a display, along a path or from given cameras, into picture files.

#include "app/draw_options.h"

#include <filesystem>

namespace app {

struct RenderOptions {
    std::filesystem::path scene, out, path, cameras; ///< path or cameras; neither: the held-out cameras
    int width = 0, height = 0;                       ///< 0: the cameras' own; 640x480 for paths
    int eyes = 0;                                    ///< 0: one for cameras, two for paths
    bool aux = false;
    bool showsCells = false; ///< walk cells are drawn over the pictures
    DrawOptions draw;
};

/// Throws scene::Failure.
void renderScene(const RenderOptions& options);

} // namespace app
