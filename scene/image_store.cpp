#include "scene/image_store.h"

#include "scene/depth_tiff.h"
#include "scene/errors.h"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <exception>
#include <limits>
#include <new>

#include <malloc.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

namespace scene {

ImageStore::ImageStore(std::vector<StoredImage> images, std::size_t budgetBytes,
                       const std::filesystem::path& spillFolder)
    : budgetBytes_(budgetBytes) {
    if (!spillFolder.empty()) spill_.emplace(spillFolder);
    entries_.resize(images.size());
    for (std::size_t i = 0; i < images.size(); ++i)
        entries_[i].stored = std::move(images[i]);
}

ImageStore::ImageStore(std::vector<DepthImage> images) : budgetBytes_(std::numeric_limits<std::size_t>::max()) {
    entries_.resize(images.size());
    for (std::size_t i = 0; i < images.size(); ++i) {
        entries_[i].stored = {images[i].name, images[i].camera, images[i].worldFromCamera, {}, {}};
        residentBytes_ += bytesOf(images[i].camera);
        entries_[i].image = std::move(images[i]);
        entries_[i].state = State::resident;
    }
    peakBytes_ = residentBytes_;
}

ImageStore::~ImageStore() {
    constexpr std::size_t kMuch = std::size_t{64} << 20;
    if (peakBytes_ < kMuch) return;
    entries_.clear();
    malloc_trim(0); // between what others hold, too
}

ImageStore::Lease ImageStore::borrow(std::size_t index) {
    std::unique_lock lock(mutex_);
    Entry& entry = entries_[index];
    ++entry.borrowers;
    entry.lastUse = ++clock_;
    moved_.wait(lock, [&] { return entry.state != State::busy; });
    if (entry.state == State::absent) {
        entry.state = State::busy;
        const std::size_t bytes = bytesOf(entry.stored.camera);
        Entry* const going = chooseToGo(bytes);
        residentBytes_ += bytes;
        peakBytes_ = std::max(peakBytes_, residentBytes_);
        lock.unlock();
        // Others may borrow and give back meanwhile; who wants one of these images waits.
        DepthImage spare = letGo(going, entry.stored.camera);
        try {
            DepthImage image = load(entry, std::move(spare));
            lock.lock();
            entry.image = std::move(image);
            entry.state = State::resident;
        } catch (...) {
            if (!lock.owns_lock()) lock.lock();
            entry.state = State::absent;
            residentBytes_ -= bytes;
            --entry.borrowers;
            moved_.notify_all();
            throw;
        }
        moved_.notify_all();
    }
    return {this, index, &entry.image};
}

DepthImage ImageStore::load(const Entry& entry, DepthImage spare) const {
    if (entry.spilt) {
        std::optional<DepthImage> image = spill_->get(*entry.spilt, std::move(spare));
        if (image) return std::move(*image);
        spare = {};
    }
    const StoredImage& stored = entry.stored;
    DepthImage image = readDepthTiff(stored.file, std::move(spare));
    if (image.camera.width != stored.camera.width || image.camera.height != stored.camera.height)
        throw Failure("is not the image that the scene lists: its size differs", stored.file,
                      "remove it and build the scene again");
    if (!stored.flagsFile.empty()) image.flags = readFlagsTiff(stored.flagsFile, image.camera);
    return image;
}

bool ImageStore::isResident(std::size_t index) const {
    const std::lock_guard lock(mutex_);
    return entries_[index].state == State::resident;
}

std::size_t ImageStore::residentBytes() const {
    const std::lock_guard lock(mutex_);
    return residentBytes_;
}

std::size_t ImageStore::peakBytes() const {
    const std::lock_guard lock(mutex_);
    return peakBytes_;
}

void ImageStore::giveBack(std::size_t index) {
    const std::lock_guard lock(mutex_);
    --entries_[index].borrowers;
}

ImageStore::Entry* ImageStore::chooseToGo(std::size_t bytes) {
    Entry* going = nullptr;
    while (residentBytes_ + bytes > budgetBytes_) {
        Entry* oldest = nullptr;
        for (Entry& entry : entries_)
            if (entry.state == State::resident && entry.borrowers == 0 && (!oldest || entry.lastUse < oldest->lastUse))
                oldest = &entry;
        if (!oldest) break;
        residentBytes_ -= bytesOf(oldest->stored.camera);
        oldest->state = State::busy;
        oldest->nextToGo = std::exchange(going, oldest);
    }
    return going;
}

DepthImage ImageStore::letGo(Entry* going, const Camera& camera) noexcept {
    DepthImage spare;
    for (Entry* entry = going; entry; entry = entry->nextToGo) {
        try {
            if (spill_ && !entry->spilt) entry->spilt = spill_->put(entry->image);
        } catch (const std::bad_alloc&) {
            // Then it is read from its file.
        }
        const Camera& old = entry->stored.camera;
        if (old.width == camera.width && old.height == camera.height) spare = std::move(entry->image);
        entry->image = {};
    }
    if (!going) return spare;
    const std::lock_guard lock(mutex_);
    while (going) {
        going->state = State::absent;
        going = std::exchange(going->nextToGo, nullptr);
    }
    moved_.notify_all();
    return spare;
}

void visitEach(std::size_t count, std::size_t together, const std::function<void(std::size_t)>& visit) {
    std::atomic<std::size_t> next = 0;
    std::atomic<bool> hasFailed = false;
    std::exception_ptr failure;
    const auto visitSome = [&](const tbb::blocked_range<std::size_t>&) {
        for (std::size_t i = next++; i < count; i = next++) {
            try {
                // Isolated: a thread that waits within a visit would begin another.
                tbb::this_task_arena::isolate([&] { visit(i); });
            } catch (...) {
                // Of an exception that reached it oneTBB would cancel what the other visits do in parallel, too, and
                // they would go on as if it were done.
                if (!hasFailed.exchange(true)) failure = std::current_exception();
                next = count;
            }
        }
    };
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, std::max<std::size_t>(together, 1), 1), visitSome,
                      tbb::simple_partitioner());
    if (failure) std::rethrow_exception(failure);
}

void visitEach(const ImageStore& images, std::size_t imagesEach, const std::function<void(std::size_t)>& visit) {
    assert(imagesEach > 0);
    std::size_t largest = 1;
    for (std::size_t i = 0; i < images.size(); ++i)
        largest = std::max(largest, bytesOf(images.at(i).camera));
    const auto threads = static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
    visitEach(images.size(), std::min(images.budgetBytes() / largest / imagesEach, threads), visit);
}

} // namespace scene
