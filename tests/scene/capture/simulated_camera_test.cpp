// The simulated camera against worlds of a formula; and photographs that stand beside scans in E57 files.

#include "scene/capture/simulated_camera.h"

#include "scene/capture/write_scans.h"
#include "scene/errors.h"
#include "scene/import/e57.h"
#include "scene/import/importer.h"
#include "scene/import/scan_photos.h"
#include "scene/srgb.h"

#include "tests/scene/scratch_folder.h"

#include <array>
#include <cmath>

#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <tbb/global_control.h>

namespace scene {
namespace {

using testing::HasSubstr;

/// White to the right of the plane x = 0.2 z, dark to its left.
ScannedWorld halves() {
    ScannedWorld world;
    world.colour = [](const glm::dvec3&, const glm::dvec3& d) {
        return d.x > 0.2 * d.z ? Rgb8{200, 200, 200} : Rgb8{20, 20, 20};
    };
    return world;
}

SimulatedCameraOptions quiet() {
    SimulatedCameraOptions options;
    options.lens = usualCamera(200, 150, 65);
    options.noise = 0;
    options.raysPerPixel = 64;
    return options;
}

/// How much of a row is dark, in pixels: the edge's own pixel by its light.
double darkPixels(const Image<Rgb8>& picture, int y) {
    const double dark = linearFromSrgb(std::uint8_t{20}), bright = linearFromSrgb(std::uint8_t{200});
    double pixels = 0;
    for (const Rgb8& pixel : picture.row(y))
        pixels += (bright - linearFromSrgb(pixel.g)) / (bright - dark);
    return pixels;
}

TEST(SimulatedCamera, ShowsEdgesWhereItsLensBendsThemToAFractionOfAPixel) {
    const SimulatedCameraOptions options = quiet();
    const Image<Rgb8> picture = takePhotograph(halves(), {}, options);
    const Camera& c = options.lens.camera;
    for (const int y : {5, 75, 145}) {
        double low = 0, high = c.width;
        for (int i = 0; i < 60; ++i) { // where the row's pixels begin to see the right half
            const double x = (low + high) / 2;
            const glm::dvec2 ideal = undistorted(options.lens.distortion, glm::dvec2(rayThrough(c, x, y + 0.5)));
            (ideal.x > 0.2 ? high : low) = x;
        }
        EXPECT_NEAR(darkPixels(picture, y), low, 0.1) << "row " << y;
    }
}

TEST(SimulatedCamera, ExposureAndBalanceScaleLightAndNoiseIsAsAsked) {
    ScannedWorld grey;
    grey.colour = [](const glm::dvec3&, const glm::dvec3&) { return Rgb8{100, 100, 100}; };
    SimulatedCameraOptions options = quiet();
    options.exposureStops = 1;
    options.whiteBalance = {0.5, 1, 1};
    Image<Rgb8> picture = takePhotograph(grey, {}, options);
    EXPECT_EQ(picture(3, 3).r, 100) << "one stop more, half of the red";
    EXPECT_NEAR(linearFromSrgb(picture(3, 3).g), 2 * linearFromSrgb(std::uint8_t{100}), 0.003);

    options = quiet();
    options.noise = 2;
    picture = takePhotograph(grey, {}, options);
    double sum = 0, squares = 0;
    for (const Rgb8& pixel : picture.pixels())
        sum += pixel.g, squares += double{1} * pixel.g * pixel.g;
    const double count = static_cast<double>(picture.size()), mean = sum / count;
    EXPECT_NEAR(mean, 100, 0.1);
    EXPECT_NEAR(std::sqrt(squares / count - mean * mean), 2, 0.1);

    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    EXPECT_EQ(takePhotograph(grey, {}, options), picture);
}

std::vector<std::uint8_t> jpegOf(int width, int height) {
    std::vector<std::uint8_t> bytes;
    cv::imencode(".jpg", cv::Mat3b(height, width, cv::Vec3b(30, 90, 200)), bytes);
    return bytes;
}

/// Two scans, and a photograph of the second.
std::filesystem::path writeTwo(const ScratchFolder& folder, const WrittenPhotograph& photograph) {
    const std::filesystem::path path = folder / "two.e57";
    writeE57(path, 2,
             [](std::size_t i) {
                 ScanWithIntensity read;
                 read.scan.name = "scan" + std::to_string(i + 1);
                 read.scan.worldFromScanner.translation = {10.0 * static_cast<double>(i), 0, 0};
                 read.scan.pointsInScanner = {glm::vec3(1, 0, 0), glm::vec3(0, 2 + static_cast<float>(i), 0)};
                 read.scan.colours.assign(2, Rgb8{});
                 read.intensities = {0.25f, 0.75f};
                 return read;
             },
             {1, [&](std::size_t) { return photograph; }});
    return path;
}

TEST(ScanPhotos, AreReadAsTheyWereWrittenWithTheScanTheyBelongTo) {
    const ScratchFolder folder;
    const Pose pose = poseFromQuaternion({10, 0, 0}, 0.1, 0.2, 0.3, 0.9);
    const Camera camera{64, 48, 50, 51, 33, 23};
    const std::array<std::filesystem::path, 1> inputs{writeTwo(folder, {"shot", 1, camera, pose, jpegOf(64, 48)})};
    const Capture capture = openCapture(inputs);
    ASSERT_EQ(capture.scanPhotos.size(), 1u);
    const ScanPhoto& photo = capture.scanPhotos[0];
    EXPECT_EQ(photo.name, "shot");
    EXPECT_EQ(photo.scan, 1u);
    EXPECT_NEAR(photo.camera.fx, 50, 1e-9);
    EXPECT_NEAR(photo.camera.fy, 51, 1e-9);
    EXPECT_NEAR(photo.camera.cx, 33, 1e-9);
    EXPECT_LT(glm::distance(photo.worldFromCamera * glm::dvec3(1, 2, 3), pose * glm::dvec3(1, 2, 3)), 1e-9);
    EXPECT_NEAR(readScanPhoto(photo)(5, 5).r, 200, 3);
    EXPECT_THAT(capture.remarks, testing::ElementsAre(HasSubstr("scan 'scan1' has no photograph")));
    EXPECT_THAT(readE57ScanWithIntensity(capture.scans[1]).intensities, testing::ElementsAre(0.25f, 0.75f));
}

TEST(ScanPhotos, ACameraFileMustBeOfTheirCamera) {
    const ScratchFolder folder;
    const std::array<std::filesystem::path, 1> inputs{
        writeTwo(folder, {"shot", 0, {64, 48, 50, 51, 33, 23}, {}, jpegOf(64, 48)})};
    Capture capture = openCapture(inputs);
    const CameraFile right{{64, 48, 49, 49, 32, 24}, {0.1, 0, 0, 0, 0}};
    writeCameraFile(folder / "right.json", right);
    useCameraFile(capture, folder / "right.json");
    EXPECT_EQ(capture.scanPhotos[0].camera, right.camera);
    EXPECT_EQ(capture.scanPhotos[0].distortion, right.distortion);
    writeCameraFile(folder / "wrong.json", {{128, 96, 98, 98, 64, 48}, {}});
    const auto refusal = [&] {
        try {
            useCameraFile(capture, folder / "wrong.json");
        } catch (const Failure& failure) {
            return std::string(failure.what());
        }
        return std::string();
    };
    EXPECT_THAT(refusal(), HasSubstr("is of pictures of 128x96, but photograph 'shot' is 64x48"));
    capture.scanPhotos.clear();
    EXPECT_THAT(refusal(), HasSubstr("there are none that can be used"));
}

TEST(ScanPhotos, APictureOfAnotherSizeThanItsCameraIsRefused) {
    const ScratchFolder folder;
    const std::array<std::filesystem::path, 1> inputs{
        writeTwo(folder, {"shot", 0, {64, 48, 50, 51, 33, 23}, {}, jpegOf(32, 48)})};
    const Capture capture = openCapture(inputs);
    EXPECT_THROW(readScanPhoto(capture.scanPhotos.at(0)), Failure);
}

} // namespace
} // namespace scene
