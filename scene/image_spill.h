#pragma once
// Images that had to leave memory, as they were: from here they come back at the speed of the disk's cache, ten times
// as fast as from their own files, which are compressed. It is memory's extension and no result: a file without a name,
// gone with the process.

#include "scene/depth_image.h"

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>

namespace scene {

class ImageSpill {
  public:
    /// Takes no more than this share of what is free on the folder's disk, whenever it takes any: the rest is for
    /// results.
    static constexpr double kShareOfFree = 0.25;

    /// Where the folder takes no such file nothing is kept, and nothing is said: images are then read from their own.
    explicit ImageSpill(const std::filesystem::path& folder, double shareOfFree = kShareOfFree);
    ~ImageSpill();
    ImageSpill(const ImageSpill&) = delete;
    ImageSpill& operator=(const ImageSpill&) = delete;

    /// Where an image's pixels lie, bytes from the start, and what else is known of it.
    struct Place {
        std::uint64_t at = 0, checksum = 0;
        DepthImage header;
    };
    /// From any thread. None if there is no room. A disk that turns out to be full is given back all that was taken.
    std::optional<Place> put(const DepthImage& image);
    /// From any thread, into the memory of spare where that is as large. None if it is not there any more as it was.
    std::optional<DepthImage> get(const Place& place, DepthImage spare) const;

  private:
    std::optional<std::uint64_t> take(std::uint64_t bytes);

    std::filesystem::path folder_;
    double shareOfFree_;
    int file_ = -1;
    std::atomic<bool> isGone_ = false; ///< set before its bytes are given back
    std::mutex mutex_;
    std::uint64_t end_ = 0;
};

} // namespace scene
