#pragma once
// Which of a scene's images are drawn from where the walker stands (scene/plan/walk_cells.h).
//
// Only a scene whose images each hold all that was seen from their place (build --no-cull, and what was ray-traced) can
// be walked by cells: where redundancy was culled, a surface stands in one image alone, and all are drawn. And only
// where images stand together at positions, as a cube's faces do: photographs from hundreds of places are chosen tile
// by tile, by preference (scene/preference.h).

#include "render/gpu_scene.h"
#include "scene/plan/walk_cells.h"
#include "scene/scene.h"
#include "scene/view.h"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

namespace app {

/// Fewer images do not look all round from a position; one such among the others, and all images are drawn.
inline constexpr std::size_t kImagesPerPosition = 4;

/// Images of a position that were taken from exactly there, and photographs that belong to a scan from there: too few
/// to look all round, from no farther than photographs beside scans may be (scene/import/scan_photos.h).
struct ReferencePositions {
    std::vector<glm::dvec3> places;        ///< in the world; in the order of their first images
    std::vector<std::uint32_t> positionOf; ///< of each image
};
ReferencePositions referencePositionsOf(std::span<const scene::SceneImage> images);

class Selection {
  public:
    explicit Selection(const scene::Scene& scene);

    /// Whether there are cells to walk by; if not, choose does nothing.
    bool hasCells() const { return cells_.dimension() >= 0; }
    const scene::WalkCells& cells() const { return cells_; }
    std::uint32_t cell() const { return cell_; } ///< the walker's, after choose
    std::span<const glm::dvec3> positions() const { return reference_.places; }
    /// Of each position's images, after choose; empty: all of all.
    std::span<const float> sharesOfPositions() const { return ofPositions_; }

    /// For each frame that these eyes get; holds until the next call. seconds: when in a walk; soon is then what will
    /// be drawn where it leads.
    render::ImageShares choose(std::span<const scene::View> eyes, const render::Quality& quality,
                               std::optional<double> seconds = {});

  private:
    /// How far the walker will have moved in a while, metres in the world.
    glm::dvec3 aheadOf(const glm::dvec3& head, std::optional<double> seconds);
    void raiseTo(const glm::dvec3& place, std::uint32_t& cell, std::vector<float>& shares);

    ReferencePositions reference_;
    scene::WalkCells cells_;
    std::uint32_t cell_ = 0, cellAhead_ = 0;
    std::vector<float> ofPositions_, now_, soon_;
    std::vector<scene::PositionShare> found_; ///< scratch
    glm::dvec3 lastHead_{0};
    std::optional<double> lastSeconds_;
};

} // namespace app
