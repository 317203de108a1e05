#pragma once
// What the processor keeps of a scene to cull it, to draw it and to know what of it should be on the device: images,
// tiles and chunks, but not what is in them.

#include "render/resources.h"
#include "render/visibility.h"
#include "scene/preference.h"
#include "scene/tile.h"
#include "scene/tile_chunks.h"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace render {

/// Where a chunk lies on the device, if it is there. firstTexel is even.
struct ChunkPlace {
    static constexpr std::uint32_t kNowhere = std::numeric_limits<std::uint32_t>::max();
    std::uint32_t page = kNowhere, firstTexel = 0;
    bool isDamaged = false; ///< a placeholder is there (render/chunk_bytes.h)
    bool isThere() const { return page != kNowhere; }
};

/// A tile as the draw list needs it; places count texels from the start of its chunk.
struct ResidentTile {
    std::uint32_t image = 0, chunk = 0; ///< image: of its level
    std::uint32_t firstVertex = 0, pointCount = 0, firstQuad = 0, quadCount = 0;
    std::uint32_t firstLone = 0, loneCount = 0;                   ///< vertices of samples that are in no square
    std::uint32_t firstFacet = 0, facetCount = 0, firstTexel = 0; ///< firstFacet counts facets
    std::uint32_t width = 0, height = 0;                          ///< in samples; a row of texels has one more
    std::int32_t x0 = 0, y0 = 0;                                  ///< first sample in the image
    float minDisparity = 0, maxDisparity = 0;
    std::uint32_t placeBits = scene::kPlaceBits;
    double steepness = 0; ///< what neighbours differ by in disparity, in most squares, over what its extremes do
    scene::TileMiddle middle;
};

/// A captured image, or one of its coarser levels (scene/pyramid.h).
struct ResidentImage {
    scene::Camera camera;
    scene::Pose worldFromCamera;
    BoundsExtent extent;
    std::uint32_t captured = 0, level = 0; ///< of which image it is a level, and which
    bool hasCoarser = false;
    double middleReach = 0; ///< metres from the camera to the tile in the middle of those of the captured image
    std::uint32_t firstPiece = 0, pieceCount = 0;     ///< of its tiles
    std::uint32_t firstCoarser = 0, coarserCount = 0; ///< of a captured image: its coarser levels
};

/// A chunk of the block of image `captured`, and where its samples lie: within radius of the centre (metres, world),
/// unless it reaches to the sky.
struct IndexedChunk {
    scene::TileChunk chunk;
    std::uint32_t captured = 0;   ///< its block, too
    std::uint32_t number = 0;     ///< among the block's
    std::uint32_t firstTile = 0;  ///< in SceneIndex::tiles
    glm::dvec3 least{0}, most{0}; ///< box around them in the world, if it does not reach to the sky
    glm::dvec3 centre{0};
    double radius = std::numeric_limits<double>::infinity();
    double spacing = 0; ///< metres between neighbouring samples where they stand nearest to the camera; sky: radians
    double widestSpacing = std::numeric_limits<double>::infinity(); ///< where they stand farthest
    double reach = 0; ///< metres from the camera to the farthest tile's middle

    /// That it takes on the device: an even number, since a facet is two.
    std::uint32_t texels() const { return static_cast<std::uint32_t>((chunk.bytes() / kTexelBytes + 1) / 2 * 2); }
};

/// Around all that an image has taken, metres in the world; infinite with the sky.
struct ImageSphere {
    glm::dvec3 centre{0};
    double radius = std::numeric_limits<double>::infinity();
    scene::WorldExtent box{}; ///< closer about it, where somebody found that
};

class SceneIndex {
  public:
    SceneIndex() = default;
    /// chunkBytes: as for scene::chunksOf.
    SceneIndex(std::span<const scene::TileBlock> blocks, std::size_t chunkBytes);

    /// The captured ones first, then their coarser levels.
    std::vector<ResidentImage> images;
    std::size_t capturedImages = 0;
    std::vector<ResidentTile> tiles;
    TileBounds bounds;
    /// All tiles once, in order; a piece never crosses an image, nor holds both tiles for all eyes and others.
    std::vector<TilePiece> pieces;
    std::vector<IndexedChunk> chunks;
    std::vector<ImageSphere> spheres; ///< of the captured images

    /// The pieces of these images, image by image, into numbers.
    void findPiecesOf(std::span<const std::uint32_t> ofImages, std::vector<std::uint32_t>& numbers) const;

    /// Finds out, once, what finerThan tells: needed where chunks come and go.
    void findFiner();

    /// The chunks of the next finer level and the same tier, of closed tiles too for base ones, in which the samples
    /// below a coarser tile's are (or some more): none for tiles of level 0, nor before findFiner.
    std::span<const std::uint32_t> finerThan(std::uint32_t tile) const {
        if (firstFiner_.empty()) return {};
        return std::span(finer_).subspan(firstFiner_[tile], firstFiner_[tile + 1] - firstFiner_[tile]);
    }

  private:
    void addImage(const ResidentImage& image, const scene::TileBlock& block, std::uint32_t firstNumber,
                  std::size_t count, std::uint32_t firstChunk);
    TilePiece pieceFrom(std::size_t first) const; ///< up to the last tile there is
    void surround(std::size_t captured, std::size_t firstChunk);
    static void measure(IndexedChunk& chunk, const scene::TileBlock& block);

    std::vector<std::uint32_t> firstFiner_, finer_;
};

} // namespace render
