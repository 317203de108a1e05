#pragma once
// revisit calibrate: what is known of an instrument, from pictures of a board or scans of walls, into a file that a
// build takes.

#include "scene/align/camera_calibration.h"
#include "scene/scanner_model.h"

#include <filesystem>
#include <vector>

namespace app {

struct CalibrateOptions {
    std::vector<std::filesystem::path> inputs; ///< pictures, or folders of them; or scan files
    std::filesystem::path output;              ///< JSON
    scene::BoardOptions board;
    scene::ScannerConstants<double> believed; ///< what the scans were computed with
};

/// {"width", "height", "fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3", ...}; pixel centres at halves, OpenCV's
/// distortion. Throws scene::Failure.
void calibrateCamera(const CalibrateOptions& options);

/// See scene/align/scanner_file.h. Throws scene::Failure.
void calibrateScanner(const CalibrateOptions& options);

} // namespace app
