#pragma once
// What one image saw of a piece of space, without looking at every sample: a pyramid of how far its rays went.
//
//   camera ----------- open ----------|surface        a box is seen whole  (all),  before the nearest of its samples,
//          +-----+                    |                          not at all (none), behind the farthest or outside,
//          | box |   +-----+       +--|--+  +-----+              in part   (part) else
//          +-----+   +-----+       +--|--+  +-----+
//            all       all          part     none

#include "scene/depth_image.h"

#include <functional>
#include <vector>

#include <glm/vec3.hpp>

namespace scene {

enum class Sight { none, part, all };

/// An axis-parallel box in the image's camera coordinates, metres.
struct BoxInCamera {
    glm::dvec3 centre{0.0}, half{0.0};
};

struct BoxSight {
    Sight sight = Sight::none;
    bool hasEdge = false; ///< a silhouette, a drop-out or the image's border is seen within it: space may end openly
};

/// A ray is open up to its sample's surface, without end at disparity 0 (sky), up to a guess of range; where no range
/// was measured and none guessed, or others saw through the sample, it proves nothing.
class OpenSpace {
  public:
    using Companion = std::function<const DepthImage&(std::size_t)>;

    /// Companions: the other images taken from the very same place (faces of one scan). They continue the image past
    /// its borders by an eighth of its size, so that no border runs through space that a scan saw whole. Each is asked
    /// for once, in order, and no longer needed when the next is.
    /// tolerance: relative difference in disparity by which a sample's surface may be farther than it says.
    OpenSpace(const DepthImage& image, std::size_t companions, const Companion& companion, float tolerance);

    /// Whether an image from the same place may see rays past another's borders: not if it has the same borders, or
    /// looks the other way.
    static bool mayContinue(const Camera& camera, const glm::dmat3& worldFromCamera, const Camera& companion,
                            const glm::dmat3& worldFromCompanion);

    /// Conservative: all and none hold for every point of the box.
    BoxSight look(const BoxInCamera& box) const;

    /// Whether a sample's surface lies in the box; looks at every sample seen through it, so it should be small.
    bool holdsSample(const BoxInCamera& box) const;

    /// Metres between neighbouring samples' rays at that depth.
    double spacingAt(double zMetres) const { return zMetres / focal_; }

  private:
    struct Span {
        float nearest, farthest; ///< disparities: most and least of the open ends; infinite where nothing is proved
        bool hasEdge;
    };
    struct Level {
        int width = 0, height = 0;
        std::vector<Span> spans;
    };
    /// The samples seen through a box before the camera, first to last; empty if it is outside the image.
    struct Rectangle {
        int left = 0, top = 0, right = -1, bottom = -1;
        bool isWhole = false; ///< nothing of it is cut off by the image's border
        bool isEmpty() const { return right < left || bottom < top; }
    };
    /// overNear, overFar: disparities of the box's two ends.
    Rectangle rectangleOf(const BoxInCamera& box, double overNear, double overFar) const;
    void continueRim(int margin);
    void continuePast(const DepthImage& image, const DepthImage& companion, int margin);
    void closeGaps();
    void widenToPatches();
    void buildPyramid();

    Camera camera_; ///< with the margin
    double focal_ = 1;
    float tolerance_;
    std::vector<Level> levels_; ///< finest first
};

} // namespace scene
