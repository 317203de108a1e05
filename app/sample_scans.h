#pragma once
// Sample laser scans of a world that is known: by the simulated scanner, with its faults, and with the truth beside.
//
//   OUT/scans.e57 | scans.ptx   as a scanner's program would write them: from the constants it believes in, at the
//                               poses somebody noted down, right or not
//   OUT/truth.json              {"constants": {"true": {...}, "believed": {...}}, "scans": [{"name",
//                               "world_from_scanner": [16, row-major], "written_world_from_scanner"}],
//                               "photographs": [{"name", "scan", "scanner_from_camera", "written_scanner_from_camera",
//                               "turned_wrong_deg", "exposure_stops", "white_balance"}]}
//   OUT/camera.json             with photographs: their camera and its lens (scene/import/camera_file.h)

#include "scene/pose.h"

#include <cstdint>
#include <filesystem>
#include <string>

namespace app {

struct SampleScansOptions {
    std::filesystem::path polygons; ///< scanned instead of a synthetic scene, if given
    int scans = 4;
    double samplesPerDegree = 4;
    double noiseMetres = 0.005; ///< see scene::ScannerOptions
    double farthestMetres = 30;
    bool areBothFaces = false;      ///< the pan unit goes all round: each half of the mirror's turn sees everything
    bool hasWrongConstants = false; ///< the paper's: 14,039 steps and 44.8 degrees, read as 14,000 and 45
    bool arePosesUnknown = false;   ///< all are written as if the scanner had stood at the origin
    double poseErrorDegrees = 0, poseErrorMetres = 0;
    bool withColour = true;
    std::string format = "e57"; ///< or ptx
    int photographs = 0;        ///< of each scan, in each ring; E57 alone can hold them
    int photographRings = 1;    ///< around the horizon; two and three: below and above it, too
    int photographWidth = 960, photographHeight = 720;
    double photographDegrees = 65;     ///< across
    double photographErrorDegrees = 1; ///< their poses are written wrong by a turn of so much
    double exposureStops = 0;          ///< exposures and white balances drift so far to either side
};

/// sceneName: of scene::makeSyntheticScene; unused where polygons are given. Returns the pose of the true world in that
/// of what was written, as its first scan has it: registered scans stand there. Throws scene::Failure.
scene::Pose makeSampleScans(const std::filesystem::path& out, const std::string& sceneName, std::uint32_t seed,
                            const SampleScansOptions& options);

} // namespace app
