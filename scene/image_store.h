#pragma once
// The depth images of a build, lent one at a time: read from their files when asked for, kept as long as memory allows.

#include "scene/image_spill.h"

#include <condition_variable>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

namespace scene {

/// Where an image lies, and what can be known without its pixels. A flags file, if named, replaces the flags of the
/// image.
struct StoredImage {
    std::string name;
    Camera camera;
    Pose worldFromCamera;
    std::filesystem::path file, flagsFile;
};

/// Reads depth image files on demand from any thread. Images that nobody holds are dropped, least recently used first,
/// when the budget is full; what is held is never dropped, even beyond the budget.
class ImageStore {
  public:
    /// spillFolder: where what is dropped is laid aside, if there is room, to be had again sooner than from its file;
    /// for who asks for images again and again. Empty: nowhere.
    ImageStore(std::vector<StoredImage> images, std::size_t budgetBytes, const std::filesystem::path& spillFolder = {});
    /// A store whose images are simply given (tests, small scenes).
    explicit ImageStore(std::vector<DepthImage> images);
    /// Memory goes back to the system: what comes next wants it for something else.
    ~ImageStore();
    ImageStore(const ImageStore&) = delete;
    ImageStore& operator=(const ImageStore&) = delete;

    class Lease;
    std::size_t size() const { return entries_.size(); }
    const StoredImage& at(std::size_t index) const { return entries_[index].stored; }
    Lease borrow(std::size_t index);
    /// At the moment: asking for such an image first saves reading another.
    bool isResident(std::size_t index) const;
    std::size_t budgetBytes() const { return budgetBytes_; }
    /// Bytes of pixels held at the moment, and the most there ever were.
    std::size_t residentBytes() const;
    std::size_t peakBytes() const;

  private:
    enum class State { absent, busy, resident }; ///< busy: on its way in or out
    struct Entry {
        StoredImage stored;
        DepthImage image;
        State state = State::absent;
        int borrowers = 0;
        std::uint64_t lastUse = 0;
        std::optional<ImageSpill::Place> spilt{};
        Entry* nextToGo = nullptr;
    };
    void giveBack(std::size_t index);
    Entry* chooseToGo(std::size_t bytes);                          ///< so many as make room, in a list; busy
    DepthImage letGo(Entry* going, const Camera& camera) noexcept; ///< one of them, if it is as large
    DepthImage load(const Entry& entry, DepthImage spare) const;

    std::vector<Entry> entries_;
    std::size_t budgetBytes_, residentBytes_ = 0, peakBytes_ = 0;
    std::optional<ImageSpill> spill_;
    std::uint64_t clock_ = 0;
    mutable std::mutex mutex_;
    std::condition_variable moved_;
};

/// The right to read one image of the store while this lives.
class ImageStore::Lease {
  public:
    Lease(Lease&& other) noexcept
        : store_(std::exchange(other.store_, nullptr)), index_(other.index_), image_(other.image_) {}
    Lease(const Lease&) = delete;
    Lease& operator=(Lease&&) = delete;
    ~Lease() {
        if (store_) store_->giveBack(index_);
    }
    const DepthImage& operator*() const { return *image_; }
    const DepthImage* operator->() const { return image_; }

  private:
    friend class ImageStore;
    Lease(ImageStore* store, std::size_t index, const DepthImage* image)
        : store_(store), index_(index), image_(image) {}
    ImageStore* store_;
    std::size_t index_;
    const DepthImage* image_;
};

/// Calls visit once for each number below count, from no more than so many threads at a time. If a visit throws, no
/// other is begun, those under way are finished, whole, whatever they do in parallel themselves, and then the first
/// exception is thrown on: where visits leave results behind that others take for granted, none is ever half of one.
void visitEach(std::size_t count, std::size_t together, const std::function<void(std::size_t)>& visit);

/// The same for each of the store's images, from as many threads at a time as its budget has room for what each makes
/// and borrows: imagesEach, at least 1, times the bytes of the largest image. From one at least.
void visitEach(const ImageStore& images, std::size_t imagesEach, const std::function<void(std::size_t)>& visit);

} // namespace scene
