#pragma once
// What is slightly off in a panning scanner, from scans that took the same walls twice: once with each half of the
// mirror's turn. Nyland et al. 1999, section 3.2, name the four constants (14,039 steps instead of 14,000, a mirror of
// 44.8 degrees instead of 45, the encoder's horizon, the distance to the mirror) and leave open how they were found.
//
// A wrong mirror or horizon moves what the two faces saw to different sides, a wrong number of steps parts them by the
// turn between, and a wrong distance bends every plane that is seen at several angles. So samples of each plane, of
// both faces and away from its rims, are laid on one plane, and the constants adjusted with the planes: least squares
// with a robust loss (Ceres), through the very function that reads records. What hangs on a wall by less than noise
// tells is taken for part of it: patches of a degree may stand off their plane by as much as both faces together say
// that those of this plane do (random effects). A scan of half a turn takes nothing twice but what reaches from one
// face's half into the other's, floors above all: several such scans hold the constants, too, less exactly.

#include "scene/align/scanner_records.h"

#include <functional>
#include <string>
#include <vector>

namespace scene {

struct ScannerCalibrationOptions {
    int mostSamples =
        150'000;    ///< of all scans together, evenly from planes and faces; up to 6 times as many of noisy ones
    int passes = 3; ///< planes are found anew with the constants of the pass before
};

/// A constant that is known no better than this is not said to be found.
inline constexpr double kMostStepsDeviation = 3, kMostMirrorDeviation = 0.00035, kMostHorizonDeviation = 0.25,
                        kMostMetresDeviation = 0.01;

struct ScannerCalibration {
    ScannerConstants<double> constants;
    /// Standard deviations, judged by how planes disagree, not by samples alone; that of the mirror's distance with an
    /// allowance for what glancing surfaces and noise do to all of them alike.
    ScannerConstants<double> deviations;
    int planes = 0; ///< seen by both faces
    std::int64_t samples = 0;
    double rmsBeforeMetres = 0, rmsAfterMetres = 0; ///< of samples from their planes, the middle 90 % of them
    std::string why; ///< empty: found. Otherwise what they lack, a sentence without a full stop; constants then stay
                     ///< as believed
};

/// scans: of one instrument, each with a grid (recordsOf) that was computed with `believed`, from anywhere. They are
/// asked for by number, one at a time. Throws Failure where a scan has no such grid.
ScannerCalibration calibrateScanner(std::size_t scans, const std::function<Scan(std::size_t)>& scanAt,
                                    const ScannerConstants<double>& believed,
                                    const ScannerCalibrationOptions& options = {});

} // namespace scene
