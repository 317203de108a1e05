#pragma once
// The photographs of one scan together: taken from one place, two that overlap differ by a rotation alone, and their
// edges are the same ones, which says far more exactly how they stand to each other than a scan says how either stands
// to it. So the turns of all are found at once, by least squares: each as far as its scan knows it, neighbours as they
// know each other. One that the scan could not place is placed by its neighbours; one that contradicts them is told.

#include "scene/align/colour_to_range.h"

#include <span>
#include <vector>

namespace scene {

/// A photograph of a scan, without distortion.
struct PhotographOnScan {
    const Image<Rgb8>* picture = nullptr; ///< lent
    Camera camera;
    Pose scannerFromGiven;
};

/// Refines the fits that findTurn gave, one for each photograph, and judges them again. The same on any number of
/// threads.
void joinTurns(std::span<const PhotographOnScan> photographs, std::vector<ColourFit>& fits,
               const ColourToRangeOptions& options = {});

} // namespace scene
