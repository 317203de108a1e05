#include "scene/image_spill.h"

#include "scene/checksum.h"

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
    if (named < 0 || unlink(name.c_str()) == 0) return named;
    close(named);
    return -1;
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

ImageSpill::ImageSpill(const std::filesystem::path& folder, double shareOfFree)
    : folder_(folder), shareOfFree_(shareOfFree), file_(openNameless(folder)) {}

ImageSpill::~ImageSpill() {
    if (file_ >= 0) close(file_);
}

std::optional<std::uint64_t> ImageSpill::take(std::uint64_t bytes) {
    if (file_ < 0 || isGone_) return {};
    const std::lock_guard lock(mutex_);
    std::error_code error;
    const std::filesystem::space_info space = std::filesystem::space(folder_, error);
    const double free = static_cast<double>(space.available) + static_cast<double>(end_);
    if (error || static_cast<double>(end_ + bytes) > shareOfFree_ * free) return {};
    return std::exchange(end_, end_ + bytes);
}

std::optional<ImageSpill::Place> ImageSpill::put(const DepthImage& image) {
    const std::optional<std::uint64_t> at = take(bytesOf(image.camera));
    if (!at) return {};
    Checksum sum;
    std::uint64_t next = *at;
    const bool isWhole = forPictures(image, [&](std::span<const std::byte> picture) {
        sum.add(picture);
        const std::uint64_t from = std::exchange(next, next + picture.size());
        return moveAll(pwrite, file_, picture, from);
    });
    if (!isWhole) {
        isGone_ = true;
        // What cannot be given back goes with the process.
        static_cast<void>(ftruncate(file_, 0) == 0);
        return {};
    }
    return Place{*at, sum.value(), {image.name, image.camera, image.worldFromCamera, {}, {}, {}}};
}

std::optional<DepthImage> ImageSpill::get(const Place& place, DepthImage spare) const {
    if (isGone_) return {};
    DepthImage image = std::move(spare);
    image.name = place.header.name, image.camera = place.header.camera;
    image.worldFromCamera = place.header.worldFromCamera;
    fit(image.colour, image.camera), fit(image.disparity, image.camera), fit(image.flags, image.camera);
    Checksum sum;
    std::uint64_t next = place.at;
    const bool isWhole = forPictures(image, [&](std::span<std::byte> picture) {
        const std::uint64_t from = std::exchange(next, next + picture.size());
        const bool isRead = moveAll(pread, file_, picture, from);
        sum.add(picture);
        return isRead;
    });
    if (!isWhole || sum.value() != place.checksum) return {};
    return image;
}

} // namespace scene
