#pragma once
// Chunks: runs of tiles that are read from disk, checked and brought to a device together.

#include "scene/tile.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace scene {

/// What is in a chunk at most, bytes, unless one tile alone is larger: large enough for a disk, small enough to come
/// within a frame. Checksums in tiles.bin are of chunks of this size.
inline constexpr std::size_t kChunkBytes = std::size_t{256} << 10;

/// Tiles of one image, level and tier that follow one another. Tiles are counted through a block's tiles and, after
/// them, its coarser ones; what they hold, through the block's arrays.
struct TileChunk {
    std::uint32_t firstTile = 0, tileCount = 0;
    std::uint32_t firstVertex = 0, vertexCount = 0, firstQuad = 0, quadCount = 0;
    std::uint32_t firstFacet = 0, facetCount = 0, firstTexel = 0, texelCount = 0;
    Tier tier = Tier::base;
    std::uint8_t level = 0;

    std::size_t bytes() const {
        return vertexCount * sizeof(TileVertex) + quadCount * sizeof(TileQuad) + facetCount * sizeof(TileFacet) +
               texelCount * sizeof(TileTexel);
    }
};

/// Of a block, counted as a chunk counts them.
inline const Tile& tileOf(const TileBlock& block, std::size_t number) {
    return number < block.tiles.size() ? block.tiles[number] : block.coarser[number - block.tiles.size()];
}

/// All tiles of a block in their order. A chunk ends where what the next tile holds does not follow.
std::vector<TileChunk> chunksOf(const TileBlock& block, std::size_t maxBytes = kChunkBytes);

/// XXH3-64 of a chunk's facets, vertices, quads and texels, in this order.
std::uint64_t checksumOf(const TileBlock& block, const TileChunk& chunk);

/// Whether a renderer may trust the chunk blindly: nothing that a tile's head does not tell already leads outside the
/// tile. block.chunkSums: if there are any, number is the chunk's among them.
bool isSound(const TileBlock& block, const TileChunk& chunk, std::size_t number);

/// Tells which tiles of a block may be read. Finds out chunk by chunk, each once; a block of a scene remembers. The
/// block must outlive it.
class SoundTiles {
  public:
    explicit SoundTiles(const TileBlock& block) : block_(block) {}
    bool isSound(std::size_t tile);

  private:
    const TileBlock& block_;
    std::vector<TileChunk> chunks_;              ///< found when first wanted
    std::vector<std::atomic<std::uint8_t>> own_; ///< verdicts, where the block keeps none
};

/// Copies what a chunk holds, chunk.bytes() in all: facets, vertices, quads, texels.
void copyChunk(const TileBlock& block, const TileChunk& chunk, std::byte* to);

/// Gives back the memory that a chunk of a mapped file took in this process; it is read again when it is looked at.
void releaseChunk(const TileBlock& block, const TileChunk& chunk);

} // namespace scene
