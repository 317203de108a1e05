#include "scene/depth_tiff.h"

#include "scene/errors.h"
#include "tests/scene/file_size_limit.h"
#include "tests/scene/random_poses.h"
#include "tests/scene/scratch_folder.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <set>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <tiffio.h>
#include <xxhash.h>

namespace scene {
namespace {

/// Some order, so that it deflates; more rows than a strip has.
DepthImage drawImage(int width, int height, unsigned seed) {
    RandomPlaces random(seed);
    DepthImage image;
    image.name = "Bild 1 \xc3\xa4\xe6\x97\xa5 \"quoted\"\\";
    image.camera = {width, height, 0.1 + width, 1.0 / 3 + height, width / 2.0, height / 7.0};
    image.worldFromCamera = random.pose(1, kFarFromOrigin);
    image.colour = Image<Rgb8>(width, height);
    image.disparity = Image<float>(width, height);
    image.flags = Image<std::uint8_t>(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            image.colour(x, y) = {static_cast<std::uint8_t>(x), static_cast<std::uint8_t>(y),
                                  static_cast<std::uint8_t>(random.integerBetween(0, 3))};
            image.disparity(x, y) = static_cast<float>((x % 5 == 0) ? 0.0 : 0.3 + 0.01 * x + random.between(0, 0.001));
            image.flags(x, y) =
                static_cast<std::uint8_t>(random.integerBetween(0, 9) ? 0 : random.integerBetween(0, 255));
        }
    return image;
}

bool isIdentical(const DepthImage& a, const DepthImage& b) {
    return a.name == b.name && a.camera == b.camera && a.worldFromCamera.rotation == b.worldFromCamera.rotation &&
           a.worldFromCamera.translation == b.worldFromCamera.translation && a.colour == b.colour &&
           a.flags == b.flags && a.disparity.size() == b.disparity.size() &&
           std::memcmp(a.disparity.pixels().data(), b.disparity.pixels().data(), a.disparity.pixels().size_bytes()) ==
               0;
}

long peakKilobytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss;
}

class DepthTiff : public testing::Test {
  protected:
    /// Reads bytes as a file: identical to the truth, or a Failure that names the file. Returns whether it was read.
    bool readsOrFails(const std::string& bytes, const DepthImage& truth, const std::string& what) {
        const auto path = folder_ / "damaged.tiff";
        writeFile(path, bytes);
        try {
            const DepthImage image = readDepthTiff(path);
            EXPECT_TRUE(isIdentical(image, truth)) << what << " was not noticed";
            return true;
        } catch (const Failure& failure) {
            EXPECT_NE(std::string(failure.what()).find(path.string()), std::string::npos)
                << what << ": " << failure.what();
            return false;
        }
    }

