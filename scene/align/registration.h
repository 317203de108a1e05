#pragma once
// All scans of a capture registered: every pair by itself, the pairs that are sure joined into groups, and each group
// adjusted as one. Nyland et al. 1999, section 4.1, had a person pick the planes and laid scans on each other one after
// another.

#include "scene/align/register_pair.h"

#include <functional>
#include <string>
#include <vector>

namespace scene {

struct RegistrationOptions {
    PairOptions pair;
    double leastJointOverlap = 0.04; ///< two scans of a group that share as much are laid on each other
};

struct PairOutcome {
    std::size_t a = 0, b = 0; ///< indices of scans
    PairResult result;        ///< as the two alone have it
    bool isUsed = false;      ///< it joins two scans of a group
    bool isRefused = false;   ///< sure by itself, but a third scan says otherwise
};

struct ScanOutcome {
    bool isRegistered = false; ///< else it stands where it was said to stand
    std::size_t group = 0;     ///< index of the group's first scan, which stands where it was said to stand
    Pose worldFromScanner;
    PoseDeviation deviation; ///< against the group's first scan
    std::string why;         ///< it is not registered; a sentence for the user
};

struct Registration {
    std::vector<ScanOutcome> scans; ///< as the input
    std::vector<PairOutcome> pairs;
    double rmsMetres = 0; ///< of surfaces that lie on each other
    std::vector<std::string> remarks;
};

/// From pairs that are known already: those that are sure are joined and adjusted.
Registration joinScans(const std::vector<ScanView>& scans, std::vector<PairOutcome> pairs,
                       const RegistrationOptions& options = {});

/// Where every scan was said to stand at one place, nothing was said: they are then found from nothing. told: called
/// after each pair, from any thread.
Registration registerScans(const std::vector<ScanView>& scans, const RegistrationOptions& options = {},
                           const std::function<void()>& told = {});

} // namespace scene
