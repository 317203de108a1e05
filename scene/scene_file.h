#pragma once
// The scene folder: what it holds and how it is read and written.
//
//   scene.json      what, from what, with which options, figures; frames; cameras (also of held-out images)
//   images/*.tiff   the depth images as captured, with the flags that say what became of each sample
//                   (scene/depth_tiff.h)
//   held_out/*.tiff the depth images that were kept out, to measure the scene against
//   coverage.bin    what was observed and what nobody ever saw (scene/coverage.h), if scene.json says so
//   tiles.bin       what is drawn, GPU-ready:
//
//     offset 0    FileHeader: magic "RVTILES" 0, version, byte order mark, number of blocks, file size, checksum of the
//                 header
//     offset 64   BlockEntry for each image: offset, counts, checksum of the block's head; then the checksum of the
//                 table
//     from there  blocks, each on a multiple of 64, zero bytes between: the head is Tile[], Tile[] of coarser levels
//     and
//                 a checksum for each chunk (scene/tile_chunks.h); then TileVertex[], TileQuad[], TileFacet[],
//                 TileTexel[] (scene/tile.h)
//
// Little-endian. Checksums are XXH3-64. Heads are checked when the scene is opened (checksums, counts, every index in
// them), what the tiles hold when it is first needed: a scene may be larger than memory, and opens at once.

#include "scene/scene.h"

#include <functional>

namespace scene {

inline constexpr const char* kHeldOutFolder = "held_out";

/// A block of tiles as bytes: as a build keeps it for itself, and as it stands in tiles.bin. Starts with its own counts
/// and checksum.
std::vector<std::byte> packTiles(const TileSet& tiles);
/// Throws Failure naming `where` if anything about it is wrong.
TileSet unpackTiles(std::span<const std::byte> packed, const std::string& where);

/// Writes tiles.bin from the tiles of each image, asked for one after another (so that they need not all be in memory).
void writeTilesFile(const std::filesystem::path& path, std::size_t blockCount,
                    const std::function<TileSet(std::size_t)>& tilesOf);

/// What becomes of an image whose block has a damaged head: its samples cannot be told apart any more.
enum class DamagedHeads {
    refused,
    leftOut ///< its block is empty, and Scene::damaged names it
};

/// Opens a scene folder. Throws Failure with file, place and cause for anything missing, damaged, or of another
/// version.
Scene openScene(const std::filesystem::path& folder, DamagedHeads heads = DamagedHeads::refused);

} // namespace scene
