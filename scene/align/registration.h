#pragma once
// All scans of a capture registered: every pair by itself, the pairs that are sure joined into groups, and each group
// adjusted as one. Nyland et al. 1999, section 4.1, had a person pick the planes and laid scans on each other one after
// another.

#include "scene/align/scan_groups.h"

#include <functional>
#include <string>
#include <vector>

namespace scene {

struct RegistrationOptions {
    PairOptions pair;
    SeveralOptions several;
    double leastJointOverlap = 0.04; ///< two scans of a group that share as much are laid on each other
};

struct ScanOutcome {
    bool isRegistered = false; ///< else it stands where it was said to stand
    bool isLost = false;       ///< nothing says where it stands among the others (scene/align/lost_scans.h)
    std::size_t group = 0;     ///< index of the group's first scan whose place was said, or of its first
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

/// registerPair, or what is known of the pair from before; asked from several threads at a time.
using FindPair = std::function<PairResult(std::size_t a, std::size_t b, const std::optional<Pose>& roughAFromB)>;

/// Where several scans were said to stand at the origin, nothing was said of them (arePosesSaid): they are found from
/// nothing.
/// known: pairs that are not to be found, since somebody says how they stand.
Registration registerScans(const std::vector<ScanView>& scans, const RegistrationOptions& options = {},
                           const FindPair& findPair = {}, std::vector<PairOutcome> known = {});

} // namespace scene
