#pragma once
// What of a scene that is larger than memory should be on the device, for eyes that stand somewhere. Pure functions.

#include "render/quality.h"
#include "render/scene_index.h"
#include "scene/open_ways.h"
#include "scene/view.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace render {

/// For each chunk the chunks of the next coarser level that stand for it while it is not there.
struct CoarserChunks {
    std::vector<std::uint32_t> first, coarser;
    std::span<const std::uint32_t> of(std::uint32_t chunk) const {
        return std::span(coarser).subspan(first[chunk], first[chunk + 1] - first[chunk]);
    }
};
CoarserChunks coarserChunksOf(const SceneIndex& index);

/// The chunks that stay on the device whatever is looked at, so that nothing ever vanishes: of each image the coarsest
/// level, and as many finer ones of all images as go into a share of the budget. Ascending. Directional tiles open no
/// holes, and are left out.
std::vector<std::uint32_t> chunksToKeep(const SceneIndex& index, std::size_t budgetBytes);

inline constexpr double kKeptShare = 0.5; ///< of the budget, if the coarsest level is not more

/// What is looked at, and how.
struct LookedAt {
    std::span<const scene::View> eyes;
    const Quality& quality;
    std::span<const float> shares; ///< of the captured images' samples; 0: nothing of it is drawn; empty: all of all
    const scene::OpenWays* ways = nullptr; ///< from these eyes past the unseen; null: it hides nothing
};

/// All chunks that these eyes want, most wanted first: those whose samples are seen widest, by pixels; those in view
/// before others, and what unseen space hides last of all. A chunk never comes before what stands for it. Wanted is
/// what may be drawn at this quality from there, whichever way the eyes turn.
std::vector<std::uint32_t> chunksWanted(const SceneIndex& index, const CoarserChunks& coarser, const LookedAt& looked);

/// Whether two looks want so nearly the same that there is no need to ask again: heads are never quite still.
bool wantAboutTheSame(const LookedAt& a, const LookedAt& b);

} // namespace render
