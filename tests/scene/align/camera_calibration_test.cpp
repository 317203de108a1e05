// Cameras from pictures of boards: drawn by a camera that is known, and the well-known pictures left01 to left14.

#include "scene/align/camera_calibration.h"
#include "scene/errors.h"

#include "tests/scene/scratch_folder.h"
#include "tests/shared_data.h"

#include <cmath>
#include <fstream>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace scene {
namespace {

using testing::HasSubstr;

const Camera kCamera{640, 480, 540, 542, 331.5, 236.5};
const Distortion kLens{-0.25, 0.08, 0.001, -0.0005, 0};
const cv::Size kSize(640, 480);

/// A board of 9 x 6 inner corners, 25 mm, as that camera sees it: each pixel's ray is followed to the board.
cv::Mat drawnBoard(const cv::Vec3d& turn, const cv::Vec3d& place, unsigned seed) {
    constexpr int kFiner = 2;
    const cv::Matx33d k(kCamera.fx, 0, kCamera.cx - 0.5, 0, kCamera.fy, kCamera.cy - 0.5, 0, 0, 1);
    const cv::Vec<double, 5> lens(kLens.k1, kLens.k2, kLens.p1, kLens.p2, kLens.k3);
    static std::vector<cv::Point2f> rays; // the same for every board
    std::vector<cv::Point2f> pixels;
    for (int y = 0; y < kFiner * kSize.height; ++y)
        for (int x = 0; x < kFiner * kSize.width; ++x)
            pixels.emplace_back((static_cast<float>(x) + 0.5f) / kFiner - 0.5f,
                                (static_cast<float>(y) + 0.5f) / kFiner - 0.5f);
    if (rays.empty())
        cv::undistortPoints(pixels, rays, k, lens, cv::noArray(), cv::noArray(),
                            {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 20, 1e-8});
    cv::Matx33d cameraFromBoard;
    cv::Rodrigues(turn, cameraFromBoard);
    const cv::Vec3d eye = -(cameraFromBoard.t() * place);
    cv::Mat1b fine(kFiner * kSize.height, kFiner * kSize.width);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const cv::Vec3d ray = cameraFromBoard.t() * cv::Vec3d(rays[i].x, rays[i].y, 1);
        const double s = -eye[2] / ray[2], across = (eye[0] + s * ray[0]) / 0.025, down = (eye[1] + s * ray[1]) / 0.025;
        const bool isBoard = across >= -1 && across < 9 && down >= -1 && down < 6;
        const bool isDark =
            isBoard && (static_cast<int>(std::floor(across)) + static_cast<int>(std::floor(down))) % 2 == 0;
        fine(static_cast<int>(i) / fine.cols, static_cast<int>(i) % fine.cols) = isDark ? 30 : 220;
    }
    cv::Mat picture;
    cv::resize(fine, picture, kSize, 0, 0, cv::INTER_AREA);
    cv::Mat noise(picture.size(), CV_16S);
    cv::RNG generator(seed);
    generator.fill(noise, cv::RNG::NORMAL, 0, 3);
    cv::add(picture, noise, picture, cv::noArray(), CV_8U);
    return picture;
}

/// A board whose middle stands before the camera, tilted about x and y.
std::filesystem::path writeBoard(const std::filesystem::path& folder, int number, double tiltX, double tiltY,
                                 double metres, double right = 0, double down = 0) {
    const cv::Vec3d turn(tiltX, tiltY, 0.05 * number);
    cv::Matx33d rotation;
    cv::Rodrigues(turn, rotation);
    const cv::Vec3d place = cv::Vec3d(right, down, metres) - rotation * cv::Vec3d(0.1, 0.0625, 0);
    const std::filesystem::path path = folder / ("board" + std::to_string(number) + ".png");
    cv::imwrite(path.string(), drawnBoard(turn, place, static_cast<unsigned>(number)));
    return path;
}

