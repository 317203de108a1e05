#pragma once
// The warp on the processor: the tool of every preparation step that needs a picture, and the oracle of the GPU's
// warps. Nyland et al. 1999, sections 5.1 and 5.2; z-buffer composition as in section 5.

#include "scene/preference.h"
#include "scene/tile.h"
#include "scene/view.h"

namespace scene {

/// One 64-bit key a pixel: bits of the order disparity << 32 | b << 24 | g << 16 | r << 8 | order level << 2 | class.
/// The greatest key wins, so the nearest sample is seen whatever the order of drawing; 0 is nothing. The order
/// disparity is the eye's, in 1/m (reversed infinite depth), over orderScale(level): see scene/preference.h. Its last
/// six bits tell where a sample stands in its pixel, and the rim of a point (scene/tile_warp.h).
using ZBuffer = Image<std::uint64_t>;

enum class PixelClass : std::uint8_t { background = 0, seen = 1, filled = 2, unseen = 3 };

/// What one eye is shown.
struct EyeImage {
    Image<Rgb8> colour;
    Image<float> depthMetres; ///< along the eye's z; 0 = nothing
    Image<std::uint8_t> pixelClass;
};

/// A sample nearer to the eye than this cannot be held in the z-buffer's order and is not drawn.
inline constexpr float kNearMetres = 1e-5f;

struct WarpOptions {
    PreferenceOptions preference;
    int maxFootprint = 1;       ///< points: pixels; 1: exactly one pixel a sample
    float footprintScale = 1.f; ///< points: times the width that closes holes, see scene/footprint.h
    float splatScale = 1.f;     ///< splats: times the radius that closes holes
    int maxSplat = 4;           ///< splats: greatest radius, pixels
};

/// Warps the blocks' kept samples, their mesh, resp. quadratic splats, into the eye's z-buffer (which has the eye's
/// size). Parallel; the result does not depend on the number of threads.
void warpPoints(std::span<const TileBlock> blocks, const View& eye, const WarpOptions& options, ZBuffer& zBuffer);
void warpMesh(std::span<const TileBlock> blocks, const View& eye, const WarpOptions& options, ZBuffer& zBuffer);
void warpSplats(std::span<const TileBlock> blocks, const View& eye, const WarpOptions& options, ZBuffer& zBuffer);

EyeImage resolve(const ZBuffer& zBuffer);

} // namespace scene
