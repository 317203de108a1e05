#pragma once
// Textures halved again and again, so that a pixel far away gets the mean of what it covers. L. Williams, "Pyramidal
// parametrics", 1983; several looks along the longer side of a slanted pixel's footprint, as graphics cards do.

#include "scene/polygon_scene.h"

#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace scene {

/// What a pixel covers of a texture: two sides of a parallelogram in texture coordinates.
struct TextureFootprint {
    glm::vec2 across{0.0f}, down{0.0f};
};

class TexturePyramid {
  public:
    /// isCutOut: some surface is cut by a mask, so that alpha tells which colours are meant; else alpha means nothing,
    /// and is often 0 all over.
    TexturePyramid(const Image<Rgba8>& picture, bool isCutOut);

    /// The mean linear colour about a place, repeated beyond the edges. A footprint of nothing: bilinear in the picture
    /// itself.
    glm::vec3 colourAt(const glm::vec2& place, const TextureFootprint& footprint) const;

    /// Of the whole picture, linear.
    glm::vec3 mean() const { return mean_; }

  private:
    /// One level, row by row. sRGB, so that 8 bits are enough.
    std::vector<Image<Rgb8>> levels_;
    glm::vec3 mean_{0.0f};
};

} // namespace scene
