#pragma once
// What a chunk's tiles hold, on its way to the device: read and checked, or, where it is damaged, a placeholder: each
// tile's box, filled at its middle, in the stripes of the unseen.

#include "render/scene_index.h"

#include <cstddef>

namespace render {

/// Writes chunk.chunk.bytes() bytes, laid out as scene::copyChunk does, and gives back the memory that the file's took.
/// False if the chunk is damaged: then they are a placeholder, made of the tiles' heads alone.
bool bringChunk(const scene::TileBlock& block, const IndexedChunk& chunk, std::byte* to);

} // namespace render
