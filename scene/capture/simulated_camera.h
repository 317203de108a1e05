#pragma once
// A colour camera at the scanner's nodal point in a world that is known: what a real one would have taken there,
// through its lens, with its exposure and its noise. Nyland et al., "The impact of dense range data on computer
// graphics", 1999, section 3.3.

#include "scene/capture/simulated_scan.h"
#include "scene/image.h"
#include "scene/import/camera_file.h"

#include <cstdint>

#include <glm/vec3.hpp>

namespace scene {

struct SimulatedCameraOptions {
    CameraFile lens;
    int raysPerPixel = 8;       ///< where a pixel's neighbours differ from it; elsewhere one is enough
    double exposureStops = 0;   ///< above the world's own
    glm::dvec3 whiteBalance{1}; ///< times red, green, blue; linear
    double noise = 1.5;         ///< standard deviation of a channel, of 255
    std::uint32_t seed = 1;     ///< of the noise
};

/// The picture, distorted as the lens has it. Camera axes: x right, y down, z forward. The same bytes on any number of
/// threads. world must have a colour.
Image<Rgb8> takePhotograph(const ScannedWorld& world, const Pose& worldFromCamera,
                           const SimulatedCameraOptions& options);

/// A camera of this size with so many degrees across and a lens as photographers have them: two coefficients.
CameraFile usualCamera(int width, int height, double degreesAcross);

} // namespace scene
