#pragma once
// Draws a scene without a display, along a path or from given cameras, into picture files.

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
    double nearBaseline = -1;    ///< below 0: as Quality has it
    int maxFootprint = 0;        ///< 0: as Quality has it
};

/// Throws scene::Failure.
void renderScene(const RenderOptions& options);

} // namespace app
