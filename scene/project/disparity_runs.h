#pragma once
// Samples about a pixel, told apart into surfaces: runs of like disparity.

#include <cstddef>
#include <span>

namespace scene {

/// The run with the greatest weight of samples whose disparities follow each other closely; the first of equal ones.
/// Samples must be sorted by disparity. Sum: what weights are added up in. gapAt: of a sample, how far from the one
/// before it may be in the same run, 1/m.
template <class Sum, class Sample, class GapAt>
std::span<const Sample> heaviestRun(std::span<const Sample> sorted, const GapAt& gapAt) {
    std::size_t bestFirst = 0, bestEnd = 0;
    Sum bestWeight = 0;
    for (std::size_t first = 0, end = 0; first < sorted.size(); first = end) {
        Sum weight = 0;
        do {
            weight += sorted[end].weight;
            ++end;
        } while (end < sorted.size() && sorted[end].disparity - sorted[end - 1].disparity <= gapAt(sorted[end]));
        if (weight > bestWeight) bestWeight = weight, bestFirst = first, bestEnd = end;
    }
    return sorted.subspan(bestFirst, bestEnd - bestFirst);
}

} // namespace scene
