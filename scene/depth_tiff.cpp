#include "scene/depth_tiff.h"

#include "scene/camera_json.h"
#include "scene/checksum.h"
#include "scene/errors.h"
#include "scene/unfinished_file.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>

#include <nlohmann/json.hpp>

#include <tiffio.h>

namespace scene {

namespace {

using nlohmann::json;

constexpr const char* kReadRemedy = "the file is damaged or not Revisit's: remove it and build the scene again";
constexpr int kMaxSide = 65536;
constexpr int kRowsPerStrip = 64;
constexpr int kDeflateLevel = 1; ///< the next levels take several times as long for a few percent

struct CloseTiff {
    void operator()(TIFF* tiff) const { TIFFClose(tiff); }
};
using Tiff = std::unique_ptr<TIFF, CloseTiff>;

/// libtiff speaks to stderr unless told otherwise; what fails here is said once, by Failure.
Tiff openTiff(const std::filesystem::path& path, const char* mode) {
    TIFFSetErrorHandler(nullptr);
    TIFFSetWarningHandler(nullptr);
    return Tiff(TIFFOpen(path.c_str(), mode));
}

/// Calls visit(strip, first row, rows).
template <class Visit>
void forStrips(int height, Visit visit) {
    for (int first = 0; first < height; first += kRowsPerStrip)
        visit(static_cast<std::uint32_t>(first / kRowsPerStrip), first, std::min(kRowsPerStrip, height - first));
}

/// Index of a row's first pixel.
template <class T>
std::size_t placeOf(const Image<T>& image, int row) {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(image.width());
}

/// Neighbours' differences are what compresses well in colours and in noisy ranges. Ranges that are stored in steps
/// hold few numbers, often the same ones: as they are they take two thirds of the room (a capture in millimetres,
/// 640x480: 145 kB instead of 230), less than half of the time to write and a fifth of that to read.
int predictorFor(const Image<float>& disparity) {
    constexpr std::size_t kAsked = 4096;
    const auto pixels = disparity.pixels();
    std::vector<float> some;
    // An odd step, or of a picture as wide as the step only one column would be asked.
    for (std::size_t i = 0; i < pixels.size(); i += pixels.size() / kAsked | 1)
        if (pixels[i] > 0) some.push_back(pixels[i]);
    const std::size_t asked = some.size();
    std::sort(some.begin(), some.end());
    some.erase(std::unique(some.begin(), some.end()), some.end());
    return some.size() > asked / 2 ? PREDICTOR_FLOATINGPOINT : PREDICTOR_NONE;
}
int predictorFor(const Image<Rgb8>&) {
    return PREDICTOR_HORIZONTAL;
}
int predictorFor(const Image<std::uint8_t>&) { // flags are no measures
    return PREDICTOR_NONE;
}

template <class T>
void writePage(TIFF* tiff, const Image<T>& image, int bits, int channels, int format, const std::string* description,
               const std::filesystem::path& path) {
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, static_cast<std::uint32_t>(image.width()));
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, static_cast<std::uint32_t>(image.height()));
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, bits);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, channels);
    TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, format);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, channels == 3 ? PHOTOMETRIC_RGB : PHOTOMETRIC_MINISBLACK);
    TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
    TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_ADOBE_DEFLATE);
    TIFFSetField(tiff, TIFFTAG_ZIPQUALITY, kDeflateLevel);
    TIFFSetField(tiff, TIFFTAG_PREDICTOR, predictorFor(image));
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, kRowsPerStrip);
    if (description) TIFFSetField(tiff, TIFFTAG_IMAGEDESCRIPTION, description->c_str());
    // Whole strips, which libtiff hands to libdeflate; single rows would go through zlib, in twice the time.
    forStrips(image.height(), [&](std::uint32_t strip, int first, int rows) {
        const auto pixels = image.pixels().subspan(placeOf(image, first), placeOf(image, rows));
        std::vector<T> samples(pixels.begin(), pixels.end()); // libtiff's predictors work in the caller's memory
        const auto bytes = static_cast<tmsize_t>(samples.size() * sizeof(T));
        if (TIFFWriteEncodedStrip(tiff, strip, samples.data(), bytes) != bytes)
            throw Failure("cannot be written", path, kWriteRemedy);
    });
    if (TIFFWriteDirectory(tiff) != 1) throw Failure("cannot be written", path, kWriteRemedy);
}

