#pragma once
// Pictures as cameras and others write them: PNG by libspng, JPEG by libjpeg-turbo, and what these do not give as asked
// (PNG in grey, most of 16 bits, other formats, files they warn of) by OpenCV's imgcodecs. On that hang a hundred
// libraries, which took most of the program's start: it is loaded with the first picture it is needed for.

#include "scene/image.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

namespace cv {
class Mat;
}

namespace scene {

/// Never turned as a viewer is asked to turn them: depth is registered to the pixels as stored.
enum class PictureKind : std::uint8_t {
    colour,  ///< 8 bits each of blue, green, red
    grey,    ///< 8 bits
    asStored ///< channels (blue, green, red, alpha) and bits of the file
};

/// Pixels; what claims more along a side is no camera's.
inline constexpr int kMaxPictureSide = 65536;

/// Pixels.
struct PictureSize {
    int width = 0, height = 0;
};

/// What the header of a PNG, JPEG or TIFF says, before any memory is taken for it; nothing of other formats, and where
/// it says nothing.
std::optional<PictureSize> sizeInHeader(std::span<const std::uint8_t> bytes);

/// Empty where the bytes are no picture, are damaged, or have more than 2^30 pixels; PNG and JPEG also where they are
/// cut off, but for what is left to OpenCV: JPEGs of print's colours, of RGB in grey, and of next to no bytes. Throws
/// Failure where OpenCV's part cannot be loaded.
cv::Mat decodePicture(std::span<const std::uint8_t> bytes, PictureKind kind);
/// The file's bytes; empty also where it cannot be read.
std::vector<std::uint8_t> readPictureBytes(const std::filesystem::path& path);
/// Empty also where the file cannot be read.
cv::Mat readPicture(const std::filesystem::path& path, PictureKind kind);

/// PNG, compressed fast. Empty where there is no memory for it.
std::vector<std::uint8_t> encodePng(const Image<Rgb8>& picture);
std::vector<std::uint8_t> encodePng(const Image<std::uint8_t>& picture);
/// Of a picture of 8 bits each of blue, green, red.
std::vector<std::uint8_t> encodePng(const cv::Mat& picture);

/// What the library of other_pictures_module.cpp is asked for by name.
extern "C" void revisitDecodePicture(const std::uint8_t* bytes, std::size_t count, PictureKind kind, cv::Mat* picture);

} // namespace scene
