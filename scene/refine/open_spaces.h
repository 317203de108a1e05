#pragma once
// The open space of all images of a build, one image after another.

#include "scene/image_store.h"
#include "scene/refine/open_space.h"

#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace scene {

/// Images from the very same place (the faces of a scan, and their layers) come one after another, so that each is read
/// once to be looked at, and once for as many rims of its place as there is room for, not once for each.
class OpenSpaces {
  public:
    /// tolerance: of OpenSpace. bodies: of each image, metres (OpenSpace's bodyMetres); of those from one place the
    /// least counts for all.
    OpenSpaces(ImageStore& images, float tolerance, std::span<const double> bodies);

    /// Both are valid until it returns. False: no further image is wanted.
    using Visit = std::function<bool(const DepthImage&, const OpenSpace&)>;
    /// Always in the same order, in which places that are neighbours in the capture, which see the same, come far
    /// apart. One image is held at a time; beside the store's budget there are rims of no more than half of it, or
    /// one, and the buffers of one open space.
    void forEach(const Visit& visit);

    /// That the open space of the largest of these takes.
    static std::size_t bytesOfBuffers(std::span<const StoredImage> images);

  private:
    /// One direction from a place; images: by number.
    struct Face {
        Camera camera;
        glm::dmat3 worldFromFace{1.0};
        std::vector<std::size_t> images;
    };
    struct Place {
        std::vector<Face> faces;
        double bodyMetres = 0;
    };
    bool visitPlace(const Place& place, const Visit& visit);
    /// Of those faces; none where no other face may show anything of it.
    std::vector<std::optional<Rim>> rimsOf(const Place& place, std::size_t first, std::size_t end);

    ImageStore& images_;
    std::vector<Place> places_;
    float tolerance_;
    OpenSpace::Buffers buffers_;
};

} // namespace scene
