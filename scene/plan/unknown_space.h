#pragma once
// How much of what a walker would see from somewhere is unknown to the images that are drawn there: the objective of
// the search for reference positions (the article on Delaunay cells, section 5: k_un and k_dist).
//
// Of each image two things are warped into the six faces of a cube about the place: all of its mesh, with the triangles
// that bridge silhouettes, behind which nobody saw; and its samples, as squares, a little nearer. Where the samples are
// in front, that image knows what is seen there. What one image knows is known. The pictures are small: a search asks
// thousands of times.

#include "scene/depth_image.h"
#include "scene/tile.h"

#include <cstdint>
#include <span>
#include <vector>

namespace scene {

struct UnknownSpaceOptions {
    int faceSize = 32;           ///< pixels along a side of the faces about a place
    double nearMetres = 0.3;     ///< k_dist: surfaces nearer than this count against a place
    double samplesNearer = 0.03; ///< relative; so much the samples stand before the mesh they are corners of
};

/// Pixels of the six faces about a place.
struct UnknownCount {
    std::int64_t unknown = 0, near = 0, pixels = 0;
    double objective() const { return static_cast<double>(unknown - near) / static_cast<double>(pixels); }
    double unknownShare() const { return static_cast<double>(unknown) / static_cast<double>(pixels); }
};

class UnknownSpace {
  public:
    explicit UnknownSpace(const UnknownSpaceOptions& options = {}) : options_(options) {}

    /// The images of one position, a few tens of samples wide; their number is that of the calls before. Samples
    /// without surface whose disparity is 0 are sky, which is known to be empty.
    std::uint32_t add(std::span<const DepthImage> faces);
    std::size_t size() const { return sources_.size(); }

    /// What images of these positions know of what is seen from a place (world). May be asked from many threads.
    UnknownCount countAt(const glm::dvec3& place, std::span<const std::uint32_t> positions) const;

    /// Whether some image of these positions saw that a place is empty, by at least that much.
    bool isEmpty(const glm::dvec3& place, std::span<const std::uint32_t> positions, double clearMetres) const;

  private:
    struct Face {
        DepthImage image;
        TileSet mesh; ///< every triangle
    };
    UnknownSpaceOptions options_;
    std::vector<std::vector<Face>> sources_;
};

} // namespace scene
