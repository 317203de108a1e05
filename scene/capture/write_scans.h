#pragma once
// Scans written as scanners' programs write them, for others and for tests: E57 (ASTM E2807) and PTX.

#include "scene/camera.h"
#include "scene/scan.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace scene {

/// A photograph that stands in the file beside a scan. E57 knows pinholes without distortion alone.
struct WrittenPhotograph {
    std::string name;
    std::size_t scan = 0; ///< which of the scans it belongs to
    Camera camera;
    Pose worldFromCamera;           ///< x right, y down, z forward
    std::vector<std::uint8_t> jpeg; ///< as it stands in the file
};

/// Those of a file, asked for one after another, too.
struct WrittenPhotographs {
    std::size_t count = 0;
    std::function<WrittenPhotograph(std::size_t)> at;
};

/// count scans, asked for one after another, so that one is held at a time. Coordinates are Cartesian in single
/// precision about the scanner; pose, intensity with its limits, row and column where the scan has them, colour where
/// hasColour. Throws Failure if the file cannot be written; nothing then stands under its name.
void writeE57(const std::filesystem::path& path, std::size_t count,
              const std::function<ScanWithIntensity(std::size_t)>& scanAt, const WrittenPhotographs& photographs = {});

/// The same as PTX, which knows structured scans alone: a cell without a point is 0 0 0. Coordinates to 0.1 mm. Throws
/// Failure as above.
void writePtx(const std::filesystem::path& path, std::size_t count,
              const std::function<ScanWithIntensity(std::size_t)>& scanAt);

} // namespace scene
