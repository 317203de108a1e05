#pragma once
// The scan's own points in the pixels of a face: which of them the pixel's sample stands for, and where the
// others go. Nyland et al. 1999, section 4.3: the samples of a pixel are clustered by range, the mean of the
// heaviest cluster wins the pixel, and so no sample hangs between foreground and background. The paper drops
// the lighter clusters; we keep them in further layers.

#include "scene/depth_image.h"
#include "scene/project/cube_layout.h"
#include "scene/project/grid_mesh.h"

#include <cstdint>
#include <span>
#include <vector>

namespace scene {

/// A sample that found its pixel taken.
struct LayerSample {
    int layer = 0; ///< 1 for the second image, ...
    std::int32_t x = 0, y = 0;
    float disparity = 0;
    Rgb8 colour;
    std::uint8_t flags = 0; ///< SampleFlag
};

struct PixelClusters {
    std::vector<LayerSample> further; ///< in an order that depends on the scan alone
    std::int64_t held = 0, dropped = 0;
    std::int64_t pixels = 0; ///< with points of their own
};

/// face: a face's first layer with its mesh drawn; mesh: the same pixels, empty for loose points. points: all of the
/// scan that belong to this face. Writes to face.
PixelClusters placePoints(const Scan& scan, const CubeFrame& frame, int faceIndex,
                          std::span<const std::uint32_t> points, const ScanGrid* grid, const Image<MeshPixel>& mesh,
                          const CubeFaceOptions& options, DepthImage& face);

} // namespace scene
