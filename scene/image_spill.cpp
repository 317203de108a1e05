#include "scene/image_spill.h"

#include <cerrno>
#include <cstdlib>
#include <span>
#include <string>
#include <system_error>
#include <type_traits>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

namespace scene {

namespace {

int openNameless(const std::filesystem::path& folder) {
    const int file = open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
    if (file >= 0) return file;
    // Not every file system has files without names.
    std::string name = folder / ".spill-XXXXXX";
    const int named = mkostemp(name.data(), O_CLOEXEC);
    if (named >= 0) unlink(name.c_str());
    return named;
}

/// Of all bytes, with a call like pread or pwrite.
template <class Move, class Byte>
bool moveAll(const Move& move, int file, std::span<Byte> bytes, std::uint64_t at) {
    while (!bytes.empty()) {
        const ssize_t moved = move(file, bytes.data(), bytes.size(), static_cast<off_t>(at));
        if (moved < 0 && errno == EINTR) continue;
        if (moved <= 0) return false;
        bytes = bytes.subspan(static_cast<std::size_t>(moved)), at += static_cast<std::uint64_t>(moved);
    }
    return true;
}

/// Calls visit with the bytes of each of an image's pictures.
template <class AnyImage, class Visit>
bool forPictures(AnyImage& image, const Visit& visit) {
    const auto bytes = [](auto& picture) {
        if constexpr (std::is_const_v<AnyImage>)
            return std::as_bytes(picture.pixels());
        else
            return std::as_writable_bytes(picture.pixels());
    };
    return visit(bytes(image.colour)) && visit(bytes(image.disparity)) && visit(bytes(image.flags));
}

template <class T>
void fit(Image<T>& picture, const Camera& camera) {
    if (picture.width() != camera.width || picture.height() != camera.height)
        picture = Image<T>(camera.width, camera.height);
}

} // namespace

ImageSpill::ImageSpill(const std::filesystem::path& folder, double shareOfFree) : file_(openNameless(folder)) {
    std::error_code error;
    const std::filesystem::space_info space = std::filesystem::space(folder, error);
    if (file_ >= 0 && !error) room_ = static_cast<std::uint64_t>(shareOfFree * static_cast<double>(space.available));
}

ImageSpill::~ImageSpill() {
    if (file_ >= 0) close(file_);
}

std::optional<ImageSpill::Place> ImageSpill::put(const DepthImage& image) {
    const std::uint64_t bytes = bytesOf(image.camera);
    std::uint64_t at = 0;
    {
        const std::lock_guard lock(mutex_);
        if (bytes > room_ - end_) return {};
        at = std::exchange(end_, end_ + bytes);
    }
    std::uint64_t next = at;
    const bool isWhole = forPictures(image, [&](std::span<const std::byte> picture) {
        const std::uint64_t from = std::exchange(next, next + picture.size());
        return moveAll(pwrite, file_, picture, from);
    });
    if (!isWhole) {
        const std::lock_guard lock(mutex_);
        room_ = end_; // the disk is full, or worse
        return {};
    }
    return Place{at, {image.name, image.camera, image.worldFromCamera, {}, {}, {}}};
}

std::optional<DepthImage> ImageSpill::get(const Place& place, DepthImage spare) const {
    DepthImage image = std::move(spare);
    image.name = place.header.name, image.camera = place.header.camera;
    image.worldFromCamera = place.header.worldFromCamera;
    fit(image.colour, image.camera), fit(image.disparity, image.camera), fit(image.flags, image.camera);
    std::uint64_t next = place.at;
    const bool isWhole = forPictures(image, [&](std::span<std::byte> picture) {
        const std::uint64_t from = std::exchange(next, next + picture.size());
        return moveAll(pread, file_, picture, from);
    });
    if (!isWhole) return {};
    return image;
}

} // namespace scene