    ScratchFolder folder_;
};

TEST_F(DepthTiff, ComesBackBitByBit) {
    for (const auto& [width, height] : {std::pair{1, 1}, {1, 200}, {300, 1}, {64, 64}, {65, 129}}) {
        DepthImage image = drawImage(width, height, 1);
        image.disparity(0, 0) = std::numeric_limits<float>::denorm_min();
        image.disparity(width - 1, height - 1) = std::numeric_limits<float>::max();
        const auto path = folder_ / "image.tiff";
        writeDepthTiff(image, path);
        DepthImage read = readDepthTiff(path);
        // The rotation is made exactly orthonormal on the way in: a last digit may move.
        for (int column = 0; column < 3; ++column)
            for (int row = 0; row < 3; ++row)
                ASSERT_NEAR(read.worldFromCamera.rotation[column][row], image.worldFromCamera.rotation[column][row],
                            1e-15);
        EXPECT_EQ(read.worldFromCamera.translation, image.worldFromCamera.translation);
        read.worldFromCamera = image.worldFromCamera;
        EXPECT_TRUE(isIdentical(read, image)) << width << "x" << height;
        EXPECT_EQ(folder_.fileCount(), 1u) << "something is left beside the file";
        const DepthImage header = readDepthTiffHeader(path);
        EXPECT_EQ(header.camera, image.camera);
        EXPECT_EQ(header.name, image.name);
    }
}

TEST_F(DepthTiff, CutAnywhereIsAFailure) {
    const auto path = folder_ / "image.tiff";
    writeDepthTiff(drawImage(40, 130, 2), path);
    const DepthImage truth = readDepthTiff(path);
    const std::string whole = bytesOfFile(path);
    std::set<std::size_t> lengths{0, 1, 7, 8, 9, whole.size() - 1, whole.size() - 2};
    for (std::size_t i = 0; i < 150; ++i)
        lengths.insert(i * whole.size() / 150);
    for (const std::size_t length : lengths)
        EXPECT_FALSE(readsOrFails(whole.substr(0, length), truth, "cut at " + std::to_string(length)))
            << "cut at " << length;
    EXPECT_TRUE(readsOrFails(whole, truth, "nothing"));
}

TEST_F(DepthTiff, WithABitFlippedIsAFailureOrIdentical) {
    const auto path = folder_ / "image.tiff";
    writeDepthTiff(drawImage(40, 70, 3), path);
    const DepthImage truth = readDepthTiff(path);
    const std::string whole = bytesOfFile(path);
    RandomPlaces random(3);
    // The head, the directories with their descriptions (libtiff writes each after its page), and anywhere else.
    std::set<std::size_t> places;
    for (std::size_t i = 0; i < 400; ++i)
        places.insert(i);
    for (const char* what : {"II*", "revisit"})
        for (std::size_t at = whole.find(what), i = 0; at != std::string::npos && i < 700; ++i)
            places.insert(std::min(at + i, whole.size() - 1));
    for (int i = 0; i < 500; ++i)
        places.insert(static_cast<std::size_t>(random.integerBetween(0, static_cast<int>(whole.size()) - 1)));
    const long before = peakKilobytes();
    int noticed = 0;
    for (const std::size_t place : places) {
        std::string damaged = whole;
        const int bit = random.integerBetween(0, 7);
        damaged[place] = static_cast<char>(damaged[place] ^ (1 << bit));
        noticed += !readsOrFails(damaged, truth, "bit " + std::to_string(bit) + " of byte " + std::to_string(place));
    }
    EXPECT_GT(noticed, static_cast<int>(places.size()) * 9 / 10);
    // The address sanitizer holds on to a quarter of a gigabyte that was freed; a flipped size claims far more.
    EXPECT_LT(peakKilobytes() - before, 400 * 1024) << "memory was taken for what a damaged file claims";
}

TEST_F(DepthTiff, WithAByteChangedIsAFailureOrIdentical) {
    const auto path = folder_ / "image.tiff";
    writeDepthTiff(drawImage(20, 10, 4), path);
    const DepthImage truth = readDepthTiff(path);
    const std::string whole = bytesOfFile(path);
    RandomPlaces random(4);
    for (std::size_t place = 0; place < whole.size(); ++place) {
        std::string damaged = whole;
        damaged[place] = static_cast<char>(random.integerBetween(0, 3) ? random.integerBetween(0, 255) : 0xff);
        readsOrFails(damaged, truth, "byte " + std::to_string(place) + " as " + std::to_string(damaged[place] & 255));
    }
}

/// A file whose description is right and whose pages claim its size, but hold a strip of nothing.
void writeClaim(const std::filesystem::path& path, std::uint32_t width, std::uint32_t height) {
    nlohmann::json root = {{"revisit", "depth image"},
                           {"version", 1},
                           {"name", "claim"},
                           {"width", width},
                           {"height", height},
                           {"fx", 1.0},
                           {"fy", 1.0},
                           {"cx", 0.0},
                           {"cy", 0.0},
                           {"checksum", "0"},
                           {"world_from_camera", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}};
    const std::string bare = root.dump();
    char hex[17];
    std::snprintf(hex, sizeof hex, "%016llx", static_cast<unsigned long long>(XXH3_64bits(bare.data(), bare.size())));
    root["description_checksum"] = hex;
    TIFF* const tiff = TIFFOpen(path.c_str(), "w");
    ASSERT_TRUE(tiff);
    for (const auto& [bits, channels] : {std::pair{8, 3}, {32, 1}, {8, 1}}) {
        TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, width);
        TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, height);
        TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, bits);
        TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, channels);
        TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, bits == 32 ? SAMPLEFORMAT_IEEEFP : SAMPLEFORMAT_UINT);
        TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, channels == 3 ? PHOTOMETRIC_RGB : PHOTOMETRIC_MINISBLACK);
        TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
        TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_ADOBE_DEFLATE);
        TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 64);
        if (channels == 3) TIFFSetField(tiff, TIFFTAG_IMAGEDESCRIPTION, root.dump().c_str());
        char nothing[16] = {};
        ASSERT_GT(TIFFWriteRawStrip(tiff, 0, nothing, sizeof nothing), 0);
        ASSERT_EQ(TIFFWriteDirectory(tiff), 1);
    }
    TIFFClose(tiff);
}

TEST_F(DepthTiff, TakesNoMemoryForWhatTheFileCannotHold) {
    const auto path = folder_ / "claim.tiff";
    const long before = peakKilobytes();
    for (const std::uint32_t side : {65536u, 30000u, 65537u}) {
        writeClaim(path, side, side);
        ASSERT_LT(std::filesystem::file_size(path), 100000u);
        const std::string message = failureOf<Failure>([&] { readDepthTiff(path); });
        const char* const cause = side > 65536 ? "camera that is not usable" : "too short for its size";
        EXPECT_NE(message.find(cause), std::string::npos) << side << ": " << message;
        EXPECT_NE(message.find(path.string()), std::string::npos) << message;
    }
    EXPECT_LT(peakKilobytes() - before, 100 * 1024);
    writeClaim(path, 300, 200); // small enough to be believed until its strips are read
    EXPECT_NE(failureOf<Failure>([&] { readDepthTiff(path); }).find("cut off or damaged"), std::string::npos);
}

