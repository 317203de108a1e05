#pragma once
// Shapes a walker is shown over the scene: the floor, where a step would lead, what was measured, who took the
// pictures. All sizes in metres; each function appends to the overlay and keeps nothing.

#include "app/selection.h"

#include "render/overlay.h"
#include "scene/pose.h"
#include "scene/scene.h"

#include <span>

namespace app {

inline constexpr scene::Rgb8 kAllowedColour{70, 230, 110}, kRefusedColour{255, 80, 60}, kMarkColour{255, 210, 60},
    kGridColour{150, 200, 255}, kCameraColour{255, 150, 220};

/// Lines a metre apart, on whole metres of walk space, at that height above its floor, out to radius around a place;
/// they fade towards there, and show a little through what lies on the floor.
void addFloorGrid(render::Overlay& overlay, const scene::Pose& worldFromWalk, const glm::dvec3& aroundInWalk,
                  double height = 0, double radius = 6);

/// The beam by its points, and a ring of that radius on the floor at its last one.
void addTeleport(render::Overlay& overlay, std::span<const glm::dvec3> beamInWorld, const glm::dvec3& upInWorld,
                 bool isAllowed, double ringRadius = 0.25);

/// Three bars that cross at a point, along the axes of walk space.
void addCross(render::Overlay& overlay, const scene::Pose& worldFromWalk, const glm::dvec3& atInWorld,
              scene::Rgb8 colour = kMarkColour, double size = 0.06);

/// A ring round a point of a surface, and a needle along its normal (unit); a zero normal leaves a cross.
void addAim(render::Overlay& overlay, const scene::Pose& worldFromWalk, const glm::dvec3& atInWorld,
            const glm::dvec3& normalInWorld, scene::Rgb8 colour, double radius = 0.02);

/// A line between two points with a bar at each end and a small one at each whole metre, or at each tenth of a metre of
/// lengths up to 2 m.
void addDistance(render::Overlay& overlay, const scene::Pose& worldFromWalk, const glm::dvec3& fromInWorld,
                 const glm::dvec3& toInWorld, scene::Rgb8 colour = kMarkColour);

/// The cameras that took the images, nearest to a place first and no more than so many: what they see up to a depth of
/// size, with a roof over the upper edge.
void addCameras(render::Overlay& overlay, std::span<const scene::SceneImage> images, const glm::dvec3& aroundInWorld,
                double size = 0.15, std::size_t most = 500);

/// Walk cells (scene/plan/walk_cells.h): their edges, nearest to a place first and no more than so many, the walker's
/// own cell brighter; a mark at each position, with the share of its images that is drawn, if any is. Cells that lie in
/// a plane would be seen edge-on by a walker of that height: what is flat is drawn kFlatCellsLowerMetres lower.
void addCells(render::Overlay& overlay, const scene::Pose& worldFromWalk, const Selection& selection,
              const glm::dvec3& aroundInWorld, std::size_t most = 500);
inline constexpr double kFlatCellsLowerMetres = 1.2;

/// A held controller: its handle from the grip backwards, and the ray it aims along -Z, so long. Zero: no ray.
void addController(render::Overlay& overlay, const scene::Pose& worldFromAim, double rayLength,
                   scene::Rgb8 colour = kGridColour);

} // namespace app
