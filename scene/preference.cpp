#include "scene/preference.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace scene {

std::optional<int> orderLevelOf(const Tile& tile, const Camera& camera, const Pose& worldFromCamera, const View& eye,
                                const PreferenceOptions& options) {
    if (options.nearBaseline <= 0) {
        if (tile.tier == Tier::base) return 0;
        return std::nullopt;
    }
    const glm::dvec3 eyeFromCamera = eye.worldFromEye.translation - worldFromCamera.translation;
    const glm::dvec3 ray = worldFromCamera.rotation * rayThrough(camera, tile.x0 + 0.5 * tile.width, tile.y0 + 0.5 * tile.height);
    const double disparity = 0.5 * (static_cast<double>(tile.minDisparity) + tile.maxDisparity);
    // Multiplied by disparity, so that what is infinitely far needs no special case: every camera is near for the sky.
    const double distance = glm::length(ray - disparity * eyeFromCamera);
    const double baseline = disparity * glm::length(eyeFromCamera);
    if (baseline > static_cast<double>(options.nearBaseline) * distance) {
        if (tile.tier == Tier::base) return kMaxOrderLevel;
        return std::nullopt;
    }
    const double share = distance > 0 ? baseline / (distance * static_cast<double>(options.nearBaseline)) : 0.0;
    return static_cast<int>(std::lround(std::min(share, 1.0) * options.nearLevels));
}

} // namespace scene
