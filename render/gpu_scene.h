#pragma once
// A scene on the device: all of it, or, where it is larger than what it may take, as much as the eyes want most.

#include "render/quality.h"
#include "render/scene_index.h"
#include "render/tile_pool.h"
#include "render/tile_stream.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

namespace render {

/// Small enough for one allocation and one view on every common device; the few that see less get smaller pages. Each
/// page is drawn by dispatches of its own: so they are large.
inline constexpr std::size_t kPageBytes = std::size_t{512} << 20;

struct SceneMemory {
    std::size_t budgetBytes = std::numeric_limits<std::size_t>::max(); ///< of what tiles hold
    std::size_t pageBytes = kPageBytes;                                ///< tests make pages small
    bool isStaged = false; ///< tests: as if the processor could not see the device's memory
};

/// How many of each captured image's samples are drawn, as shares; and how many may be soon, at least as many: they are
/// fetched before they are wanted. Empty: all of all.
struct ImageShares {
    std::span<const float> now, soon;
};

class GpuScene {
  public:
    /// Copies what the blocks hold to the device, or what of it is always to be there; then the blocks must outlive the
    /// scene. A tile is never split: pageBytes must hold the largest. Throws OutOfMemory if the device's memory does
    /// not suffice, or the budget not for the coarsest of everything.
    GpuScene(const Device& device, std::span<const scene::TileBlock> blocks, const SceneMemory& memory);
    GpuScene(const Device& device, std::span<const scene::TileBlock> blocks, std::size_t pageBytes = kPageBytes)
        : GpuScene(device, blocks, SceneMemory{.pageBytes = pageBytes}) {}

    const SceneIndex& index() const { return index_; }
    /// For each chunk of the index.
    std::span<const ChunkPlace> places() const { return places_; }

    /// The captured ones first, then their coarser levels.
    std::span<const ResidentImage> images() const { return index_.images; }
    std::size_t capturedImages() const { return index_.capturedImages; }
    std::span<const ResidentTile> tiles() const { return index_.tiles; }
    const TileBounds& bounds() const { return index_.bounds; }
    std::span<const TilePiece> pieces() const { return index_.pieces; }

    std::size_t pageCount() const { return pool_->pageCount(); }
    std::size_t bytesResident() const { return pool_->bytes(); }
    VkDescriptorSetLayout pageLayout() const { return pool_->layout(); }
    VkDescriptorSet pageSet(std::size_t page) const { return pool_->setOf(page); }

    /// Whether only part of the scene is there at a time.
    bool isStreamed() const { return stream_ != nullptr; }
    std::size_t bytesKept() const { return bytesKept_; } ///< of what is always there
    StreamCounts streamCounts() const { return stream_ ? stream_->counts() : StreamCounts{}; }

    /// From the next frame on.
    void showOnly(const ImageShares& shares) {
        if (!std::ranges::equal(shares.now, shares_)) ++changes_;
        shares_.assign(shares.now.begin(), shares.now.end());
        soon_.assign(shares.soon.begin(), shares.soon.end());
    }
    std::span<const float> shares() const { return shares_; }

    /// Grows whenever a frame may show other samples than the one before, from the same place.
    std::uint64_t changes() const { return changes_ + (stream_ ? stream_->changes() : 0); }

    /// Before each frame that these eyes get (see TileStream); nothing to do where all is there. coverage: of
    /// which what is unseen may hide samples from them; it must outlive the scene here.
    void follow(std::span<const scene::View> eyes, const Quality& quality, const scene::Coverage* coverage = nullptr) {
        if (stream_) stream_->follow({eyes, quality, soon_}, coverage, places_);
    }
    void settle(std::span<const scene::View> eyes, const Quality& quality, const scene::Coverage* coverage = nullptr) {
        if (stream_) stream_->settle({eyes, quality, shares_}, coverage, places_);
    }

    /// Chunks found damaged since the last call: placeholders are drawn for them, of class unseen.
    std::vector<std::uint32_t> takeDamaged();

  private:
    void holdAll(const Device& device, std::span<const scene::TileBlock> blocks, const SceneMemory& memory);
    void holdSome(const Device& device, std::span<const scene::TileBlock> blocks, const SceneMemory& memory);
    void fill(const Device& device, std::span<const scene::TileBlock> blocks, std::span<const std::uint32_t> chunks);

    SceneIndex index_;
    std::vector<ChunkPlace> places_;
    std::unique_ptr<TilePool> pool_;
    std::vector<float> shares_, soon_;
    std::vector<std::uint32_t> damaged_;
    std::size_t bytesKept_ = 0;
    std::uint64_t changes_ = 0;
    std::unique_ptr<TileStream> stream_; ///< goes first; null where all is there
};

} // namespace render
