#pragma once
// Scans written as scanners' programs write them, for others and for tests: E57 (ASTM E2807) and PTX.

#include "scene/scan.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

namespace scene {

/// A scan and the strength of what came back, one for each point.
struct ScanWithIntensity {
    Scan scan;
    std::vector<float> intensities;
};

/// count scans, asked for one after another, so that one is held at a time. Coordinates are Cartesian in single
/// precision about the scanner; pose, intensity with its limits, row and column where the scan has them, colour where
/// hasColour. Throws Failure if the file cannot be written; nothing then stands under its name.
void writeE57(const std::filesystem::path& path, std::size_t count,
              const std::function<ScanWithIntensity(std::size_t)>& scanAt);

/// The same as PTX, which knows structured scans alone: a cell without a point is 0 0 0. Coordinates to 0.1 mm. Throws
/// Failure as above.
void writePtx(const std::filesystem::path& path, std::size_t count,
              const std::function<ScanWithIntensity(std::size_t)>& scanAt);

} // namespace scene
