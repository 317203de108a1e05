#pragma once
// The photographs of one scan together: two that overlap say far more exactly how they stand to each other
// (neighbour_turn.h) than a scan says how either stands to it. So the turns of all are found at once
// (turn_network.h). One that the scan could not place is placed by its neighbours; one that contradicts them is told.

#include "scene/align/colour_to_range.h"
#include "scene/align/small_photograph.h"

#include <span>
#include <vector>

namespace scene {

/// A photograph of a scan.
struct PhotographOnScan {
    SmallPhotograph small;
    Pose scannerFromGiven;
};

/// Refines the fits that findTurn gave, one for each photograph, and judges them again. The same on any number of
/// threads.
void joinTurns(std::span<const PhotographOnScan> photographs, std::vector<ColourFit>& fits,
               const ColourToRangeOptions& options = {});

} // namespace scene
