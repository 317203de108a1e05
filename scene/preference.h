#pragma once
// Which of several samples of one surface is shown. Registered images are off by millimetres, and appearance depends on
// direction: of samples that mean the same surface the one taken from nearest to the eye looks best, and the one
// sampled best often does not.
//
// The z-buffer orders by disparity. A tile's samples enter it pushed back by an order level, in the manner of Nyland et
// al. 1999, section 5.3 (Z' = Z + k area, composition by confidence), so that composition stays independent of order;
// the level is stored in the key and taken back when depth is read, so what is shown stands at its measured depth.
// Tiles taken from near the eye are pushed by little; the others by kMaxOrderLevel, up to twice their depth. What is
// pushed can then be hidden by a surface behind it, but only by one that a camera near the eye saw, and so saw nothing
// before it: the error is the parallax between that camera and the eye, at most nearBaseline / 2 of the depth.

#include "scene/tile.h"
#include "scene/view.h"

#include <optional>

namespace scene {

inline constexpr int kMaxOrderLevel = 63;

/// Depth at order level L is multiplied by 1 + L / kMaxOrderLevel in the z-buffer's order.
inline float orderScale(int level) {
    return 1.f + static_cast<float>(level) / static_cast<float>(kMaxOrderLevel);
}

struct PreferenceOptions {
    /// A camera is near the eye, for a surface, if it stands no farther from the eye than this share of the eye's
    /// distance to the surface. Directional tiles and guesses are drawn only where their camera is near. 0: plain z
    /// order, base tiles alone.
    float nearBaseline = 0.07f;
    int nearLevels = 6; ///< order levels over which near cameras are told apart
    /// Composition by confidence (Nyland et al. 1999, section 5.3): samples are pushed back by so many levels more for
    /// each square pixel that one covers in the eye's image, so that of two scans of a surface the better sampled one
    /// is shown. 0: not.
    float areaLevels = 0;
    int maxAreaLevels = 24; ///< at most
    int guessLevels =
        3; ///< guesses of range are pushed back by so many more: what was measured about there comes first
    friend bool operator==(const PreferenceOptions&, const PreferenceOptions&) = default;
};

/// Where a tile's middle is, for a camera: rayInWorld is the ray of depth 1 through it, turned into the world;
/// disparity in 1/m.
struct TileMiddle {
    Tier tier = Tier::base;
    glm::dvec3 rayInWorld{0};
    double disparity = 0;
};

TileMiddle middleOf(const Tile& tile, const Camera& camera, const Pose& worldFromCamera);

/// The tile's order level for an eye that stands eyeFromCamera (metres, in the world) away from its camera; nothing if
/// it is not drawn.
std::optional<int> orderLevelOf(const TileMiddle& middle, const glm::dvec3& eyeFromCamera,
                                const PreferenceOptions& options);

/// A level pushed back by what a sample's projected area (square pixels, scene/footprint.h) adds.
int withArea(int level, double areaInEye, const PreferenceOptions& options);

/// How far from the camera the tile's middle is, metres: infinite for the sky.
double reachOf(const TileMiddle& middle);

/// Whether an eye may be near (as above) for any tile within reach of a camera so far away: for passing over many tiles
/// at once.
bool mayBeNear(double metresFromCamera, double reachMetres, const PreferenceOptions& options);

/// The same as above, all at once.
std::optional<int> orderLevelOf(const Tile& tile, const Camera& camera, const Pose& worldFromCamera, const View& eye,
                                const PreferenceOptions& options);

} // namespace scene
