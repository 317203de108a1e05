#pragma once
// What is drawn in place of a damaged chunk: each tile's box, filled at its middle, in the stripes of the unseen.

#include "scene/tile_chunks.h"

#include <cstddef>

namespace render {

/// Writes chunk.bytes() bytes as scene::copyChunk would, made of the tiles' heads alone.
void writePlaceholder(const scene::TileBlock& block, const scene::TileChunk& chunk, std::byte* to);

} // namespace render