/// Checks that the page is what writePage wrote for such an image before any memory is taken.
void checkPage(TIFF* tiff, int width, int height, int bits, int channels, const std::filesystem::path& path) {
    std::uint32_t w = 0, h = 0, rowsPerStrip = 0;
    std::uint16_t b = 0, c = 0, planar = 0, compression = 0;
    TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &w);
    TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &h);
    TIFFGetField(tiff, TIFFTAG_BITSPERSAMPLE, &b);
    TIFFGetField(tiff, TIFFTAG_SAMPLESPERPIXEL, &c);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_PLANARCONFIG, &planar);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_COMPRESSION, &compression);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_ROWSPERSTRIP, &rowsPerStrip);
    const bool fits = w == static_cast<std::uint32_t>(width) && h == static_cast<std::uint32_t>(height) && b == bits &&
                      c == channels && planar == PLANARCONFIG_CONTIG && compression == COMPRESSION_ADOBE_DEFLATE &&
                      rowsPerStrip == static_cast<std::uint32_t>(kRowsPerStrip) && !TIFFIsTiled(tiff) &&
                      TIFFScanlineSize(tiff) == static_cast<tmsize_t>(width) * channels * bits / 8;
    if (!fits) throw Failure("has a page that is not as its description says", path, kReadRemedy);
}

template <class T>
Image<T> readPage(TIFF* tiff, int width, int height, int bits, int channels, const std::filesystem::path& path,
                  Image<T> spare = {}) {
    checkPage(tiff, width, height, bits, channels, path);
    const bool isOfUse = spare.width() == width && spare.height() == height && !spare.empty();
    Image<T> image = isOfUse ? std::move(spare) : Image<T>(width, height);
    forStrips(height, [&](std::uint32_t strip, int first, int rows) {
        const auto pixels = image.pixels().subspan(placeOf(image, first), placeOf(image, rows));
        const auto bytes = static_cast<tmsize_t>(pixels.size_bytes());
        if (TIFFReadEncodedStrip(tiff, strip, pixels.data(), bytes) != bytes)
            throw Failure("is cut off or damaged in or after row " + std::to_string(first), path, kReadRemedy);
    });
    return image;
}

std::string checksumOf(const DepthImage& image) {
    Checksum sum;
    sum.add(std::as_bytes(image.colour.pixels()));
    sum.add(std::as_bytes(image.disparity.pixels()));
    sum.add(std::as_bytes(image.flags.pixels()));
    return sum.text();
}

std::string checksumOf(const json& description) {
    Checksum sum;
    const std::string text = description.dump();
    sum.add(std::as_bytes(std::span(text)));
    return sum.text();
}

std::filesystem::path temporaryNameOf(const std::filesystem::path& path) {
    std::filesystem::path part = path;
    part += ".part";
    return part;
}

/// Writes pages under a temporary name, then renames.
template <class WritePages>
void writeWhole(const std::filesystem::path& path, WritePages writePages) {
    const std::filesystem::path part = temporaryNameOf(path);
    try {
        Tiff tiff = openTiff(part, "w");
        if (!tiff) throw Failure("cannot be created", part, kWriteRemedy);
        writePages(tiff.get());
        if (TIFFFlush(tiff.get()) != 1) throw Failure("cannot be written", part, kWriteRemedy);
        tiff.reset();
        std::error_code error;
        std::filesystem::rename(part, path, error);
        if (error) throw Failure("cannot be renamed into place (" + error.message() + ")", path, kWriteRemedy);
    } catch (...) {
        std::error_code ignored;
        std::filesystem::remove(part, ignored);
        throw;
    }
}

/// As text. A name that is not UTF-8 is none that JSON can hold.
std::string describe(const DepthImage& image, const std::filesystem::path& path) {
    json root = describeCamera(image.name, image.camera, image.worldFromCamera);
    root["revisit"] = "depth image", root["version"] = 1;
    root["checksum"] = checksumOf(image);
    try {
        root["description_checksum"] = checksumOf(root);
        return root.dump();
    } catch (const json::type_error&) {
        throw Failure("is to hold an image whose name is not UTF-8", path, "rename the picture it comes from");
    }
}

/// Camera, pose, name and checksum from the first page's description.
std::string readDescription(TIFF* tiff, DepthImage& image, const std::filesystem::path& path) {
    const char* text = nullptr;
    if (TIFFGetField(tiff, TIFFTAG_IMAGEDESCRIPTION, &text) != 1 || !text)
        throw Failure("is no depth image: it has no description", path, kReadRemedy);
    try {
        json root = json::parse(text);
        if (root.at("revisit") != "depth image") throw Failure("is no depth image", path, kReadRemedy);
        if (root.at("version") != 1)
            throw Failure("is of another version", path, "build the scene again with this Revisit");
        const auto written = root.at("description_checksum").get<std::string>();
        root.erase("description_checksum");
        if (checksumOf(root) != written)
            throw Failure("has a description that has changed since it was written", path, kReadRemedy);
        image.name = root.at("name").get<std::string>();
        image.camera = {root.at("width").get<int>(), root.at("height").get<int>(), root.at("fx").get<double>(),
                        root.at("fy").get<double>(), root.at("cx").get<double>(),  root.at("cy").get<double>()};
        const auto values = root.at("world_from_camera").get<std::vector<double>>();
        glm::dmat4 m(0.0);
        for (std::size_t i = 0; i < 16; ++i)
            m[static_cast<int>(i % 4)][static_cast<int>(i / 4)] = values.at(i);
        constexpr double kTolerance = 1e-6;
        const bool usable = isUsable(image.camera) && image.camera.width <= kMaxSide &&
                            image.camera.height <= kMaxSide && values.size() == 16 &&
                            poseFromMatrix(m, kTolerance, image.worldFromCamera);
        if (!usable) throw Failure("has a camera that is not usable", path, kReadRemedy);
        return root.at("checksum").get<std::string>();
    } catch (const json::exception&) {
        throw Failure("has a description that is damaged", path, kReadRemedy);
    } catch (const std::out_of_range&) {
        throw Failure("has a description that is damaged", path, kReadRemedy);
    }
}

