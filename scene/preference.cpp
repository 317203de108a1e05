#include "scene/preference.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace scene {

TileMiddle middleOf(const Tile& tile, const Camera& camera, const Pose& worldFromCamera) {
    return {tile.tier,
            worldFromCamera.rotation * rayThrough(camera, tile.x0 + 0.5 * tile.width, tile.y0 + 0.5 * tile.height),
            0.5 * (static_cast<double>(tile.minDisparity) + tile.maxDisparity)};
}

double reachOf(const TileMiddle& middle) {
    return glm::length(middle.rayInWorld) / middle.disparity;
}

bool mayBeNear(double metresFromCamera, double reachMetres, const PreferenceOptions& options) {
    const auto share = static_cast<double>(options.nearBaseline);
    return share > 0 && metresFromCamera <= share * (reachMetres + metresFromCamera) * (1 + 1e-9);
}

std::optional<int> orderLevelOf(const Tile& tile, const Camera& camera, const Pose& worldFromCamera, const View& eye,
                                const PreferenceOptions& options) {
    return orderLevelOf(middleOf(tile, camera, worldFromCamera),
                        eye.worldFromEye.translation - worldFromCamera.translation, options);
}

std::optional<int> orderLevelOf(const TileMiddle& middle, const glm::dvec3& eyeFromCamera,
                                const PreferenceOptions& options) {
    if (options.nearBaseline <= 0) {
        if (isForAllEyes(middle.tier)) return 0;
        return std::nullopt;
    }
    // Multiplied by disparity, so that what is infinitely far needs no special case: every camera is near for the sky.
    const double distance = glm::length(middle.rayInWorld - middle.disparity * eyeFromCamera);
    const double baseline = middle.disparity * glm::length(eyeFromCamera);
    if (baseline > static_cast<double>(options.nearBaseline) * distance) {
        // Far images are told apart by their area, too.
        if (isForAllEyes(middle.tier)) return kMaxOrderLevel - (options.areaLevels > 0 ? options.maxAreaLevels : 0);
        return std::nullopt;
    }
    const double share = distance > 0 ? baseline / (distance * static_cast<double>(options.nearBaseline)) : 0.0;
    const int behind = middle.tier == Tier::guess ? options.guessLevels : 0;
    return std::min(static_cast<int>(std::lround(std::min(share, 1.0) * options.nearLevels)) + behind, kMaxOrderLevel);
}

int withArea(int level, double areaInEye, const PreferenceOptions& options) {
    if (options.areaLevels <= 0) return level;
    const double levels =
        std::min(static_cast<double>(options.areaLevels) * areaInEye, static_cast<double>(options.maxAreaLevels));
    return std::min(level + static_cast<int>(std::lround(levels)), kMaxOrderLevel);
}

} // namespace scene