TEST_F(DepthTiff, HoldsNoDisparityThatIsNoNumber) {
    for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), -0.5f}) {
        DepthImage image = drawImage(20, 10, 5);
        image.disparity(7, 3) = bad;
        const auto path = folder_ / "image.tiff";
        writeDepthTiff(image, path);
        const std::string message = failureOf<Failure>([&] { readDepthTiff(path); });
        EXPECT_NE(message.find("no number"), std::string::npos) << bad << ": " << message;
    }
}

TEST_F(DepthTiff, IsNotWhateverElseLiesThere) {
    const auto path = folder_ / "other.tiff";
    const auto expectRefused = [&](const std::string& what) {
        EXPECT_NE(failureOf<Failure>([&] { readDepthTiff(path); }).find(path.string()), std::string::npos) << what;
        EXPECT_NE(failureOf<Failure>([&] { readDepthTiffHeader(path); }).find(path.string()), std::string::npos)
            << what;
    };
    expectRefused("a file that is not there");
    writeFile(path, "");
    expectRefused("an empty file");
    writeFile(path, "This is a text, and a longer one than the head of a TIFF.");
    expectRefused("a text");
    writeFlagsTiff(Image<std::uint8_t>(20, 10, 1), path);
    expectRefused("flags alone");
    std::filesystem::remove(path);
    std::filesystem::create_directory(path);
    expectRefused("a folder");
}

TEST_F(DepthTiff, WithANameThatIsNotUtf8IsAFailure) {
    DepthImage image = drawImage(5, 5, 6);
    image.name = "caf\xe9";
    const std::string message = failureOf<Failure>([&] { writeDepthTiff(image, folder_ / "image.tiff"); });
    EXPECT_NE(message.find("not UTF-8"), std::string::npos) << message;
    EXPECT_EQ(folder_.fileCount(), 0u);
}

TEST_F(DepthTiff, OnAFullDiskIsAFailureThatLeavesWhatWasThere) {
    const auto path = folder_ / "image.tiff";
    const DepthImage image = drawImage(60, 130, 7);
    writeDepthTiff(image, path);
    const std::size_t size = std::filesystem::file_size(path);
    writeFile(path, "what was there before");
    for (std::size_t i = 0; i <= 40; ++i) {
        const std::size_t room = i * size / 40;
        std::string message;
        {
            const FileSizeLimit limit(room);
            message = failureOf<Failure>([&] { writeDepthTiff(image, path); });
        }
        if (room >= size) {
            EXPECT_EQ(message, "");
            EXPECT_EQ(readDepthTiff(path).colour, image.colour);
            continue;
        }
        ASSERT_NE(message.find(path.string()), std::string::npos)
            << room << " of " << size << " bytes: '" << message << "'";
        EXPECT_NE(message.find("disk has room"), std::string::npos) << message;
        EXPECT_EQ(bytesOfFile(path), "what was there before") << room << " of " << size << " bytes";
        EXPECT_EQ(folder_.fileCount(), 1u) << "half a file is left with room for " << room;
    }
    const std::string message =
        failureOf<Failure>([&] { writeDepthTiff(image, folder_ / "no such folder" / "image.tiff"); });
    EXPECT_NE(message.find("no such folder"), std::string::npos) << message;
}

TEST_F(DepthTiff, FlagsAloneComeBackAndNoticeDamage) {
    const DepthImage image = drawImage(33, 70, 8);
    const auto path = folder_ / "flags.tiff";
    writeFlagsTiff(image.flags, path);
    EXPECT_EQ(readFlagsTiff(path, image.camera), image.flags);
    Camera other = image.camera;
    other.width = 34;
    EXPECT_NE(failureOf<Failure>([&] { readFlagsTiff(path, other); }).find(path.string()), std::string::npos);
    const std::string whole = bytesOfFile(path);
    RandomPlaces random(8);
    for (std::size_t place = 0; place < whole.size(); ++place) {
        std::string damaged = whole;
        damaged[place] = static_cast<char>(damaged[place] ^ (1 << random.integerBetween(0, 7)));
        writeFile(path, damaged);
        const std::string message =
            failureOf<Failure>([&] { EXPECT_EQ(readFlagsTiff(path, image.camera), image.flags) << "byte " << place; });
        EXPECT_TRUE(message.empty() || message.find(path.string()) != std::string::npos) << message;
    }
    for (std::size_t length = 0; length < whole.size(); length += 7) {
        writeFile(path, whole.substr(0, length));
        EXPECT_NE(failureOf<Failure>([&] { readFlagsTiff(path, image.camera); }), "") << "cut at " << length;
    }
}

} // namespace
} // namespace scene
