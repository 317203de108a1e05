#pragma once
// What a scan from somewhere would see of the space that nobody has seen yet.
//
// A ray goes through space that was seen empty and ends at the first surface that was seen. Where it enters unseen
// space in between, the scan would see that stretch, as far as it gets: nobody knows what stands there.
//
//     scanner o----empty----|::::unseen:::|--empty--#  surface      the whole stretch, unless something stands in it
//     scanner o----empty----|::::unseen::::::::::::::| bounds       as before; beyond the bounds nothing counts
//     scanner o----empty--#  :::unseen:::                           nothing: surfaces are not looked through
//
// Two things are taken from what was seen, and held to be alike in what was not:
//   free path   how far a ray goes on average before it meets something inside the bounds. In unseen space a ray is
//               still alive after s metres with the chance exp(-s / free path), as in a medium of small obstacles
//               (Beer-Lambert; of rooms: Kuttruff, "Room acoustics", mean free path).
//   echo        a scan learns of a ray's way only if the ray ends at a surface: sky proves nothing. How often rays of
//               an elevation end at one.
// A place r metres away, on a ray that leaves the bounds after R, is then seen with the chance
// alive(r) - alive(R) (1 - echo), and with alive(r) if a surface that was seen ends the ray.

#include "scene/coverage.h"
#include "scene/plan/upright_bounds.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace scene {

/// The scanner: which rays it has.
struct ScanRays {
    double lowestRadians = -1.0471975511965976; ///< elevation; below stands the tripod
    double farthestMetres = 60;                 ///< how far it measures
};

inline constexpr std::size_t kElevationBands = 18; ///< of ten degrees, from straight down to straight up

/// How rays end where it is known.
struct SeenPlace {
    double freePathMetres = 0;                  ///< infinite: nothing stands inside the bounds
    std::array<double, kElevationBands> echo{}; ///< share of rays, by elevation
};

/// From rays about places where scanners (or cameras) stood, world. Parallel; the same on any number of threads.
SeenPlace learnFromSeen(const Coverage& coverage, const UprightBounds& bounds, std::span<const glm::dvec3> stood,
                        const ScanRays& rays);

/// The sphere's part that the rays share, steradians.
double solidAngleOf(const ScanRays& rays);

/// A stretch of unseen space on a ray, metres from its origin.
struct UnseenStretch {
    double from = 0, to = 0;
};

/// One ray through the coverage, to the first surface or out of the bounds.
struct SightLine {
    std::vector<UnseenStretch> unseen;
    double endMetres = 0;
    bool endsAtSurface = false;
};

/// direction: unit, world. line: reused from call to call.
void follow(const Coverage& coverage, const UprightBounds& bounds, const glm::dvec3& origin,
            const glm::dvec3& direction, double farthestMetres, SightLine& line);

/// Of each direction the others within an angle, nearest first.
std::vector<std::vector<std::uint32_t>> neighboursOf(const std::vector<glm::dvec3>& directions, double mostRadians);

/// Surfaces go on behind what hides them: a line that goes through unseen space and meets no surface ends where the
/// nearest line beside it does that ends at a surface behind the place where this one entered. Lines in the order of
/// their directions; those whose neighbours all leave the bounds are as they were. Whether there is an echo stays open.
void continueSurfaces(std::vector<SightLine>& lines, const std::vector<std::vector<std::uint32_t>>& neighbours);

/// The chance that a place on the line is seen by a scan: pass stretches in their order.
class SightChance {
  public:
    SightChance(const SightLine& line, const SeenPlace& seen, double elevationRadians);
    /// At a place of a stretch after so many metres of unseen space on this ray.
    double after(double unseenMetres) const;

  private:
    double freePath_, lost_;
};

} // namespace scene
