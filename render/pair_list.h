#pragma once
// The draw lists of two eyes united: what both draw stands once, for a warp that reads each sample once. Each eye keeps
// its own choice of tiles, levels and batches, so that its picture is the same as if it were drawn alone.

#include "render/draw_list.h"
#include "render/shaders/shared/stereo.h"

#include <cstdint>
#include <span>
#include <vector>

namespace render {

struct PairList {
    std::vector<DrawRun> runs; ///< of pairs, batches ascending
    std::vector<PairDraw> pairs;
    /// Scratch, kept from frame to frame: the right eye's draw of each tile; pairs by tile, and what they are sorted
    /// by.
    std::vector<std::uint32_t> rightOfTile, buckets, firsts;
    std::vector<PairDraw> unsorted;
};

/// Whether the lists can be drawn in one pass: both of points and splats alone, of wide tiles only if mayBeWide, in no
/// more runs than can be tested. Only then are they united: a tile that both eyes draw in the same batch by the same
/// warp becomes one pair, any other a pair for one eye. tiles: of the scene.
bool uniteDraws(std::size_t tiles, const DrawList& left, const DrawList& right, bool mayBeWide, PairList& list);

} // namespace render
