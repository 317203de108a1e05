#pragma once
// Images that had to leave memory, as they were: from here they come back at the speed of the disk's cache, ten times
// as fast as from their own files, which are compressed and checked. It is memory's extension and no result: a file
// without a name, gone with the process however it ends.

#include "scene/depth_image.h"

#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>

namespace scene {

class ImageSpill {
  public:
    /// Takes no more than this share of what is free on the folder's disk: the rest is for results.
    static constexpr double kShareOfFree = 0.25;

    /// Where the folder takes no such file nothing is kept, and nothing is said: images are then read from their own.
    explicit ImageSpill(const std::filesystem::path& folder, double shareOfFree = kShareOfFree);
    ~ImageSpill();
    ImageSpill(const ImageSpill&) = delete;
    ImageSpill& operator=(const ImageSpill&) = delete;

    /// Where an image's pixels lie, bytes from the start, and what else it consists of.
    struct Place {
        std::uint64_t at = 0;
        DepthImage header;
    };
    /// From any thread. None if there is no room.
    std::optional<Place> put(const DepthImage& image);
    /// From any thread, into the memory of spare where that is as large. None if it cannot be read any more.
    std::optional<DepthImage> get(const Place& place, DepthImage spare) const;

  private:
    int file_ = -1;
    std::mutex mutex_;
    std::uint64_t room_ = 0, end_ = 0;
};

} // namespace scene
