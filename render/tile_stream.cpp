#include "render/tile_stream.h"

#include "render/check.h"
#include "render/chunk_bytes.h"
#include "render/command_streams.h"
#include "render/device.h"
#include "scene/tile_chunks.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cstring>
#include <utility>

namespace render {

namespace {

/// A chunk that is not drawn any more from frame n on may still be read by frames before; a renderer waits for the
/// frame two before, and two renderers may take turns.
constexpr std::uint64_t kRestFrames = 6;

/// Of the room, what is ever asked for at once: ranges of all sizes leave gaps, and what leaves does so after what
/// comes.
constexpr double kFillShare = 0.85;

/// What is asked for where there is room, but in pieces too small.
constexpr std::uint64_t kAnother = 4 * scene::kChunkBytes / kTexelBytes;

constexpr double kStepMetres = 0.5;

constexpr std::size_t kStagingBytes = std::size_t{8} << 20; ///< copied within one frame at most

} // namespace

struct TileStream::Copy {
    explicit Copy(const Device& on) : device(on) {
        recorder = makeRecorder(device);
        done = makeFence(device, 0);
        staging = Buffer(device, kStagingBytes, VK_BUFFER_USAGE_TRANSFER_SRC_BIT, MemoryUse::hostWrites);
    }

    const Device& device;
    Buffer staging;
    Recorder recorder;
    Fence done;
    std::vector<Arrival> running; ///< what is being copied
};

TileStream::TileStream(const Device& device, const SceneIndex& index, std::span<const scene::TileBlock> blocks,
                       const TilePool& pool, std::span<const std::uint32_t> kept, std::vector<RangeAllocator> free)
    : device_(device), index_(index), blocks_(blocks), pool_(pool), coarser_(coarserChunksOf(index)),
      isStaged_(pool.mapped({0, 0, false}) == nullptr), free_(std::move(free)),
      states_(index.chunks.size(), State::absent), loaded_(index.chunks.size()) {
    for (const std::uint32_t chunk : kept)
        states_[chunk] = State::kept;
    for (const RangeAllocator& page : free_)
        roomTexels_ += page.free();
    if (isStaged_) copy_ = std::make_unique<Copy>(device);
    thread_ = std::thread([this] { work(); });
}

TileStream::~TileStream() {
    {
        const std::lock_guard lock(mutex_);
        isEnding_ = true;
    }
    wished_.notify_all();
    thread_.join();
    if (copy_ && !copy_->running.empty()) static_cast<void>(vkDeviceWaitIdle(device_));
}

void TileStream::follow(const LookedAt& looked, const scene::Coverage* coverage, std::span<ChunkPlace> places) {
    ++frame_;
    if (std::exchange(showsOnlyDesired_, false)) {
        ++changes_;
        const std::lock_guard lock(mutex_);
        std::vector<bool> isOnItsWay(places.size(), false);
        for (const Arrival& arrival : arrived_)
            isOnItsWay[arrival.chunk] = true;
        for (std::size_t i = 0; i < places.size(); ++i) // settle has left nothing on the way to be copied
            if (states_[i] == State::there && !isOnItsWay[i]) places[i] = loaded_[i];
    }
    takeOver(places, false);
    copyArrived(places);
    wish(looked, coverage, false);
}

void TileStream::settle(const LookedAt& looked, const scene::Coverage* coverage, std::span<ChunkPlace> places) {
    ++frame_;
    const std::uint64_t number = wish(looked, coverage, true);
    for (;;) {
        takeOver(places, true);
        while (copy_ && (!toCopy_.empty() || !copy_->running.empty())) {
            copyArrived(places);
            check(vkDeviceWaitIdle(device_));
        }
        std::unique_lock lock(mutex_);
        served_.wait(lock, [&] { return answered_ >= number || !arrived_.empty() || !mustLeave_.empty(); });
        if (answered_ < number || !arrived_.empty() || !mustLeave_.empty()) continue;
        std::vector<bool> isDesired(places.size(), false);
        for (const std::uint32_t chunk : desired_)
            isDesired[chunk] = true;
        for (std::size_t i = 0; i < places.size(); ++i)
            if (states_[i] == State::there) places[i] = isDesired[i] ? loaded_[i] : ChunkPlace{};
        showsOnlyDesired_ = true;
        ++changes_;
        return;
    }
}

std::uint64_t TileStream::wish(const LookedAt& looked, const scene::Coverage* coverage, bool isSettling) {
    std::uint64_t number = 0;
    {
        const std::lock_guard lock(mutex_);
        wish_.eyes.assign(looked.eyes.begin(), looked.eyes.end());
        wish_.quality = looked.quality;
        wish_.shares.assign(looked.shares.begin(), looked.shares.end());
        wish_.coverage = looked.quality.leavesOutBehindUnseen() ? coverage : nullptr;
        wish_.isSettling = isSettling;
        number = ++wish_.number;
        hasNews_ = true;
    }
    wished_.notify_one();
    return number;
}

void TileStream::takeOver(std::span<ChunkPlace> places, bool isIdle) {
    const std::lock_guard lock(mutex_);
    for (Arrival& arrival : arrived_) {
        if (isStaged_)
            toCopy_.push_back(std::move(arrival));
        else
            ++changes_, places[arrival.chunk] = arrival.place;
    }
    arrived_.clear();
    const auto stillOnItsWay = [&](std::uint32_t chunk) {
        const auto isIt = [&](const Arrival& arrival) { return arrival.chunk == chunk; };
        return std::any_of(toCopy_.begin(), toCopy_.end(), isIt) ||
               (copy_ && std::any_of(copy_->running.begin(), copy_->running.end(), isIt));
    };
    std::erase_if(mustLeave_, [&](std::uint32_t chunk) {
        if (isStaged_ && stillOnItsWay(chunk)) return false;
        ++changes_, places[chunk] = {};
        resting_.push_back({chunk, frame_});
        return true;
    });
    std::erase_if(resting_, [&](const Resting& resting) {
        if (!isIdle && frame_ < resting.frame + kRestFrames) return false;
        hasLeft_.push_back(resting.chunk);
        hasNews_ = true;
        return true;
    });
    wished_.notify_one();
}

void TileStream::copyArrived(std::span<ChunkPlace> places) {
    if (!copy_) return;
    if (!copy_->running.empty()) {
        const VkResult status = vkGetFenceStatus(device_, copy_->done);
        if (status == VK_NOT_READY) return;
        check(status);
        for (const Arrival& arrival : copy_->running)
            ++changes_, places[arrival.chunk] = arrival.place;
        copy_->running.clear();
    }
    if (toCopy_.empty()) return;
    check(vkResetFences(device_, 1, copy_->done.address()));
    check(vkResetCommandPool(device_, copy_->recorder.pool, 0));
    VkCommandBufferBeginInfo begin{};
    begin.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
    begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    check(vkBeginCommandBuffer(copy_->recorder.commands, &begin));
    std::size_t at = 0;
    while (!toCopy_.empty() && at + toCopy_.front().bytes.size() <= kStagingBytes) {
        Arrival& arrival = toCopy_.front();
        std::memcpy(copy_->staging.mapped() + at, arrival.bytes.data(), arrival.bytes.size());
        const VkBufferCopy region{at, std::size_t{arrival.place.firstTexel} * kTexelBytes, arrival.bytes.size()};
        vkCmdCopyBuffer(copy_->recorder.commands, copy_->staging.handle(), pool_.bufferOf(arrival.place.page), 1,
                        &region);
        at += arrival.bytes.size();
        arrival.bytes = {};
        copy_->running.push_back(std::move(arrival));
        toCopy_.pop_front();
    }
    record(copy_->recorder.commands, {VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
                                      VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_READ_BIT});
    check(vkEndCommandBuffer(copy_->recorder.commands));
    VkSubmitInfo submit{};
    submit.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &copy_->recorder.commands;
    check(vkQueueSubmit(device_.queue(), 1, &submit, copy_->done));
}

std::vector<std::uint32_t> TileStream::takeDamaged() {
    const std::lock_guard lock(mutex_);
    return std::exchange(damaged_, {});
}

StreamCounts TileStream::counts() const {
    const std::lock_guard lock(mutex_);
    return counts_;
}

void TileStream::work() {
    std::unique_lock lock(mutex_);
    for (;;) {
        wished_.wait(lock, [&] { return hasNews_ || isEnding_; });
        if (isEnding_) return;
        hasNews_ = false;
        for (const std::uint32_t chunk : std::exchange(hasLeft_, {})) {
            free_[loaded_[chunk].page].give(loaded_[chunk].firstTexel, index_.chunks[chunk].texels());
            states_[chunk] = State::absent;
            ++counts_.left;
            counts_.bytesThere -= index_.chunks[chunk].chunk.bytes();
        }
        const Wish wish = wish_;
        if (wish.number == 0) continue;
        if (!wish.isSettling && fulfilled_ && wish.coverage == fulfilled_->coverage &&
            wantAboutTheSame(wish.looked(), fulfilled_->looked()))
            continue;
        fulfilled_.reset(); // what it has there may have to leave
        lock.unlock();
        serve(wish);
        lock.lock();
    }
}

bool TileStream::isInterrupted() const {
    const std::lock_guard lock(mutex_);
    return isEnding_ || (hasNews_ && !wish_.isSettling);
}

void TileStream::serve(const Wish& wish) {
    const Choice choice = choose(wish);
    const std::span<const std::uint32_t> desired = std::span(choice.wanted).first(choice.count);
    askToLeave(choice);
    constexpr int kLoadsAtLeast = 4; // before what is wanted is thought over again
    int loads = 0;
    for (const std::uint32_t chunk : desired) {
        if (states_[chunk] == State::there || states_[chunk] == State::kept) continue;
        // One that is leaving must have left before it can come again, or others before there is room.
        if (states_[chunk] == State::leaving) return;
        if (!load(chunk)) {
            if (makeRoom(choice, kAnother)) return;
            // What is there lies so that gaps are too small. What fits must not hang on what was there before.
            if (wish.isSettling && startedOver_ != wish.number) {
                startedOver_ = wish.number;
                makeRoom({{}, 0}, roomTexels_);
                return;
            }
        }
        if (++loads >= kLoadsAtLeast && isInterrupted()) return;
    }
    {
        const std::lock_guard lock(mutex_);
        answered_ = wish.number;
        fulfilled_ = wish;
        desired_.assign(desired.begin(), desired.end());
    }
    served_.notify_all();
}

void TileStream::findWays(const Wish& wish) {
    const bool isOther = wish.coverage != (grid_ ? &grid_->coverage() : nullptr);
    // What is found holds for some steps about: which, must not hang on where the eyes were before.
    if ((wish.isSettling && wish.number != waysFor_) || isOther) ways_.forget();
    if (wish.isSettling) waysFor_ = wish.number;
    if (isOther) grid_.reset();
    if (wish.coverage == nullptr) return;
    if (!grid_) grid_.emplace(*wish.coverage);
    std::vector<glm::dvec3> eyes;
    for (const scene::View& eye : wish.eyes)
        eyes.push_back(eye.worldFromEye.translation);
    if (scene::OpenWays::standClear(*grid_, eyes)) {
        ways_.standAt(*grid_, eyes);
        stoodClear_ = eyes.front();
    } else if (glm::distance(eyes.front(), stoodClear_) > kStepMetres) {
        // Eyes beside something unseen may see anything. A step aside need not change what is fetched first.
        ways_.forget();
    }
}

TileStream::Choice TileStream::choose(const Wish& wish) {
    findWays(wish);
    Choice choice{chunksWanted(index_, coarser_, wish.looked(&ways_)), 0};
    std::erase_if(choice.wanted, [&](std::uint32_t chunk) { return states_[chunk] == State::kept; });
    std::uint64_t texels = 0;
    for (const std::uint32_t chunk : choice.wanted) {
        texels += index_.chunks[chunk].texels();
        if (static_cast<double>(texels) > kFillShare * static_cast<double>(roomTexels_)) break;
        ++choice.count;
    }
    return choice;
}

void TileStream::askToLeave(const Choice& choice) {
    std::uint64_t needed = 0, free = 0;
    for (std::size_t i = 0; i < choice.count; ++i)
        if (states_[choice.wanted[i]] == State::absent) needed += index_.chunks[choice.wanted[i]].texels();
    for (const RangeAllocator& page : free_)
        free += page.free();
    for (std::size_t i = 0; i < states_.size(); ++i)
        if (states_[i] == State::leaving) free += index_.chunks[i].texels();
    if (free < needed) makeRoom(choice, needed - free);
}

bool TileStream::makeRoom(const Choice& choice, std::uint64_t texels) {
    // What nobody wants goes first, then what is wanted least.
    std::vector<bool> isWanted(states_.size(), false);
    for (const std::uint32_t chunk : choice.wanted)
        isWanted[chunk] = true;
    std::vector<std::uint32_t> candidates;
    for (std::uint32_t i = 0; i < states_.size(); ++i)
        if (states_[i] == State::there && !isWanted[i]) candidates.push_back(i);
    for (std::size_t i = choice.wanted.size(); i > choice.count; --i)
        if (states_[choice.wanted[i - 1]] == State::there) candidates.push_back(choice.wanted[i - 1]);
    std::size_t count = 0;
    for (std::uint64_t made = 0; count < candidates.size() && made < texels; ++count)
        made += index_.chunks[candidates[count]].texels();
    candidates.resize(count);
    {
        const std::lock_guard lock(mutex_);
        for (const std::uint32_t chunk : candidates)
            states_[chunk] = State::leaving;
        mustLeave_.insert(mustLeave_.end(), candidates.begin(), candidates.end());
    }
    served_.notify_all();
    return std::find(states_.begin(), states_.end(), State::leaving) != states_.end();
}

bool TileStream::load(std::uint32_t number) {
    const IndexedChunk& chunk = index_.chunks[number];
    std::optional<ChunkPlace> place;
    for (std::uint32_t page = 0; page < free_.size() && !place; ++page)
        if (const auto first = free_[page].take(chunk.texels())) place = {page, *first, false};
    if (!place) return false;
    const std::size_t bytes = chunk.chunk.bytes();
    Arrival arrival{number, *place, {}};
    if (isStaged_) arrival.bytes.resize(bytes);
    std::byte* const to = isStaged_ ? arrival.bytes.data() : pool_.mapped(*place);
    arrival.place.isDamaged = !bringChunk(blocks_[chunk.captured], chunk, to);
    {
        const std::lock_guard lock(mutex_);
        states_[number] = State::there;
        loaded_[number] = arrival.place;
        if (arrival.place.isDamaged) damaged_.push_back(number);
        ++counts_.loaded;
        counts_.bytesLoaded += bytes;
        counts_.bytesThere += bytes;
        arrived_.push_back(std::move(arrival));
    }
    served_.notify_all();
    return true;
}

} // namespace render
