#pragma once
// What walkers would see by the images of given positions, against what there is.

#include "tests/bench/captured_cube.h"

#include "scene/view.h"

#include <array>
#include <functional>
#include <map>
#include <span>
#include <vector>

/// Over fixed views, each drawn as a mesh by the images of its walk cell (skins cut where disparity jumps).
struct PictureQuality {
    double psnrSeen = 0; ///< dB, mean over the views of which anything was drawn, over pixels that were
    double psnrAll = 0;  ///< over all; black where nothing was drawn
    double holeShare = 0;
};

class PositionPictures {
  public:
    /// Lent the tracer. Level views from these places, to all sides.
    PositionPictures(const scene::PolygonTracer& tracer, std::span<const glm::dvec3> places);

    PictureQuality qualityOf(std::span<const glm::dvec3> positions);

    /// Drawn by what `blocksFor` says, which is asked from many threads.
    using BlocksFor = std::function<std::vector<scene::TileBlock>(const scene::View&)>;
    PictureQuality qualityBy(const BlocksFor& blocksFor) const;

    /// What is seen from there all round; taken once.
    const std::vector<CapturedFace>& cubeAt(const glm::dvec3& position);

  private:
    const scene::PolygonTracer& tracer_;
    scene::SurfaceLight light_;
    std::vector<scene::View> views_;
    std::vector<scene::Image<scene::Rgb8>> truths_;
    std::map<std::array<double, 3>, std::vector<CapturedFace>> cubes_; ///< that were taken so far
};
