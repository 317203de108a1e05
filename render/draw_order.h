#pragma once
// In which order chosen tiles are drawn: in batches of which each is likely to hide much of the next, and in each batch
// by the shaders that draw them, page by page. The z-buffer makes no difference between orders.

#include "render/draw_list.h"

#include <cstdint>
#include <span>

namespace render {

/// Puts list.chosen in order. chosenPieces: those that list.counts is about, of pieces. picturePixels: as for
/// chooseDraws. The same on any number of threads.
void orderDraws(std::span<const TilePiece> pieces, std::span<const std::uint32_t> chosenPieces, double picturePixels,
                DrawList& list);

} // namespace render
