#pragma once
// Scans of which nobody knows where they stand among the others: drawn where their files leave them, at the origin,
// they would make a place that never was.

#include "scene/align/register_pair.h"

#include <cstddef>
#include <span>
#include <vector>

namespace scene {

/// Of each scan, whether anybody said where it stands. Files without poses leave scans at the origin, turned as the
/// scanner's compass has them or not at all; that one alone stands there may be meant.
std::vector<bool> arePosesSaid(std::span<const ScanView> scans);

/// What registration found of a scan.
struct FoundPlace {
    bool isRegistered = false;
    std::size_t group = 0; ///< by the number of one of its scans; of a scan that is not registered, itself
    Pose worldFromScanner; ///< where it is registered
};

/// Of each scan, whether it is lost. What stays is what was said to stand somewhere, with what was registered to it, or
/// the largest group of the others, the first of several, if that has more scans. None is lost where two scans or more,
/// and most of those that were registered, came out at the origin, where their files have them: scans are then in the
/// coordinates of the site.
std::vector<bool> findLost(std::span<const ScanView> scans, const std::vector<bool>& areSaid,
                           std::span<const FoundPlace> found);

} // namespace scene
