#pragma once
// What the other faces of a scan see past one face's borders: a scan saw the space about it whole, whatever borders its
// faces were cut along.
//
//   +-------------------+        face    of width samples: one direction, one or more images (layers)
//   |  rim              |        margin  an eighth of width, two at least
//   |   +-----------+   |        rim     rays between the face's borders and those of the face widened by the margin
//   |   |   face    |   |
//   |   +-----------+   |
//   +-------------------+

#include "scene/depth_image.h"

#include <limits>
#include <vector>

namespace scene {

/// How far a ray was open.
struct RayEnd {
    static constexpr float kNothing = std::numeric_limits<float>::infinity();
    float disparity = kNothing; ///< 1/m along the axis of the image it is looked at in; kNothing if it proves nothing
    bool isEdge = true;         ///< a silhouette, a drop-out or a border is beside it
    bool provesSomething() const { return disparity < kNothing; }
};

/// The ray of that sample. Those of the last column and row are edges: what is beyond them is not in the image.
RayEnd rayEndOf(const DepthImage& image, int x, int y);

class Rim {
  public:
    /// worldFromFace: the face's rotation.
    Rim(const Camera& face, const glm::dmat3& worldFromFace);

    /// Whether a camera in the same place may see rays of the rim: not if it has the same borders as the face, or looks
    /// the other way.
    static bool mayShow(const Camera& face, const glm::dmat3& worldFromFace, const Camera& other,
                        const glm::dmat3& worldFromOther);

    /// Takes those rays that no image before this one proved anything about. image: from the same place.
    void take(const DepthImage& image);

    /// The face's with the margin.
    const Camera& widened() const { return widened_; }
    int margin() const { return margin_; }
    /// Samples by which a face is widened to each side.
    static int marginOf(const Camera& face);
    /// Of a sample of the widened camera that is outside the face.
    RayEnd at(int x, int y) const;
    /// Of memory, for one of that face.
    static std::size_t bytesOf(const Camera& face);

  private:
    bool crossesFace(int y) const { return y >= margin_ && y < widened_.height - margin_; }
    std::size_t indexOf(int x, int y) const;

    int margin_;
    Camera widened_;
    glm::dmat3 worldFromFace_;
    std::vector<float> disparities_; ///< row after row, of rows that cross the face what is left and right of it
    std::vector<std::uint8_t> edges_;
};

} // namespace scene
