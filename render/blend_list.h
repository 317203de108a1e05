#pragma once
// The tiles whose samples the second pass of the blended warp adds (scene/blend.h), for one eye.

#include "render/draw_list.h"
#include "render/shaders/shared/blend.h"
#include "scene/blend.h"

#include <cstdint>
#include <span>
#include <vector>

namespace render {

struct BlendList {
    std::vector<DrawRun> runs;
    std::uint32_t tiles = 0;
    std::uint64_t items = 0; ///< samples
    /// Scratch, kept from frame to frame: the tiles to draw, what their samples become, how many of each piece and
    /// where those of each begin.
    std::vector<std::uint32_t> numbers;
    std::vector<scene::BlendSpot> spots;
    std::vector<std::uint32_t> counts, firstOfPiece;
};

/// Whether any tile of a piece of a captured image may be added.
bool mayBeBlended(const TilePiece& piece, const glm::dvec3& eyeFromCamera, const scene::BlendOptions& options);

/// As chooseDraws. sources: one for each captured image; coarser levels are left out. hasPolygons: those are of class
/// filled, and so is what was not measured: it is left out then, for nothing must mix with them.
void chooseBlendDraws(const SceneIndex& scene, std::span<const ChunkPlace> places, std::span<const SourceView> sources,
                      const VisibleTiles& visible, const scene::BlendOptions& options, bool hasPolygons,
                      BlendList& list);

/// As writeDraws.
void writeBlendDraws(const SceneIndex& scene, std::span<const ChunkPlace> places, std::span<const SourceView> sources,
                     const BlendList& list, std::span<BlendDraw> draws);

} // namespace render
