#include "scene/picture_codec.h"

#include "scene/late_library.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <memory>
#include <new>
#include <optional>

#include <opencv2/core.hpp>
#include <spng.h>
#include <turbojpeg.h>

namespace scene {

namespace {

constexpr std::uint64_t kMostPixels = std::uint64_t{1} << 30;
/// Deflate makes at most so many bytes of one: a file that claims more pixels is damaged, and no memory is taken for
/// it.
constexpr std::uint64_t kBestDeflate = 1040;

/// OpenCV counts bytes in an int.
constexpr std::size_t kMostBytes = std::numeric_limits<int>::max();
/// Huffman's codes take a bit at least of each square of 8x8 pixels.
constexpr std::uint64_t kBestHuffman = 512;

using Bytes = std::span<const std::uint8_t>;

/// Nothing: of a kind that is left to OpenCV.
using Decoded = std::optional<cv::Mat>;

void swapRedAndBlue(cv::Mat& picture) {
    for (int y = 0; y < picture.rows; ++y) {
        std::uint8_t* const row = picture.ptr(y);
        for (int x = 0; x < picture.cols; ++x)
            std::swap(row[picture.channels() * x], row[picture.channels() * x + 2]);
    }
}

struct FreeSpng {
    void operator()(spng_ctx* context) const { spng_ctx_free(context); }
};
using Spng = std::unique_ptr<spng_ctx, FreeSpng>;

struct PngFormat {
    int spng, type; ///< type: OpenCV's
};

std::optional<PngFormat> formatOf(spng_ctx* png, const spng_ihdr& header, PictureKind kind) {
    if (kind == PictureKind::colour) return PngFormat{SPNG_FMT_RGB8, CV_8UC3};
    if (kind == PictureKind::grey) return std::nullopt;
    spng_trns transparency;
    const bool isTransparent = spng_get_trns(png, &transparency) == 0;
    switch (header.color_type) {
    case SPNG_COLOR_TYPE_GRAYSCALE:
        return header.bit_depth == 16 ? PngFormat{SPNG_FMT_PNG, CV_16UC1} : PngFormat{SPNG_FMT_G8, CV_8UC1};
    case SPNG_COLOR_TYPE_TRUECOLOR:
    case SPNG_COLOR_TYPE_INDEXED:
        if (header.bit_depth == 16 || isTransparent) return std::nullopt;
        return PngFormat{SPNG_FMT_RGB8, CV_8UC3};
    case SPNG_COLOR_TYPE_TRUECOLOR_ALPHA:
        if (header.bit_depth == 16) return std::nullopt;
        return PngFormat{SPNG_FMT_RGBA8, CV_8UC4};
    default:
        return std::nullopt;
    }
}

Decoded decodePng(Bytes bytes, PictureKind kind) {
    const Spng png(spng_ctx_new(0));
    if (!png) return cv::Mat();
    spng_set_crc_action(png.get(), SPNG_CRC_ERROR, SPNG_CRC_DISCARD);
    spng_ihdr header;
    if (spng_set_png_buffer(png.get(), bytes.data(), bytes.size()) != 0 || spng_get_ihdr(png.get(), &header) != 0)
        return cv::Mat();
    const std::uint64_t pixels = std::uint64_t{header.width} * header.height;
    if (pixels > kMostPixels || pixels * header.bit_depth / 8 > bytes.size() * kBestDeflate) return cv::Mat();
    const std::optional<PngFormat> format = formatOf(png.get(), header, kind);
    if (!format) return std::nullopt;
    cv::Mat picture(static_cast<int>(header.height), static_cast<int>(header.width), format->type);
    if (spng_decode_image(png.get(), picture.data, picture.total() * picture.elemSize(), format->spng, 0) != 0)
        return cv::Mat();
    if (picture.channels() >= 3) swapRedAndBlue(picture);
    return picture;
}

struct FreeJpeg {
    void operator()(void* handle) const { tjDestroy(handle); }
};

Decoded decodeJpeg(Bytes bytes, PictureKind kind) {
    const std::unique_ptr<void, FreeJpeg> jpeg(tjInitDecompress());
    if (!jpeg) return cv::Mat();
    int width = 0, height = 0, sampling = 0, space = 0;
    if (tjDecompressHeader3(jpeg.get(), bytes.data(), bytes.size(), &width, &height, &sampling, &space) != 0)
        return std::nullopt;
    if (space == TJCS_CMYK || space == TJCS_YCCK) return std::nullopt;
    if (kind == PictureKind::grey && space == TJCS_RGB) return std::nullopt;
    const std::uint64_t pixels = static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
    if (pixels > kMostPixels) return cv::Mat();
    if (pixels > bytes.size() * kBestHuffman) return std::nullopt;
    const bool isGrey = kind == PictureKind::grey || (kind == PictureKind::asStored && space == TJCS_GRAY);
    cv::Mat picture(height, width, isGrey ? CV_8UC1 : CV_8UC3);
    // The first warning ends it: after one, TurboJPEG does not tell what else went wrong.
    if (tjDecompress2(jpeg.get(), bytes.data(), bytes.size(), picture.data, width, 0, height,
                      isGrey ? TJPF_GRAY : TJPF_BGR, TJFLAG_STOPONWARNING) == 0)
        return picture;
    // What is cut off would go on in grey that nobody photographed. Of other warnings cameras' files are full.
    if (std::strstr(tjGetErrorStr2(jpeg.get()), "Premature end") != nullptr) return cv::Mat();
    return std::nullopt;
}

cv::Mat decodeOther(Bytes bytes, PictureKind kind) {
    static const auto decode = reinterpret_cast<decltype(&revisitDecodePicture)>(
        functionOfLibrary("librevisit_pictures.so", "revisitDecodePicture"));
    cv::Mat picture;
    if (bytes.size() <= kMostBytes) decode(bytes.data(), bytes.size(), kind, &picture);
    return picture;
}

bool startsWith(Bytes bytes, std::initializer_list<int> magic) {
    return bytes.size() >= magic.size() && std::equal(magic.begin(), magic.end(), bytes.begin());
}

bool isPng(Bytes bytes) {
    return startsWith(bytes, {0x89, 'P', 'N', 'G'});
}
bool isJpeg(Bytes bytes) {
    return startsWith(bytes, {0xff, 0xd8, 0xff});
}

/// The first page's, by TIFF 6.0, section 2; of what is larger than 4 GiB (BigTIFF), nothing.
std::optional<PictureSize> sizeInTiff(Bytes bytes) {
    const bool isLittleEndian = bytes[0] == 'I';
    /// bytes[at], ... as a number of so many bytes; 0 outside.
    const auto number = [&](std::uint64_t at, int count) {
        std::uint32_t value = 0;
        for (int i = 0; i < count && at + static_cast<std::uint64_t>(count) <= bytes.size(); ++i)
            value = value << 8 | bytes[at + static_cast<std::uint64_t>(isLittleEndian ? count - 1 - i : i)];
        return value;
    };
    constexpr std::uint32_t kShort = 3, kLong = 4, kWidth = 256, kLength = 257;
    const std::uint64_t directory = number(4, 4);
    PictureSize size;
    for (std::uint32_t i = 0; i < number(directory, 2); ++i) {
        const std::uint64_t entry = directory + 2 + 12 * std::uint64_t{i};
        const std::uint32_t tag = number(entry, 2), type = number(entry + 2, 2);
        if ((tag != kWidth && tag != kLength) || (type != kShort && type != kLong)) continue;
        const std::uint32_t value = number(entry + 8, type == kShort ? 2 : 4);
        int& side = tag == kWidth ? size.width : size.height;
        if (side == 0) side = static_cast<int>(std::min<std::uint32_t>(value, INT32_MAX)); // of two the first counts
    }
    if (size.width == 0 || size.height == 0) return std::nullopt;
    return size;
}

/// Rows of 8 bits a channel, red first.
std::vector<std::uint8_t> encodeRows(const std::uint8_t* rows, int width, int height, int channels) {
    const Spng png(spng_ctx_new(SPNG_CTX_ENCODER));
    if (!png) return {};
    spng_ihdr header{};
    header.width = static_cast<std::uint32_t>(width), header.height = static_cast<std::uint32_t>(height);
    header.bit_depth = 8;
    header.color_type = channels == 3 ? SPNG_COLOR_TYPE_TRUECOLOR : SPNG_COLOR_TYPE_GRAYSCALE;
    constexpr int kFastDeflate = 1;
    spng_set_option(png.get(), SPNG_ENCODE_TO_BUFFER, 1);
    spng_set_option(png.get(), SPNG_IMG_COMPRESSION_LEVEL, kFastDeflate);
    spng_set_option(png.get(), SPNG_FILTER_CHOICE, SPNG_FILTER_CHOICE_SUB);
    const std::size_t size =
        static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * static_cast<std::size_t>(channels);
    if (spng_set_ihdr(png.get(), &header) != 0 ||
        spng_encode_image(png.get(), rows, size, SPNG_FMT_PNG, SPNG_ENCODE_FINALIZE) != 0)
        return {};
    std::size_t count = 0;
    int error = 0;
    const std::unique_ptr<void, decltype(&std::free)> encoded(spng_get_png_buffer(png.get(), &count, &error),
                                                              &std::free);
    if (!encoded) return {};
    const auto* const first = static_cast<const std::uint8_t*>(encoded.get());
    return {first, first + count};
}

} // namespace

std::optional<PictureSize> sizeInHeader(std::span<const std::uint8_t> bytes) {
    if (isPng(bytes)) {
        const Spng png(spng_ctx_new(0));
        spng_ihdr header;
        if (!png || spng_set_png_buffer(png.get(), bytes.data(), bytes.size()) != 0 ||
            spng_get_ihdr(png.get(), &header) != 0)
            return std::nullopt;
        return PictureSize{static_cast<int>(header.width), static_cast<int>(header.height)}; // at most 2^31 - 1
    }
    if (isJpeg(bytes)) {
        const std::unique_ptr<void, FreeJpeg> jpeg(tjInitDecompress());
        PictureSize size;
        int sampling = 0, space = 0;
        if (!jpeg ||
            tjDecompressHeader3(jpeg.get(), bytes.data(), bytes.size(), &size.width, &size.height, &sampling,
                                &space) != 0 ||
            size.width <= 0 || size.height <= 0) // cut off: libjpeg-turbo warns, and knows no size
            return std::nullopt;
        return size;
    }
    if (startsWith(bytes, {'I', 'I', 42, 0}) || startsWith(bytes, {'M', 'M', 0, 42})) return sizeInTiff(bytes);
    return std::nullopt;
}

cv::Mat decodePicture(std::span<const std::uint8_t> bytes, PictureKind kind) try {
    Decoded decoded;
    if (isPng(bytes))
        decoded = decodePng(bytes, kind);
    else if (isJpeg(bytes))
        decoded = decodeJpeg(bytes, kind);
    else if (bytes.empty())
        return {};
    return decoded ? *decoded : decodeOther(bytes, kind);
} catch (const cv::Exception& e) {
    if (e.code == cv::Error::StsNoMem) throw std::bad_alloc();
    return {};
}

std::vector<std::uint8_t> readPictureBytes(const std::filesystem::path& path) {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(path, ignored)) return {};
    std::ifstream file(path, std::ios::binary | std::ios::ate);
    const auto size = static_cast<std::streamoff>(file.tellg());
    if (!file || size <= 0 || static_cast<std::uintmax_t>(size) > kMostBytes) return {};
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(size));
    file.seekg(0);
    if (!file.read(reinterpret_cast<char*>(bytes.data()), size)) return {};
    return bytes;
}

cv::Mat readPicture(const std::filesystem::path& path, PictureKind kind) {
    return decodePicture(readPictureBytes(path), kind);
}

std::vector<std::uint8_t> encodePng(const Image<Rgb8>& picture) {
    static_assert(sizeof(Rgb8) == 3);
    return encodeRows(reinterpret_cast<const std::uint8_t*>(picture.pixels().data()), picture.width(), picture.height(),
                      3);
}

std::vector<std::uint8_t> encodePng(const Image<std::uint8_t>& picture) {
    return encodeRows(picture.pixels().data(), picture.width(), picture.height(), 1);
}

std::vector<std::uint8_t> encodePng(const cv::Mat& picture) {
    cv::Mat rows = picture.clone(); // without gaps between its rows
    swapRedAndBlue(rows);
    return encodeRows(rows.data, rows.cols, rows.rows, 3);
}

} // namespace scene
