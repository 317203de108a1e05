#pragma once
// A laser scan as its file holds it: points around a scanner, on a grid of rows and columns where the scanner
// kept one.

#include "scene/image.h"
#include "scene/pose.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

namespace scene {

/// Points are single precision relative to the scanner's origin (worldFromScanner carries the large numbers).
/// Structured: row and column have an entry for each point, 0 <= row < rows, 0 <= column < columns; cells
/// that returned nothing are simply absent. Unstructured: rows = columns = 0 and both are empty.
struct Scan {
    std::string name; ///< unique within a capture; becomes a file name
    Pose worldFromScanner;
    int rows = 0, columns = 0;
    std::vector<glm::vec3> pointsInScanner;
    std::vector<Rgb8> colours;    ///< one for each point; from intensity (grey) or mid-grey where it has none
    bool hasColour = false;       ///< of its own, any point
    std::vector<bool> isColoured; ///< one for each point where some have colour and others have not; else empty
    std::vector<std::int32_t> row, column;
    std::int64_t invalidPoints = 0; ///< points the file marks invalid or that are not finite; not among the points

    bool hasColourAt(std::size_t point) const { return isColoured.empty() ? hasColour : isColoured[point]; }

    /// Of isColoured, which importers give an entry for each point, what Scan says of itself.
    void settleColours() {
        const auto coloured = static_cast<std::size_t>(std::count(isColoured.begin(), isColoured.end(), true));
        hasColour = coloured > 0;
        if (coloured == 0 || coloured == isColoured.size()) isColoured = {};
    }
};

/// A scan and the strength of what came back, one for each point, in units of its own; empty where it has none.
struct ScanWithIntensity {
    Scan scan;
    std::vector<float> intensities;
};

} // namespace scene