void nextPage(TIFF* tiff, const std::filesystem::path& path) {
    if (TIFFReadDirectory(tiff) != 1) throw Failure("lacks a page", path, kReadRemedy);
}

/// A file that claims more pixels than its bytes can hold even at deflate's best is damaged; found out before memory is
/// taken.
void checkSize(const Camera& camera, const std::filesystem::path& path) {
    constexpr std::uintmax_t kBestRatio = 1100;
    std::error_code error;
    const std::uintmax_t bytes = std::filesystem::file_size(path, error);
    if (error || bytesOf(camera) > bytes * kBestRatio)
        throw Failure("is too short for its size in pixels", path, kReadRemedy);
}

} // namespace

void writeDepthTiff(const DepthImage& image, const std::filesystem::path& path) {
    const std::string description = describe(image, path);
    writeWhole(path, [&](TIFF* tiff) {
        writePage(tiff, image.colour, 8, 3, SAMPLEFORMAT_UINT, &description, path);
        writePage(tiff, image.disparity, 32, 1, SAMPLEFORMAT_IEEEFP, nullptr, path);
        writePage(tiff, image.flags, 8, 1, SAMPLEFORMAT_UINT, nullptr, path);
    });
}

DepthImage readDepthTiff(const std::filesystem::path& path, DepthImage spare) {
    const Tiff tiff = openTiff(path, "rm");
    if (!tiff) throw Failure("cannot be opened as TIFF", path, kReadRemedy);
    DepthImage image;
    const std::string checksum = readDescription(tiff.get(), image, path);
    checkSize(image.camera, path);
    const int width = image.camera.width, height = image.camera.height;
    image.colour = readPage<Rgb8>(tiff.get(), width, height, 8, 3, path, std::move(spare.colour));
    nextPage(tiff.get(), path);
    image.disparity = readPage<float>(tiff.get(), width, height, 32, 1, path, std::move(spare.disparity));
    nextPage(tiff.get(), path);
    image.flags = readPage<std::uint8_t>(tiff.get(), width, height, 8, 1, path, std::move(spare.flags));
    if (checksumOf(image) != checksum)
        throw Failure("has changed since it was written: its checksum differs", path, kReadRemedy);
    for (const float disparity : image.disparity.pixels())
        if (!std::isfinite(disparity) || disparity < 0)
            throw Failure("holds a disparity that is no number", path, kReadRemedy);
    return image;
}

DepthImage readDepthTiffHeader(const std::filesystem::path& path) {
    const Tiff tiff = openTiff(path, "rm");
    if (!tiff) throw Failure("cannot be opened as TIFF", path, kReadRemedy);
    DepthImage image;
    readDescription(tiff.get(), image, path);
    return image;
}

void writeFlagsTiff(const Image<std::uint8_t>& flags, const std::filesystem::path& path) {
    Checksum sum;
    sum.add(std::as_bytes(flags.pixels()));
    const std::string description = sum.text();
    writeWhole(path, [&](TIFF* tiff) { writePage(tiff, flags, 8, 1, SAMPLEFORMAT_UINT, &description, path); });
}

Image<std::uint8_t> readFlagsTiff(const std::filesystem::path& path, const Camera& camera) {
    const Tiff tiff = openTiff(path, "rm");
    if (!tiff) throw Failure("cannot be opened as TIFF", path, kReadRemedy);
    const char* text = nullptr;
    if (TIFFGetField(tiff.get(), TIFFTAG_IMAGEDESCRIPTION, &text) != 1 || !text)
        throw Failure("holds no flags: it has no description", path, kReadRemedy);
    const std::string checksum = text;
    Image<std::uint8_t> flags = readPage<std::uint8_t>(tiff.get(), camera.width, camera.height, 8, 1, path);
    Checksum sum;
    sum.add(std::as_bytes(flags.pixels()));
    if (sum.text() != checksum)
        throw Failure("has changed since it was written: its checksum differs", path, kReadRemedy);
    return flags;
}

void writeNumbersTiff(const Image<float>& numbers, const std::filesystem::path& path) {
    writeWhole(path, [&](TIFF* tiff) { writePage(tiff, numbers, 32, 1, SAMPLEFORMAT_IEEEFP, nullptr, path); });
}

} // namespace scene
