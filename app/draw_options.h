#pragma once
// How a scene is drawn: what render and walk have in common on the command line.

#include "render/quality.h"
#include "scene/scene.h"

#include <filesystem>
#include <string>

namespace app {

struct DrawOptions {
    std::string warp = "points"; ///< points or mesh
    double eyeDistanceMetres = 0.063;
    double nearBaseline = scene::PreferenceOptions{}.nearBaseline;
    bool hideUnseen = false;
    int maxFootprint = 0;                 ///< 0: as Quality has it
    std::size_t memoryBytes = 8ull << 30; ///< what the scene may take on the device
};

render::Quality qualityOf(const DrawOptions& options);

/// All tiles are made resident: what they take must be allowed before it is taken. Throws scene::Failure.
void checkMemory(const scene::Scene& scene, const DrawOptions& options);

} // namespace app
