#pragma once
// Recorded paths: where a head was, and when; the same file leads render, a walk without display, and a walker.
//
//   {"space": "walk"|"world", "poses": [{"t": s, "position": [x, y, z], "orientation": [x, y, z, w], "rig": {...}}]}
//
// "rig" is what a recording adds: where the wearer's room stood (input/rig.h), {"position", "yaw", "scale"}.

#include "input/rig.h"

#include <filesystem>
#include <optional>
#include <vector>

namespace input {

struct PathKey {
    double seconds = 0;
    scene::Pose spaceFromHead;
    std::optional<Rig> rig;
};

enum class PathSpace { walk, world };

struct RecordedPath {
    PathSpace space = PathSpace::walk;
    std::vector<PathKey> keys; ///< in the order of time; at least one
};

/// Throws scene::Failure naming the file and the pose. Poses without t are at 0.
RecordedPath readPath(const std::filesystem::path& file);

/// The text of such a file.
std::string textOf(const RecordedPath& path);

/// Between the keys, smoothly: it passes each key at its time, exactly, and neither place nor orientation jerks there
/// (both have a continuous first derivative). Places follow monotone cubics (Fritsch and Butland, "A method for
/// constructing local monotone piecewise cubic interpolants", 1984): what stood still stays still, and nothing
/// overshoots. Orientations follow cumulative cubic Bezier curves of quaternions (Kim, Kim and Shin, "A general
/// construction scheme for unit quaternion curves", 1995) with angular velocities chosen alike. Two keys of one time
/// are a jump.
class SmoothPath {
  public:
    /// At least one key, in the order of time.
    explicit SmoothPath(const std::vector<PathKey>& keys);

    /// Before the first key, the first; after the last, nothing.
    std::optional<scene::Pose> operator()(double seconds) const;

  private:
    struct Knot {
        double seconds = 0;
        scene::Pose pose;
        glm::dvec4 quaternion{0, 0, 0, 1};      ///< of the pose
        glm::dvec3 velocity{0}, turning{0};     ///< where the piece after it begins: metres and radians a second
        glm::dvec3 velocityTo{0}, turningTo{0}; ///< where the piece before it ends; other than those at a jump
    };
    std::vector<Knot> knots_;
};

} // namespace input
