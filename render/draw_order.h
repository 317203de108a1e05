#pragma once
// In which order chosen tiles are drawn: in batches of which each is likely to hide much of the next, and in each batch
// by the shaders that draw them, page by page. The z-buffer makes no difference between orders.

#include "render/draw_list.h"

namespace render {

/// Puts list.chosen in order. picturePixels, leastItems: as for chooseDraws. The same on any number of threads.
void orderDraws(double picturePixels, std::uint64_t leastItems, DrawList& list);

} // namespace render
