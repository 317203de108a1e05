#pragma once
// Whether one can stand at a place of a polygon scene, by looking round.
//
// A place is inside a solid if at least kSolidShare of the looks in all directions end at the back of a surface. Why a
// share, and why so large: files are seldom closed. A pillar may lack its foot, so that some looks leave it; behind a
// single-sided curtain, wall or ground as many looks as half of them see its back, and one may stand there all the
// same. What the rule cannot know: a room whose every wall faces outward looks like a solid from inside, and is
// refused; a solid whose faces all point inward, or that is drawn from both sides, is taken for a room.

#include "scene/capture/tracer.h"

#include <span>
#include <vector>

namespace scene {

inline constexpr double kSolidShare = 0.75;

/// Looks no steeper than this are level.
inline constexpr double kLevelSine = 0.35;

/// What is about a place.
struct Surroundings {
    double hitShare = 0, backShare = 0; ///< of all looks: those that end on a surface, and on the back of one
    double nearestMetres = 0;           ///< along the looks; infinite if none ends
    double meanMetres = 0;              ///< how far looks go, those into the open not counted; 0 if none ends
    double levelShare = 0;              ///< of the looks about the horizon (kLevelSine): those that end
};

Surroundings lookRound(const PolygonTracer& tracer, const glm::dvec3& positionInWorld, int looks = 256);

inline bool isInsideSolid(const Surroundings& about) {
    return about.backShare >= kSolidShare;
}

/// Throws Failure for the first position that is inside a solid, that sees nothing at all, or that is no place:
/// "position 3 (1 2 3) is inside a solid ...", counted from 0. where: the file that named them.
void checkPositions(const PolygonTracer& tracer, std::span<const glm::dvec3> positionsInWorld,
                    const std::filesystem::path& where);

} // namespace scene
