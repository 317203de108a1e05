#pragma once
// What one image saw of a piece of space, without looking at every sample: a pyramid of how far its rays went.
//
//   camera ----------- open ----------|surface        a box is seen whole  (all),  before the nearest of its samples,
//          +-----+                    |                          not at all (none), behind the farthest or outside,
//          | box |   +-----+       +--|--+  +-----+              in part   (part) else
//          +-----+   +-----+       +--|--+  +-----+
//            all       all          part     none

#include "scene/refine/rim.h"

#include <cmath>
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
    /// A disparity, infinite where nothing is proved, and whether an edge is seen there. None is negative: the sign
    /// says the other.
    class End {
      public:
        End() = default;
        End(float disparity, bool hasEdge) : kept_(std::copysign(disparity, hasEdge ? -1.f : 1.f)) {}
        float disparity() const { return std::abs(kept_); }
        bool hasEdge() const { return std::signbit(kept_); }

      private:
        float kept_ = 0;
    };
    struct Span {
        float nearest; ///< disparity: most of the open ends
        End farthest;  ///< least of them; whether any has an edge
    };
    struct Level {
        int width = 0, height = 0;
        std::vector<Span> spans;
        const Span& at(int x, int y) const {
            return spans[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
        }
        Span spanOf(int left, int top, int right, int bottom) const; ///< of all these; the last are among them
    };

  public:
    /// Memory that one image after another uses.
    class Buffers {
      public:
        /// For an image that a rim of so many samples widens to each side.
        static std::size_t bytesOf(const Camera& camera, int margin);

      private:
        friend class OpenSpace;
        std::vector<Level> levels;     ///< finest first
        std::vector<End> ends, closed; ///< of samples, as they are and with gaps closed
    };

    /// rim: null, or what the other faces of the image's scan saw past its borders, so that no border runs through
    /// space that the scan saw whole.
    /// tolerance: relative difference in disparity by which a sample's surface may be farther than it says.
    /// bodyMetres: so far about the camera space is open on all sides, whatever it saw: there it stood.
    /// buffers: of no other that is still looked at; what is made in them is valid until the next is.
    OpenSpace(const DepthImage& image, const Rim* rim, float tolerance, double bodyMetres, Buffers& buffers);
    OpenSpace(const OpenSpace&) = delete;
    OpenSpace& operator=(const OpenSpace&) = delete;

    /// Conservative: all and none hold for every point of the box; but at the rim of the camera's body none may be said
    /// of a small box that is open in part.
    BoxSight look(const BoxInCamera& box) const;

    /// Whether a sample's surface lies in the box; goes down to the samples seen through it.
    bool holdsSample(const BoxInCamera& box) const;

    /// Metres between neighbouring samples' rays at that depth.
    double spacingAt(double zMetres) const { return zMetres / focal_; }

  private:
    BoxSight lookPastBody(const BoxInCamera& box) const;
    /// The samples seen through a box before the camera, first to last; empty if it is outside the image.
    struct Rectangle {
        int left = 0, top = 0, right = -1, bottom = -1;
        bool isWhole = false; ///< nothing of it is cut off by the image's border
        bool isEmpty() const { return right < left || bottom < top; }
    };
    /// overNear, overFar: disparities of the box's two ends.
    Rectangle rectangleOf(const BoxInCamera& box, double overNear, double overFar) const;
    /// The finest at which it is no more than three spans wide and high.
    static std::size_t levelOf(const Rectangle& in);
    /// Of those of that span.
    bool holdsSampleBelow(const Rectangle& in, std::size_t level, int x, int y, float boxNear, float boxFar) const;
    void takeEnds(const DepthImage& image, const Rim* rim);
    void closeGaps();
    void widenToPatches();
    void buildPyramid();

    Camera camera_; ///< with the rim's margin
    double focal_ = 1;
    float tolerance_;
    double bodyMetres_;
    Buffers& buffers_;
};

} // namespace scene