TEST(CameraCalibration, FindsAKnownCameraAndTellsOfPicturesThatShowNoBoard) {
    const ScratchFolder scratch;
    std::vector<std::filesystem::path> pictures;
    const double tilts[][2] = {{0.5, 0}, {-0.5, 0.1}, {0, 0.5}, {0.1, -0.5}, {0.35, 0.35}, {-0.3, -0.4}, {0.1, 0.1}};
    const double places[][2] = {{0, 0}, {0.08, 0.04}, {-0.08, 0.03}, {0.07, -0.04}, {-0.07, -0.04}, {0, 0.05}, {0, 0}};
    for (int i = 0; i < 7; ++i)
        pictures.push_back(
            writeBoard(scratch.path(), i, tilts[i][0], tilts[i][1], 0.36 + 0.03 * i, places[i][0], places[i][1]));
    pictures.push_back(scratch.path() / "empty.png");
    cv::imwrite(pictures.back().string(), cv::Mat(kSize, CV_8U, cv::Scalar(128)));
    pictures.push_back(scratch.path() / "small.png");
    cv::imwrite(pictures.back().string(), cv::Mat(100, 100, CV_8U, cv::Scalar(128)));
    pictures.push_back(scratch.path() / "text.png");
    std::ofstream(pictures.back()) << "not a picture";

    const CameraCalibration found = calibrateCamera(pictures, {});
    EXPECT_NEAR(found.camera.fx, kCamera.fx, 0.002 * kCamera.fx);
    EXPECT_NEAR(found.camera.fy, kCamera.fy, 0.002 * kCamera.fy);
    EXPECT_NEAR(found.camera.cx, kCamera.cx, 1.5);
    EXPECT_NEAR(found.camera.cy, kCamera.cy, 1.5);
    EXPECT_NEAR(found.camera.fx, kCamera.fx, 5 * found.focalDeviation);
    EXPECT_NEAR(found.distortion.k1, kLens.k1, 0.02);
    EXPECT_LT(found.rmsPixels, 0.15);
    EXPECT_GE(found.worstPixels, found.meanPixels);
    EXPECT_LT(found.meanMetres, 0.0001);
    int boards = 0;
    for (const BoardPicture& picture : found.pictures)
        boards += picture.isFound;
    EXPECT_EQ(boards, 7);
    EXPECT_THAT(found.pictures[7].why, HasSubstr("no whole board"));
    EXPECT_THAT(found.pictures[8].why, HasSubstr("another size"));
    EXPECT_THAT(found.pictures[9].why, HasSubstr("cannot be read"));
}

std::string failureOf(const std::vector<std::filesystem::path>& pictures, const BoardOptions& options = {}) {
    try {
        calibrateCamera(pictures, options);
    } catch (const Failure& failure) {
        return failure.what();
    }
    return {};
}

TEST(CameraCalibration, TooFewBoardsAndBoardsThatHoldNothingAreRefused) {
    const ScratchFolder scratch;
    std::vector<std::filesystem::path> square;
    for (int i = 0; i < 4; ++i)
        square.push_back(writeBoard(scratch.path(), i, 0, 0, 0.4));
    EXPECT_THAT(failureOf(square), HasSubstr("tilt the board"));
    EXPECT_THAT(failureOf({square[0], square[1]}), HasSubstr("found in 2 of 2"));
    // In noise OpenCV looks for seconds for what is not there.
    const std::filesystem::path smooth = scratch.path() / "smooth.png";
    cv::Mat board = cv::imread(square[0].string(), cv::IMREAD_GRAYSCALE);
    cv::medianBlur(board, board, 5);
    cv::imwrite(smooth.string(), board);
    EXPECT_THAT(failureOf({smooth}), HasSubstr("found in 1 of 1"));
    EXPECT_THAT(failureOf({smooth}, {7, 7, 0.025, 0}), HasSubstr("no whole board of 7 x 7"));
}

class BoardPictures : public testing::Test {
  protected:
    void SetUp() override {
        const std::filesystem::path folder = tests::dataFolder() / "calib_opencv";
        if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not here";
        for (int i = 1; i <= 14; ++i)
            if (i != 10) {
                char name[16];
                std::snprintf(name, sizeof name, "left%02d.jpg", i);
                pictures_.push_back(folder / name);
            }
    }
    std::vector<std::filesystem::path> pictures_;
};

TEST_F(BoardPictures, LeftToLessThanAFifthOfAPixel) {
    const CameraCalibration found = calibrateCamera(pictures_, {});
    EXPECT_LE(found.rmsPixels, 0.2);
    EXPECT_LT(found.focalDeviation, 1);
    // Half of the boards find the same focal length as the others.
    std::vector<std::filesystem::path> even, odd;
    for (std::size_t i = 0; i < pictures_.size(); ++i)
        (i % 2 ? odd : even).push_back(pictures_[i]);
    EXPECT_NEAR(calibrateCamera(even, {}).camera.fx, calibrateCamera(odd, {}).camera.fx, 4);
}

TEST_F(BoardPictures, WithTheUsualWindowTheFocalLengthIsThePublishedOne) {
    const CameraCalibration found = calibrateCamera(pictures_, {9, 6, 0.025, 11});
    EXPECT_LE(found.rmsPixels, 0.41);
    EXPECT_NEAR(found.camera.fx, 535.9, 0.002 * 535.9);
    EXPECT_NEAR(found.camera.fy, 535.9, 0.002 * 535.9);
    EXPECT_NEAR(found.camera.cx - 0.5, 342.283, 0.5); // pixel centres at halves
}

} // namespace
} // namespace scene
