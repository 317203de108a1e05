#pragma once
// A camera's focal length, centre and distortion from pictures of a checkerboard. Nyland et al. 1999, section 3.4,
// calibrated theirs alike (with Tsai's method and one radial coefficient; errors of 0.66 pixels and 0.62 mm on
// average); this is Zhang's method as OpenCV has it (Zhang, "A flexible new technique for camera calibration", 2000).
//
// Corners are refined within a window that must not reach the next corner: on the well-known left01 to left14, of which
// two boards have squares of 22 pixels, the usual window of 11 to each side finds a focal length of 536.1 with an error
// of 0.41 pixels, and every narrower one 532 to 533 with less than half of that error. So it follows the squares.

#include "scene/camera.h"
#include "scene/distortion.h"

#include <filesystem>
#include <string>
#include <vector>

namespace scene {

struct BoardOptions {
    int columns = 9, rows = 6; ///< inner corners
    double squareMetres = 0.025;
    int windowPixels = 0; ///< to each side of a corner; 0: a quarter of the way to the next one
};

/// What became of one picture.
struct BoardPicture {
    std::filesystem::path path;
    bool isFound = false;
    double meanPixels = 0, worstPixels = 0; ///< between corners as found and as the camera would show them
    double meanMetres = 0;                  ///< the same on the board
    std::string why;                        ///< not found, or left out: a sentence without a full stop
};

struct CameraCalibration {
    Camera camera;
    Distortion distortion;
    double focalDeviation = 0, centreDeviation = 0; ///< standard deviations in pixels
    double rmsPixels = 0, meanPixels = 0, worstPixels = 0;
    double meanMetres = 0, worstMetres = 0; ///< on the boards, at their distance: how far off the board's plane sees
                                            ///< its corners
    std::vector<BoardPicture> pictures;
};

/// Pictures without a board, and those of another size than the first, are told of and left out. Throws Failure if
/// fewer than three boards are left, or if they do not hold the camera (all stand square to it).
CameraCalibration calibrateCamera(const std::vector<std::filesystem::path>& pictures, const BoardOptions& options);

} // namespace scene
