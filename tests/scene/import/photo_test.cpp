#include "scene/import/photo.h"

#include "scene/errors.h"
#include "tests/scene/import/pictures.h"
#include "tests/scene/scratch_folder.h"

#include <limits>

#include <glm/geometric.hpp>

namespace scene {
namespace {

class Photo : public testing::Test {
  protected:
    PhotoSource source(int width, int height) {
        PhotoSource photo;
        photo.name = "photo";
        photo.colourPath = folder_ / "colour.png", photo.depthPath = folder_ / "depth.png";
        photo.camera = {width, height, 0.8 * width, 0.8 * width, width / 2.0, height / 2.0};
        return photo;
    }
    /// Expects a Failure that names the file and says the words.
    void expectRefused(const PhotoSource& photo, const std::filesystem::path& file, const std::string& words) {
        const std::string message = failureOf<Failure>([&] { readPhoto(photo); });
        EXPECT_EQ(message.find(file.string()), 0u) << "'" << message << "'";
        EXPECT_NE(message.find(words), std::string::npos) << "'" << message << "' does not say '" << words << "'";
    }

    ScratchFolder folder_;
};

TEST_F(Photo, OfAPinholeComesAsItIs) {
    PhotoSource photo = source(40, 30);
    photo.worldFromCamera.translation = {1, 2, 3};
    photo.depthUnitMetres = 0.0005;
    cv::Mat depth = flatDepth(40, 30, 3000);
    depth.at<std::uint16_t>(4, 9) = 0;
    depth.at<std::uint16_t>(20, 30) = 65535;
    writePicture(photo.colourPath, gradientPicture(40, 30));
    writePicture(photo.depthPath, depth);
    const DepthImage image = readPhoto(photo);
    EXPECT_EQ(image.name, "photo");
    EXPECT_EQ(image.camera, photo.camera);
    EXPECT_EQ(image.worldFromCamera.translation, glm::dvec3(1, 2, 3));
    for (int y = 0; y < 30; ++y)
        for (int x = 0; x < 40; ++x) {
            ASSERT_TRUE(
                (image.colour(x, y) == Rgb8{static_cast<std::uint8_t>(3 * x), static_cast<std::uint8_t>(5 * y), 7}))
                << "at " << x << ", " << y;
            const bool isAbsent = x == 9 && y == 4, isFar = x == 30 && y == 20;
            ASSERT_EQ(image.flags(x, y), isAbsent ? kNoSurface : 0) << "at " << x << ", " << y;
            ASSERT_FLOAT_EQ(image.disparity(x, y), isAbsent ? 0.f
                                                   : isFar  ? 1 / (65535 * 0.0005f)
                                                            : 1 / 1.5f)
                << "at " << x << ", " << y;
        }
}

TEST_F(Photo, DepthInFloatsIsMetresAndWhatIsNoneIsNoSurface) {
    PhotoSource photo = source(8, 6);
    photo.depthPath = folder_ / "depth.tiff";
    cv::Mat1f depth(6, 8, 2.5f);
    constexpr float kBad[] = {0.f,
                              -1.f,
                              std::numeric_limits<float>::quiet_NaN(),
                              std::numeric_limits<float>::infinity(),
                              -std::numeric_limits<float>::infinity(),
                              std::numeric_limits<float>::denorm_min()};
    for (int i = 0; i < 6; ++i)
        depth(i, 3) = kBad[i];
    writePicture(photo.colourPath, gradientPicture(8, 6));
    writePicture(photo.depthPath, depth);
    const DepthImage image = readPhoto(photo);
    for (int y = 0; y < 6; ++y)
        for (int x = 0; x < 8; ++x) {
            ASSERT_EQ(image.flags(x, y), x == 3 ? kNoSurface : 0) << "at " << x << ", " << y << " for " << depth(y, x);
            ASSERT_EQ(image.disparity(x, y), x == 3 ? 0.f : 1 / 2.5f) << "at " << x << ", " << y;
        }
}

TEST_F(Photo, DepthIsInTheUnitThatIsGivenElseInWhatIsUsualOfItsKind) {
    PhotoSource photo = source(8, 6);
    writePicture(photo.colourPath, gradientPicture(8, 6));
    const auto metresOf = [&](const cv::Mat& depth, const char* file, std::optional<double> unit) {
        photo.depthPath = folder_ / file;
        photo.depthUnitMetres = unit;
        writePicture(photo.depthPath, depth);
        return 1 / readPhoto(photo).disparity(3, 2);
    };
    const cv::Mat steps = flatDepth(8, 6, 2500), floats = cv::Mat1f(6, 8, 2500.f);
    EXPECT_FLOAT_EQ(metresOf(steps, "depth.png", std::nullopt), 2.5f) << "millimetres";
    EXPECT_FLOAT_EQ(metresOf(floats, "depth.tiff", std::nullopt), 2500.f) << "metres";
    EXPECT_FLOAT_EQ(metresOf(steps, "depth.png", 0.002), 5.f);
    EXPECT_FLOAT_EQ(metresOf(floats, "depth.tiff", 0.002), 5.f);
    EXPECT_FLOAT_EQ(metresOf(steps, "depth.png", 1.0), 2500.f);
    EXPECT_FLOAT_EQ(metresOf(floats, "depth.tiff", 0.001), 2.5f)
        << "given, though it is what 16 bit steps have unasked";
}

TEST_F(Photo, DepthOfALowerResolutionIsExactOnPlanesAndNeverBetweenSurfaces) {
    PhotoSource photo = source(160, 120);
    photo.depthPath = folder_ / "depth.tiff";
    // At the left a plane aslant, 2 to 3 m away; at the right a wall at 1 m.
    const auto disparity = [](double x, double y) { return x < 80 ? 0.3 + 0.001 * x + 0.0005 * y : 1.0; };
    cv::Mat1f depth(30, 40);
    for (int y = 0; y < 30; ++y)
        for (int x = 0; x < 40; ++x)
            depth(y, x) = static_cast<float>(1 / disparity(4 * (x + 0.5), 4 * (y + 0.5)));
    writePicture(photo.colourPath, gradientPicture(160, 120));
    writePicture(photo.depthPath, depth);
    const DepthImage image = readPhoto(photo);
    for (int y = 2; y < 118; ++y)
        for (int x = 2; x < 158; ++x) {
            const double d = static_cast<double>(image.disparity(x, y)), truth = disparity(x + 0.5, y + 0.5);
            // Beside the silhouette the nearest of the coarse samples is taken: up to 2 pixels off, but on a surface.
            ASSERT_NEAR(d, truth, std::abs(x - 79.5) < 4 ? 0.005 : 1e-6) << "at " << x << ", " << y;
        }
}

/// The inverse of OpenCV's distortion, by iteration.
glm::dvec2 undistorted(const Distortion& d, const glm::dvec2& distorted) {
    glm::dvec2 p = distorted;
    for (int i = 0; i < 60; ++i) {
        const double r2 = glm::dot(p, p), radial = 1 + r2 * (d.k1 + r2 * (d.k2 + r2 * d.k3));
        const glm::dvec2 tangential(2 * d.p1 * p.x * p.y + d.p2 * (r2 + 2 * p.x * p.x),
                                    d.p1 * (r2 + 2 * p.y * p.y) + 2 * d.p2 * p.x * p.y);
        p = (distorted - tangential) / radial;
    }
    return p;
}

TEST_F(Photo, IsFreedOfDistortion) {
    PhotoSource photo = source(200, 150);
    photo.camera.cx = 103, photo.camera.cy = 71;
    photo.distortion = {-0.18, 0.05, 0.004, -0.003, 0.01};
    photo.depthPath = folder_ / "depth.tiff";
    // A soft checker and a plane, both as functions of the pinhole's ray.
    const auto brightness = [](const glm::dvec2& p) { return 128 + 90 * std::sin(14 * p.x) * std::sin(14 * p.y); };
    const auto disparity = [](const glm::dvec2& p) { return 0.5 + 0.1 * p.x - 0.05 * p.y; };
    cv::Mat colour(150, 200, CV_8UC3);
    cv::Mat1f depth(150, 200);
    for (int y = 0; y < 150; ++y)
        for (int x = 0; x < 200; ++x) {
            const glm::dvec3 ray = rayThrough(photo.camera, x + 0.5, y + 0.5);
            const glm::dvec2 p = undistorted(photo.distortion, {ray.x, ray.y});
            const auto value = static_cast<unsigned char>(std::lround(brightness(p)));
            colour.at<cv::Vec3b>(y, x) = {value, value, value};
            depth(y, x) = static_cast<float>(1 / disparity(p));
        }
    writePicture(photo.colourPath, colour);
    writePicture(photo.depthPath, depth);
    const DepthImage image = readPhoto(photo);
    int seen = 0;
    for (int y = 0; y < 150; ++y)
        for (int x = 0; x < 200; ++x) {
            if (image.flags(x, y) != 0) continue;
            ++seen;
            const glm::dvec3 ray = rayThrough(photo.camera, x + 0.5, y + 0.5);
            ASSERT_NEAR(image.disparity(x, y), disparity({ray.x, ray.y}), 2e-4) << "at " << x << ", " << y;
            if (x < 2 || y < 2 || x > 197 || y > 147) continue;
            ASSERT_NEAR(image.colour(x, y).g, brightness({ray.x, ray.y}), 3.0) << "at " << x << ", " << y;
        }
    EXPECT_GT(seen, 200 * 150 * 9 / 10);
}

TEST_F(Photo, ShowsNothingWhereItsLensWouldFoldItOverItself) {
    PhotoSource photo = source(160, 120);
    photo.distortion.k1 = -0.8; // at sqrt(1 / (3 * 0.8)) = 0.645 of the focal length; a corner is at 0.78
    writePicture(photo.colourPath, gradientPicture(160, 120));
    writePicture(photo.depthPath, flatDepth(160, 120, 3000));
    DepthImage image = readPhoto(photo);
    for (int y = 0; y < 120; ++y)
        for (int x = 0; x < 160; ++x)
            if (image.flags(x, y) == kNoSurface) image.flags(x, y) |= kInterpolated, image.disparity(x, y) = 1;
    keepWithinPicture(image, photo); // what was guessed, too
    int folded = 0;
    for (int y = 0; y < 120; ++y)
        for (int x = 0; x < 160; ++x) {
            const double far = glm::length(glm::dvec2(rayThrough(image.camera, x + 0.5, y + 0.5)));
            if (far < 0.6) {
                ASSERT_EQ(image.flags(x, y), 0) << x << ", " << y;
            } else if (far > 0.67) {
                ASSERT_EQ(image.flags(x, y), kNoSurface) << x << ", " << y;
                ++folded;
            }
        }
    EXPECT_GT(folded, 100);
}

// Cameras write how a picture is to be turned for viewing; its depth knows nothing of that.
TEST_F(Photo, IsNotTurnedByItsExifOrientation) {
    PhotoSource photo = source(40, 30);
    photo.colourPath = folder_ / "colour.jpg";
    std::vector<unsigned char> jpeg;
    ASSERT_TRUE(cv::imencode(".jpg", gradientPicture(40, 30), jpeg));
    const unsigned char exif[] = {
        0xff, 0xe1, 0,    34, 'E', 'x', 'i', 'f', 0, 0, 'I', 'I', 42, 0, 8, 0, 0, 0,
        1,    0,    0x12, 1,  3,   0,   1,   0,   0, 0, 3,   0,   0,  0, 0, 0, 0, 0}; // orientation 3: upside down
    jpeg.insert(jpeg.begin() + 2, std::begin(exif), std::end(exif));
    writeFile(photo.colourPath, {jpeg.begin(), jpeg.end()});
    writePicture(photo.depthPath, flatDepth(40, 30, 1000));
    const cv::Mat turned = cv::imread(photo.colourPath.string(), cv::IMREAD_COLOR);
    ASSERT_GT(turned.at<cv::Vec3b>(2, 2)[2], 80) << "the picture does not ask to be turned";
    const DepthImage image = readPhoto(photo);
    EXPECT_NEAR(image.colour(2, 2).r, 6, 12);
    EXPECT_NEAR(image.colour(37, 27).r, 111, 12);
}

TEST_F(Photo, ThatCannotBeUsedIsAFailureThatNamesIt) {
    const PhotoSource photo = source(40, 30);
    expectRefused(photo, photo.colourPath, "no such picture");
    writePicture(photo.colourPath, gradientPicture(40, 30));
    expectRefused(photo, photo.depthPath, "no such picture");
    writePicture(photo.depthPath, flatDepth(40, 20, 1000));
    expectRefused(photo, photo.depthPath, "another shape");
    writePicture(photo.depthPath, gradientPicture(40, 30));
    expectRefused(photo, photo.depthPath, "3 channels");
    writePicture(photo.depthPath, cv::Mat(30, 40, CV_8UC1, cv::Scalar(3)));
    expectRefused(photo, photo.depthPath, "neither 16 bit steps nor 32 bit floats");
    writePicture(photo.depthPath, flatDepth(200, 150, 1000));
    expectRefused(photo, photo.depthPath, "more than 4 times as wide");
    // Whose header claims too much is refused by that, not by what comes of decoding it.
    std::filesystem::resize_file(photo.depthPath, 40);
    expectRefused(photo, photo.depthPath, "more than 4 times as wide");
    writePicture(photo.depthPath, flatDepth(40, 30, 1000));
    writePicture(photo.colourPath, gradientPicture(41, 30));
    expectRefused(photo, photo.colourPath, "41x30");
    for (const char* bytes : {"", "no picture", "\x89PNG\r\n\x1a\n"}) {
        writeFile(photo.colourPath, bytes);
        expectRefused(photo, photo.colourPath, "picture");
    }
    std::filesystem::remove(photo.colourPath);
    std::filesystem::create_directory(photo.colourPath);
    expectRefused(photo, photo.colourPath, "no such picture");
}

} // namespace
} // namespace scene
