#pragma once
// A camera with its lens, as calibration leaves it: a JSON file, and the lens's distortion both ways.
//
//   {"width", "height", "fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"}
//
// Pixels, with centres at half (cx = width / 2 is the middle). Distortion is OpenCV's (Brown, "Decentering distortion
// of lenses", 1966); what is not there is 0, further keys are passed over.

#include "scene/camera.h"
#include "scene/import/capture.h"

#include <filesystem>

#include <glm/vec2.hpp>

namespace scene {

struct CameraFile {
    Camera camera;
    Distortion distortion;
};

/// Throws Failure: no such file, no JSON, a size or focal length that is missing or none, a lens that folds the picture
/// over itself.
CameraFile readCameraFile(const std::filesystem::path& path);

/// Throws Failure if the file cannot be written.
void writeCameraFile(const std::filesystem::path& path, const CameraFile& camera);

/// Where the lens shows what a pinhole would show at this place; both at depth 1.
glm::dvec2 distorted(const Distortion& lens, const glm::dvec2& ideal);

/// How far from the picture's middle, at depth 1, a lens shows nothing twice: infinite where it never folds the picture
/// over itself between middle and corners.
double oneToOneWithin(const Camera& camera, const Distortion& lens);

/// The other way, to double rounding where the lens does not fold over.
glm::dvec2 undistorted(const Distortion& lens, const glm::dvec2& seen);

} // namespace scene
