#pragma once
// The file of a calibrated scanner: what its scans were computed with, and what they should be.
//
//   {"believed": {"pan_steps_per_half_turn", "mirror_deg", "horizon_position", "mirror_m"}, "constants": {...}, ...}

#include "scene/scanner_model.h"

#include <filesystem>

#include <nlohmann/json.hpp>

namespace scene {

nlohmann::json describeConstants(const ScannerConstants<double>& constants);

/// Throws Failure if the file is none, or holds constants that no scanner has.
ScannerReading readScannerFile(const std::filesystem::path& path);

} // namespace scene
