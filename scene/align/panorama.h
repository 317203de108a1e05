#pragma once
// A scan in small, as one sees it from the scanner: a range image over azimuth and elevation. Its cells are wider than
// the scan's own samples, so that each is the mean of several; it is what registration looks things up in, whether the
// scan had a grid or not.

#include "scene/image.h"
#include "scene/scan.h"

#include <array>
#include <cstdint>
#include <optional>

#include <glm/vec3.hpp>

namespace scene {

/// What was seen in one direction; lengths in metres, in the scanner's frame.
struct PanoramaCell {
    glm::vec3 point{0.0f};           ///< the mean of the samples about the median range
    glm::vec3 normal{0.0f};          ///< unit, towards the scanner; zero: not smooth there
    float nearest = 0, farthest = 0; ///< of all its samples
    std::int32_t samples = 0;        ///< 0: nothing came back
    std::int32_t plane = -1;         ///< index of the plane it lies on
};

/// What was seen in a cell and the eight about it: small, since registration looks it up for every pose that it tries.
struct PanoramaAbout {
    float nearest = 0, farthest = 0; ///< metres, of all of them that saw something
    bool isSeen = false;             ///< something came back in the middle one
    bool isWhole = false;            ///< and in each of them
};

/// Rows of a panorama: half a degree each, or a quarter where the scan is dense enough.
inline constexpr int kCoarseRows = 360, kFineRows = 720;

/// Column by azimuth from -pi, row by elevation from the nadir; twice as many columns as rows.
struct Panorama {
    Image<PanoramaCell> cells;
    Image<PanoramaAbout> about; ///< as lookAbout leaves it

    int width() const { return cells.width(); }
    int height() const { return cells.height(); }
    double stepRadians() const;
    /// Column and row of a direction of any length; nothing for the origin itself.
    std::optional<std::array<int, 2>> placeOf(const glm::dvec3& direction) const;
    /// How many cells make one of the coarse panorama, each way, or 1: what need not be looked at more closely is not.
    int finerThanCoarse() const { return height() > kCoarseRows ? height() / kCoarseRows : 1; }
    /// Share of the sphere that a cell of this row stands for, the level ones' being 1.
    double weightOf(int row) const;

    const PanoramaCell* find(const glm::dvec3& direction) const {
        const auto place = placeOf(direction);
        return place ? &cells((*place)[0], (*place)[1]) : nullptr;
    }
};

/// Says anew what is about each cell, once the cells are what they are.
void lookAbout(Panorama& panorama);

/// A scan's panorama, with normals from a window of five by five cells. As fine as its samples allow, or of so many
/// rows: wide cells leave less of the noise, and planes reach farther out to where they are seen glancingly.
Panorama panoramaOf(const Scan& scan);
Panorama panoramaOf(const Scan& scan, int rows);

} // namespace scene
