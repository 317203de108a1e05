#pragma once
// Where a ray meets the scene as it was really seen. No search of its own: a narrow eye looks along the ray, the tiles
// that it may see are warped into its few pixels, and what stands in the middle is hit. What is before it in the ray's
// way is nearest by plain z order, from the base tier, which holds each surface once.

#include "scene/coverage.h"
#include "scene/tile.h"
#include "scene/warp.h"

#include <optional>
#include <span>

namespace scene {

/// direction need not be a unit vector but must not be zero.
struct Ray {
    glm::dvec3 originInWorld{0}, direction{0, 0, 1};
};

struct PickOptions {
    /// Pixels of the narrow eye (an odd number: one looks along the ray), and how far it sees across: over how much of
    /// a surface its normal is taken.
    int pixels = 15;
    double fieldOfViewRadians = 0.026;
    /// How far beside the ray a surface may lie and still be hit, where the ray itself passes through a gap between
    /// samples.
    double snapRadians = 0.004;
    /// Which guesses of range are shown to an eye at the ray's origin, as a renderer would.
    PreferenceOptions shownGuesses;
    /// What of space is shown as unseen, if anything is, and how far an eye in it looks through it: what is hidden by
    /// it is not hit. Lent.
    const Coverage* shownUnseen = nullptr;
    double unseenPocketMetres = 0;
};

struct Pick {
    glm::dvec3 position{0}; ///< in the world, on the ray or snapRadians beside it
    /// Of the surface around it, unit, towards the ray's origin; nothing where too little of it is there to tell.
    std::optional<glm::dvec3> normal;
    double distanceMetres = 0; ///< from the ray's origin
    /// False for a guess of range, and what is closed, which stands nearer than anything that was measured: it must not
    /// be measured with.
    bool isSeen = true;
};

/// Nothing where the ray ends in the sky or first meets what no image has seen. Parallel; the result does not depend on
/// the number of threads.
std::optional<Pick> pick(std::span<const TileBlock> blocks, const Ray& ray, const PickOptions& options = {});

} // namespace scene
