// Pictures by the libraries that are made for them are, value by value, what OpenCV makes of the same bytes.

#include "scene/picture_codec.h"

#include "tests/scene/scratch_folder.h"

#include <cstdlib>
#include <fstream>
#include <random>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <spng.h>

namespace scene {
namespace {

using Bytes = std::vector<std::uint8_t>;

cv::Mat noise(int width, int height, int type, unsigned seed = 1) {
    cv::Mat picture(height, width, type);
    std::mt19937 random(seed);
    for (int y = 0; y < height; ++y)
        for (std::size_t i = 0; i < static_cast<std::size_t>(width) * picture.elemSize(); ++i)
            picture.ptr(y)[i] = static_cast<std::uint8_t>(random() % 256);
    return picture;
}

Bytes encoded(const std::string& ending, const cv::Mat& picture, const std::vector<int>& parameters = {}) {
    Bytes bytes;
    EXPECT_TRUE(cv::imencode(ending, picture, bytes, parameters));
    return bytes;
}

/// Four colours, one of them half transparent if that is wished.
Bytes indexedPng(bool isTransparent) {
    spng_ctx* const png = spng_ctx_new(SPNG_CTX_ENCODER);
    spng_set_option(png, SPNG_ENCODE_TO_BUFFER, 1);
    spng_ihdr header{};
    header.width = 5, header.height = 3, header.bit_depth = 8, header.color_type = SPNG_COLOR_TYPE_INDEXED;
    spng_plte palette{};
    palette.n_entries = 4;
    for (std::uint8_t i = 0; i < 4; ++i)
        palette.entries[i].red = static_cast<std::uint8_t>(60 * i), palette.entries[i].blue = 9;
    spng_trns transparency{};
    transparency.n_type3_entries = 4;
    for (std::uint8_t& alpha : transparency.type3_alpha)
        alpha = 128;
    const std::uint8_t indices[15] = {0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2};
    EXPECT_EQ(spng_set_ihdr(png, &header), 0);
    EXPECT_EQ(spng_set_plte(png, &palette), 0);
    if (isTransparent) {
        EXPECT_EQ(spng_set_trns(png, &transparency), 0);
    }
    EXPECT_EQ(spng_encode_image(png, indices, sizeof indices, SPNG_FMT_PNG, SPNG_ENCODE_FINALIZE), 0);
    std::size_t count = 0;
    int error = 0;
    auto* const first = static_cast<std::uint8_t*>(spng_get_png_buffer(png, &count, &error));
    const Bytes bytes(first, first + count);
    std::free(first);
    spng_ctx_free(png);
    return bytes;
}

void expectAsOpenCv(const Bytes& bytes) {
    struct Mode {
        PictureKind kind;
        int openCv;
    };
    for (const Mode mode : {Mode{PictureKind::colour, cv::IMREAD_COLOR}, Mode{PictureKind::grey, cv::IMREAD_GRAYSCALE},
                            Mode{PictureKind::asStored, cv::IMREAD_UNCHANGED}}) {
        const cv::Mat expected = cv::imdecode(bytes, mode.openCv | cv::IMREAD_IGNORE_ORIENTATION);
        const cv::Mat found = decodePicture(bytes, mode.kind);
        ASSERT_FALSE(expected.empty());
        ASSERT_EQ(found.size(), expected.size()) << "mode " << mode.openCv;
        ASSERT_EQ(found.type(), expected.type()) << "mode " << mode.openCv;
        EXPECT_EQ(cv::norm(found, expected, cv::NORM_INF), 0) << "mode " << mode.openCv;
    }
}

TEST(PictureCodec, ReadsWhatOpenCvReads) {
    for (const int type : {CV_8UC1, CV_8UC3, CV_8UC4, CV_16UC1, CV_16UC3, CV_16UC4}) {
        SCOPED_TRACE(testing::Message() << "PNG of type " << type);
        expectAsOpenCv(encoded(".png", noise(33, 21, type)));
    }
    {
        SCOPED_TRACE("of one bit");
        expectAsOpenCv(encoded(".png", noise(33, 21, CV_8UC1) & 128, {cv::IMWRITE_PNG_BILEVEL, 1}));
    }
    for (const bool isTransparent : {false, true}) {
        SCOPED_TRACE(testing::Message() << "indexed, transparent: " << isTransparent);
        expectAsOpenCv(indexedPng(isTransparent));
    }
    for (const int type : {CV_8UC1, CV_8UC3})
        for (const int progressive : {0, 1}) {
            SCOPED_TRACE(testing::Message() << "JPEG of type " << type << ", progressive " << progressive);
            expectAsOpenCv(encoded(".jpg", noise(35, 19, type), {cv::IMWRITE_JPEG_PROGRESSIVE, progressive}));
        }
    expectAsOpenCv(encoded(".bmp", noise(33, 21, CV_8UC3)));
    expectAsOpenCv(encoded(".tiff", noise(33, 21, CV_16UC1)));
}

TEST(PictureCodec, WhatIsCutOffOrDamagedIsNoPicture) {
    const Bytes png = encoded(".png", noise(40, 30, CV_8UC3)), jpeg = encoded(".jpg", noise(40, 30, CV_8UC3));
    const Bytes greyPng = encoded(".png", noise(40, 30, CV_8UC1)), greyJpeg = encoded(".jpg", noise(40, 30, CV_8UC1));
    for (const Bytes& whole : {png, jpeg, greyPng, greyJpeg})
        for (const PictureKind kind : {PictureKind::colour, PictureKind::grey, PictureKind::asStored})
            for (const std::size_t share : {0, 1, 5, 9}) {
                const Bytes part(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(whole.size() * share / 10));
                EXPECT_TRUE(decodePicture(part, kind).empty()) << share << " tenths, " << static_cast<int>(kind);
            }
    Bytes flipped = png;
    flipped[flipped.size() / 2] ^= 1;
    EXPECT_TRUE(decodePicture(flipped, PictureKind::colour).empty());
    EXPECT_TRUE(decodePicture(Bytes{'n', 'o'}, PictureKind::asStored).empty());
    // Bits of JPEG have no checksum: whatever they make, nothing falls over.
    for (std::size_t bit = 0; bit < 8 * jpeg.size(); bit += 37) {
        Bytes other = jpeg;
        other[bit / 8] = static_cast<std::uint8_t>(other[bit / 8] ^ (1 << bit % 8));
        const cv::Mat picture = decodePicture(other, PictureKind::colour);
        EXPECT_TRUE(picture.empty() || picture.type() == CV_8UC3) << "bit " << bit;
    }
}

/// A checksum as PNG has it.
std::uint32_t crcOf(const std::uint8_t* bytes, std::size_t count) {
    std::uint32_t crc = ~0u;
    for (std::size_t i = 0; i < count; ++i) {
        crc ^= bytes[i];
        for (int bit = 0; bit < 8; ++bit)
            crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
    }
    return ~crc;
}

TEST(PictureCodec, AFileThatClaimsMoreThanItHoldsTakesNoMemory) {
    Bytes png = encoded(".png", noise(40, 30, CV_8UC3));
    png[16] = 0, png[17] = 0, png[18] = 0x7f, png[19] = 0xff; // 32767 pixels wide and high: a gigapixel
    png[20] = 0, png[21] = 0, png[22] = 0x7f, png[23] = 0xff;
    const std::uint32_t crc = crcOf(&png[12], 17);
    for (std::size_t i = 0; i < 4; ++i)
        png[29 + i] = static_cast<std::uint8_t>(crc >> (24 - 8 * i));
    EXPECT_TRUE(decodePicture(png, PictureKind::colour).empty());
}

TEST(PictureCodec, HeadersTellTheSizeBeforeAnythingIsDecoded) {
    for (const char* const kind : {".png", ".jpg", ".tiff"}) {
        const Bytes whole = encoded(kind, noise(43, 29, kind == std::string(".tiff") ? CV_16UC1 : CV_8UC3));
        const std::optional<PictureSize> size = sizeInHeader(whole);
        ASSERT_TRUE(size) << kind;
        EXPECT_EQ(size->width, 43) << kind;
        EXPECT_EQ(size->height, 29) << kind;
        for (std::size_t count = 0; count < whole.size(); ++count) // wherever it is cut off: this size, or none
            if (const auto part = sizeInHeader(std::span(whole).first(count))) {
                EXPECT_EQ(part->width, 43) << kind << " " << count;
                EXPECT_EQ(part->height, 29) << kind << " " << count;
            }
    }
    const Bytes bigEndian{'M', 'M', 0, 42, 0, 0, 0, 8, 0, 2, 1, 0, 0, 3, 0, 0, 0, 1, 2, 1, 0, 0, //
                          1,   1,   0, 4,  0, 0, 0, 1, 0, 1, 0, 2};
    ASSERT_TRUE(sizeInHeader(bigEndian));
    EXPECT_EQ(sizeInHeader(bigEndian)->width, 0x201);
    EXPECT_EQ(sizeInHeader(bigEndian)->height, 0x10002);
    EXPECT_FALSE(sizeInHeader(encoded(".bmp", noise(33, 21, CV_8UC3))));
}

TEST(PictureCodec, WritesWhatItReads) {
    Image<Rgb8> colour(31, 17);
    Image<std::uint8_t> grey(31, 17);
    std::mt19937 random(3);
    for (std::size_t i = 0; i < colour.size(); ++i) {
        const auto byte = [&] { return static_cast<std::uint8_t>(random() % 256); };
        colour.pixels()[i].r = byte(), colour.pixels()[i].g = byte(), colour.pixels()[i].b = byte();
        grey.pixels()[i] = byte();
    }
    const cv::Mat3b colourBack = cv::imdecode(encodePng(colour), cv::IMREAD_UNCHANGED);
    const cv::Mat1b greyBack = cv::imdecode(encodePng(grey), cv::IMREAD_UNCHANGED);
    ASSERT_EQ(colourBack.size(), cv::Size(31, 17));
    ASSERT_EQ(greyBack.size(), cv::Size(31, 17));
    for (int y = 0; y < 17; ++y)
        for (int x = 0; x < 31; ++x) {
            const Rgb8 c = colour(x, y);
            ASSERT_EQ(colourBack(y, x), cv::Vec3b(c.b, c.g, c.r));
            ASSERT_EQ(greyBack(y, x), grey(x, y));
        }
    const cv::Mat wide = noise(40, 30, CV_8UC3);
    const cv::Mat part = wide(cv::Rect(3, 4, 20, 11)); // with gaps between its rows
    EXPECT_EQ(cv::norm(decodePicture(encodePng(part), PictureKind::colour), part, cv::NORM_INF), 0);
}

TEST(PictureCodec, AFolderAndWhatIsNotThereAreNoPictures) {
    const ScratchFolder folder;
    EXPECT_TRUE(readPicture(folder.path(), PictureKind::colour).empty());
    EXPECT_TRUE(readPicture(folder.path() / "none.png", PictureKind::colour).empty());
    std::ofstream(folder.path() / "empty.png").close();
    EXPECT_TRUE(readPicture(folder.path() / "empty.png", PictureKind::colour).empty());
}

} // namespace
} // namespace scene
