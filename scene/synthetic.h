#pragma once
// Synthetic scenes of known truth: furnished, lit and textured places whose every surface has an exact
// equation, so that whatever is built from pictures or scans of them can be judged.
//
// World coordinates: metres, right-handed, +Z up, the floor or road at z = 0. Light is diffuse and fixed, so
// a point of a surface has one colour, from wherever it is seen. The sky has a colour but is no surface: a
// camera sees it (kNoSurface, disparity 0), a scanner gets nothing back from it. Everything follows from the
// seed: the same bytes on every run and any number of threads.

#include "scene/depth_image.h"
#include "scene/scan.h"
#include "scene/view.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

namespace scene {

struct SyntheticModel;
class SyntheticTracer;

/// A model that can be looked at. Build your own (scene/synthetic_model.h) or take one below. It is lit when a colour
/// is first asked for; until then scans without colour, and whatever else asks for surfaces alone, do not wait for
/// that.
class SyntheticScene {
  public:
    explicit SyntheticScene(SyntheticModel model);
    ~SyntheticScene();
    SyntheticScene(SyntheticScene&&) noexcept;
    SyntheticScene& operator=(SyntheticScene&&) noexcept;

    /// What light maps hold is only to be read through litModel.
    const SyntheticModel& model() const { return *model_; }
    /// Any number of threads may ask at the same time.
    const SyntheticModel& litModel() const;
    const SyntheticTracer& tracer() const { return *tracer_; }

  private:
    std::unique_ptr<SyntheticModel> model_;
    std::unique_ptr<SyntheticTracer> tracer_;
    struct LitOnce;
    std::unique_ptr<LitOnce> litOnce_;
};

/// A living room of 5.2 x 4.2 x 2.7 m with its window open to the sky: table and chairs, shelf with books,
/// sofa, rug, pictures of fine detail, a glass-like sphere on a pedestal, a plant.
SyntheticScene makeRoom(std::uint32_t seed = 1);

/// A crossing of two streets in the sun with two cars that have just collided, houses, kerbs, poles, trees
/// and hedges.
SyntheticScene makeStreetCorner(std::uint32_t seed = 1);

/// A corridor of 26 x 2.6 x 2.9 m whose pillars, doors and lamps repeat; only small things tell its parts
/// from each other.
SyntheticScene makeCorridor(std::uint32_t seed = 1);

/// The three by name: room, corner, corridor; nothing for any other name.
std::optional<SyntheticScene> makeSyntheticScene(const std::string& name, std::uint32_t seed = 1);

/// Where a ray ends.
struct Hit {
    glm::dvec3 position{0.0}; ///< in the world
    glm::dvec3 normal{0.0};   ///< of the surface, unit, towards the ray's origin
    double distanceMetres = 0;
};

/// The first surface on a ray; nothing if it ends in the sky. direction need not be a unit vector but must
/// not be zero.
std::optional<Hit> castRay(const SyntheticScene& scene, const glm::dvec3& originInWorld, const glm::dvec3& direction);

/// The colour of what a ray ends at, the sky too, as renderTruth shows it at one sample for each pixel.
Rgb8 colourAlong(const SyntheticScene& scene, const glm::dvec3& originInWorld, const glm::dvec3& direction);

/// What a perfect camera with depth sees. disparity and flags belong to the ray through the pixel's centre,
/// with the intersection computed in double precision; colour is the mean over samplesPerPixel rays spread
/// over the pixel (1: the centre's). The image bears the scene's name. Where the centre sees sky: its colour,
/// disparity 0 and kNoSurface.
DepthImage renderTruth(const SyntheticScene& scene, const View& view, int samplesPerPixel = 1);

/// 640 x 480 with 90 degrees across: a wide look round.
Camera walkCamera();

/// 640 x 480 with 63 degrees across, as hand-held depth cameras have.
Camera captureCamera();

/// A smooth walk through the scene at eye height (1.6 m), looking ahead and at what there is to see; count
/// views evenly spread over it. It keeps clear of all surfaces. Camera axes (x right, y down, z forward).
std::vector<View> walkPath(const SyntheticScene& scene, int count, const Camera& camera = walkCamera());

/// The poses of a hand-held depth camera that is turned about while its bearer walks through the scene:
/// neighbours overlap and all directions are covered.
std::vector<View> captureViews(const SyntheticScene& scene, int count, const Camera& camera = captureCamera());

/// Distance to the nearest surface, looking in 64 directions around a point; large where there is only sky.
double clearanceAt(const SyntheticScene& scene, const glm::dvec3& pInWorld);

/// Where a scanner on a tripod would be set up: axes parallel to the world's, heights between 1.4 and 1.8 m.
std::vector<Pose> scanPositions(const SyntheticScene& scene);

struct ScanOptions {
    double topRadians = 1.5707963267948966;     ///< elevation of the upper edge of the first row
    double bottomRadians = -1.0471975511965976; ///< and of the lower edge of the last: below stands the tripod
    double rangeNoiseMetres = 0;                ///< standard deviation along the ray
    std::uint32_t noiseSeed = 1;
    bool withColour = true;
};

/// An ideal scan on a spherical grid about the scanner's z axis. The ray of a cell goes through its middle:
/// row r from top to bottom at elevation top - (r + 1/2) (top - bottom) / rows, column c clockwise seen from
/// above at azimuth
/// -(c + 1/2) 2 pi / columns from the scanner's x axis. Cells that see sky are absent.
Scan simulateScan(const SyntheticScene& scene, const Pose& worldFromScanner, int columns, int rows,
                  const ScanOptions& options = {});

} // namespace scene
