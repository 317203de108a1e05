#pragma once
// A scan of a panning scanner as its records, found again from the points that were computed of them.

#include "scene/scan.h"
#include "scene/scanner_model.h"

#include <filesystem>
#include <vector>

namespace scene {

/// One record for each point of the scan, and which half of the mirror's turn it belongs to. rangeMetres is 0 where the
/// point has no record: the beam of these constants never passes there.
struct ScanRecords {
    std::vector<ScannerRecord> records;
    std::vector<ScannerFace> faces;
    double panTurns = 0; ///< how far the pan unit went: half a turn is a whole scan, a whole one takes all twice
};

/// The scan must stand on a grid of half turns of the mirror, those before the pan unit first, then those behind it
/// (scene/capture/simulated_scan.h), computed with `believed`. `where` names it in failures. Throws Failure.
ScanRecords recordsOf(const Scan& scan, const ScannerConstants<double>& believed, const std::string& where);

/// Moves the scan's points to where other constants have them.
void readAnew(Scan& scan, const ScanRecords& records, const ScannerConstants<double>& constants);

} // namespace scene
