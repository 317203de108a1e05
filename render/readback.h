#pragma once
// An eye's picture, back in the processor's memory.

#include "render/target.h"
#include "scene/image.h"

#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

namespace render {

struct EyeImage {
    scene::Image<scene::Rgb8> colour;
    scene::Image<float> depthMetres;       ///< along z; 0 where there is nothing, infinity for sky
    scene::Image<std::uint8_t> pixelClass; ///< 0 background, 1 seen, 2 filled, 3 unseen
};

/// A frame as its eyes were shown it, for a mirror.
struct FramePictures {
    std::uint64_t frame = 0;
    int width = 0, height = 0;
    std::vector<glm::dvec3> places;               ///< of the eyes, world
    std::vector<std::vector<std::uint32_t>> eyes; ///< r | g << 8 | b << 16 | class << 24 per pixel, row by row
};

/// Copies the picture; the device must have finished it.
EyeImage readBack(const Device& device, const EyeTarget& target, int width, int height);

} // namespace render
