#pragma once
// How the ray of a sample crosses the surface that another image sees there: which tells of a thin thing, seen from
// both sides, that its two sides are not one surface, however near they are to each other.

#include "scene/depth_image.h"
#include "scene/reprojection.h"

#include <glm/vec2.hpp>

namespace scene {

/// w: of the sighting. upright, change: by how much the sighting's disparity grows with the sample's, and by how much
/// it grows beyond that of the partner's surface there; both relative to themselves, so that the sky needs no special
/// case. Of a plane change is how far the sample's camera stands before it, by how far the partner does.
struct Crossing {
    float w = 0, upright = 0, change = 0;
    glm::vec2 slopes{0}; ///< of the partner's disparity, by pixels across and down

    bool isFromFront() const { return change > 0; }
    /// Surely, and from the side that the partner looks towards: about nothing, noise makes signs of its own, and round
    /// an edge a partner sees another face of the same thing. So who stands ten times nearer to the plane than the
    /// partner on its other side, or looks along it, is not told from one on this side.
    bool isFromBehind() const { return upright < 0 && change < -0.1f; }
};

/// x, y, disparity: of the sample; at: where the partner sees it, on a smooth surface (Comparison::isSmooth).
Crossing crossingOf(const DepthImage& partner, const Reprojection& into, float x, float y, float disparity,
                    const Sighting& at, float sameSurface);

} // namespace scene
