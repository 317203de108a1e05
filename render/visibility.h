#pragma once
// Which tiles an eye can see. Nyland et al. 1999, section 4.5: a tile lies between the extremes of its x, y
// and disparity.
//
// A sample (x, y, d) warps to (u w, v w, w), all affine in (x, y, d). So "right of the left edge", u w >= 0,
// is a half-space of the image itself, and so are the other edges and w > 0: five planes, the same for all
// tiles of an image. The test of a tile's box against them is exact: the corner that is farthest inside
// decides, and which corner that is depends on the signs of the plane alone.

#include "scene/footprint.h"
#include "scene/tile.h"

#include <glm/mat4x4.hpp>
#include <glm/vec4.hpp>

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <vector>

namespace render {

/// Largest values over the tiles of an image: they bound what rounding can do.
struct BoundsExtent {
    float x = 0, y = 0, disparity = 0;
};

/// The boxes of tiles, one array per face. x and y of sample centres, border included; disparity in 1/m.
struct TileBounds {
    std::vector<float> xMin, xMax, yMin, yMax, dMin, dMax;

    void append(const scene::Tile& tile, const scene::Camera& camera);
    std::size_t size() const { return xMin.size(); }
    BoundsExtent extentOf(std::size_t first, std::size_t count) const;
    scene::SampleBox boxAround(std::size_t first, std::size_t count) const;
};

/// Tiles of one image that are tested together.
struct TilePiece {
    std::uint32_t image = 0, first = 0, count = 0;
    double reachMetres = std::numeric_limits<double>::infinity(); ///< from the camera to the tiles' surfaces, at most
    scene::SampleBox box{};                                       ///< around those of its tiles
    bool isBase = true; ///< else its tiles are drawn only for eyes near their camera
};

/// Inside where a x + b y + c + e d >= 0; as (a, b, c, e), to be multiplied with (x, y, 1, d).
struct ImagePlanes {
    std::array<glm::vec4, 5> inside{};
};

/// The edges of an eye's image and its plane w = 0, as seen by the source image. The edges stand marginPixels
/// outside (footprints reach in) and the planes are moved out by what single precision may lose in boxes of
/// that extent, so that no tile with a visible sample is ever rejected.
ImagePlanes planesOf(const glm::dmat4& eyeImageFromSource, int width, int height, double marginPixels,
                     const BoundsExtent& extent);

/// Writes the numbers of the tiles [first, first + count) that are not outside one of the planes, in order,
/// and returns how many. visible needs room for count numbers. Runs on the widest vectors the processor has.
std::size_t findVisible(const TileBounds& bounds, std::size_t first, std::size_t count, const ImagePlanes& planes,
                        std::uint32_t* visible);

/// What one eye sees: piece by piece, in the pieces' order whatever thread culled them. Kept from frame to
/// frame.
struct VisibleTiles {
    std::vector<std::uint32_t> pieces; ///< numbers of those that were asked about
    std::vector<std::uint32_t> counts; ///< of their tiles, for each of them
    std::vector<std::uint32_t> slots;  ///< a piece writes from its own first tile's place on
};

/// All of them.
std::vector<std::uint32_t> numbersOf(std::span<const TilePiece> pieces);

/// The planes that a piece's tiles are tested against, or nothing if none of them is wanted. Asked by many threads at a
/// time.
using PlanesFor = std::function<std::optional<ImagePlanes>(const TilePiece&)>;

/// Culls visible.pieces with TBB.
void cull(const TileBounds& bounds, std::span<const TilePiece> pieces, const PlanesFor& planesFor,
          VisibleTiles& visible);

} // namespace render
