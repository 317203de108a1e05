#pragma once
// Chunks on their way between disk and device, in the background, for a scene that is larger than what it may take.
//
// A thread of its own decides what should be there (render/residency.h), reads and checks it, and writes it into the
// pool. The thread that draws learns at the start of a frame what has arrived and what must go; a place is used again
// only after all frames have ended that may have read it.

#include "render/range_allocator.h"
#include "render/residency.h"
#include "render/resources.h"
#include "render/tile_pool.h"

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <thread>
#include <vector>

namespace render {

struct StreamCounts {
    std::uint64_t loaded = 0, left = 0, bytesLoaded = 0; ///< chunks so far
    std::size_t bytesThere = 0;                          ///< of those that come and go
};

class TileStream {
  public:
    /// All must outlive it. kept: chunks that are in their places and stay there. free: what is left of each page of
    /// the pool.
    TileStream(const Device& device, const SceneIndex& index, std::span<const scene::TileBlock> blocks,
               const TilePool& pool, std::span<const std::uint32_t> kept, std::vector<RangeAllocator> free);
    ~TileStream();
    TileStream(const TileStream&) = delete;
    TileStream& operator=(const TileStream&) = delete;

    /// Once before each frame, by the thread that draws: takes over what has arrived, gives back what nobody may be
    /// reading any more, and says what the eyes now look at. Never waits for the disk.
    /// coverage: of which what is unseen may hide chunks, and which must outlive it; null: nothing does.
    void follow(const LookedAt& looked, const scene::Coverage* coverage, std::span<ChunkPlace> places);

    /// Waits until all is there that these eyes want and that fits, and shows just that, so that what is drawn depends
    /// on the eyes alone. No frame may be running on the device.
    void settle(const LookedAt& looked, const scene::Coverage* coverage, std::span<ChunkPlace> places);

    /// Chunks that were found damaged since the last call, and are drawn as placeholders.
    std::vector<std::uint32_t> takeDamaged();
    StreamCounts counts() const;
    /// How often what is there has changed, for the thread that draws.
    std::uint64_t changes() const { return changes_; }

  private:
    enum class State : std::uint8_t { absent, there, leaving, kept };
    struct Arrival {
        std::uint32_t chunk = 0;
        ChunkPlace place;
        std::vector<std::byte> bytes; ///< where the processor cannot write them to their place itself
    };
    struct Resting {
        std::uint32_t chunk = 0;
        std::uint64_t frame = 0; ///< from which on it was not drawn
    };
    struct Wish {
        std::vector<scene::View> eyes;
        Quality quality;
        std::vector<float> shares;
        const scene::Coverage* coverage = nullptr;
        std::uint64_t number = 0;
        bool isSettling = false;

        LookedAt looked(const scene::OpenWays* ways = nullptr) const { return {eyes, quality, shares, ways}; }
    };
    struct Copy; ///< what goes through a staging buffer

    // The thread that draws.
    std::uint64_t wish(const LookedAt& looked, const scene::Coverage* coverage, bool isSettling);
    void takeOver(std::span<ChunkPlace> places, bool isIdle);
    void copyArrived(std::span<ChunkPlace> places);

    // The thread that streams.
    void work();
    void serve(const Wish& wish);
    struct Choice {
        std::vector<std::uint32_t> wanted; ///< most wanted first
        std::size_t count = 0;             ///< of the first that fit
    };
    Choice choose(const Wish& wish);
    void findWays(const Wish& wish);
    bool makeRoom(const Choice& choice, std::uint64_t texels);
    void askToLeave(const Choice& choice);
    bool load(std::uint32_t chunk);
    bool isInterrupted() const;

    const Device& device_;
    const SceneIndex& index_;
    std::span<const scene::TileBlock> blocks_;
    const TilePool& pool_;
    const CoarserChunks coarser_;
    std::uint64_t roomTexels_ = 0; ///< for what is not kept
    bool isStaged_;

    // Of the thread that draws.
    std::uint64_t frame_ = 0, changes_ = 0;
    std::vector<Resting> resting_; ///< not drawn any more, but perhaps still read
    std::deque<Arrival> toCopy_;
    std::unique_ptr<Copy> copy_;
    bool showsOnlyDesired_ = false;

    // Of the thread that streams.
    std::vector<RangeAllocator> free_;
    std::optional<scene::OpenGrid> grid_; ///< of the coverage of the last wish, if it was of any
    scene::OpenWays ways_;
    glm::dvec3 stoodClear_{0};      ///< where the first eye was when they were last known
    std::uint64_t waysFor_ = 0;     ///< number of the last wish for which they were found anew whatever they were
    std::uint64_t startedOver_ = 0; ///< number of the last wish for which all was thrown away

    // Under the mutex.
    mutable std::mutex mutex_;
    std::condition_variable wished_, served_;
    Wish wish_;
    std::uint64_t answered_ = 0;    ///< number of the last wish that was fulfilled
    std::optional<Wish> fulfilled_; ///< and nothing was begun for another since
    bool hasNews_ = false, isEnding_ = false;
    std::vector<State> states_;
    std::vector<ChunkPlace> loaded_; ///< where those are that are there
    std::vector<Arrival> arrived_;
    std::vector<std::uint32_t> mustLeave_, hasLeft_, damaged_, desired_;
    StreamCounts counts_;

    std::thread thread_; ///< goes first
};

} // namespace render
