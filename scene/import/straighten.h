#pragma once
// A photograph without the distortion of its lens. Nyland et al. 1999, section 4.3.

#include "scene/image.h"
#include "scene/import/camera_file.h"

#include <cstdint>

namespace scene {

struct StraightPicture {
    Image<Rgb8> colour;
    Image<std::uint8_t> isSeen; ///< 0 where the photograph does not reach: there colour is that of its rim
};

/// What a pinhole at the same place sees, whose picture may have another size and reach. Where it is coarser, colours
/// are means over its pixels. The same bytes on any number of threads. picture must have the lens's size.
StraightPicture straightened(const Image<Rgb8>& picture, const CameraFile& lens, const Camera& pinhole);

} // namespace scene
