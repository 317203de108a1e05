#pragma once
// In which order chosen tiles are drawn: in batches of which each is likely to hide much of the next, in each batch
// by the shaders that draw them, page by page, and on processors each of those from the picture's top to its bottom.
// The z-buffer makes no difference between orders.

#include "render/draw_list.h"

namespace render {

/// Rows of a band. What is drawn together lies close together then, and stays in a processor's caches; and since its
/// threads take a share of the tiles each, hardly two of them write to the same pixels (docs/performance.md).
inline constexpr int kBandRows = 16;
inline constexpr std::uint32_t kBands = 256;
/// Of a row of the picture, pixels: above its top the first, far below its bottom the last.
std::uint32_t bandOf(double row);

/// Puts list.chosen in order. picturePixels, leastItems: as for chooseDraws. The same on any number of threads.
void orderDraws(double picturePixels, std::uint64_t leastItems, DrawList& list);

} // namespace render
