// Camera files and lenses: read as written, refused in one sentence, and taken out of pictures to a fraction of a
// pixel.

#include "scene/import/camera_file.h"
#include "scene/import/straighten.h"

#include "scene/errors.h"

#include "tests/scene/scratch_folder.h"

#include <cmath>
#include <fstream>

#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace scene {
namespace {

using testing::HasSubstr;

const Distortion kLens{-0.2, 0.05, 0.001, -0.0007, 0.01};

std::string refusalOf(const ScratchFolder& folder, const std::string& text) {
    std::ofstream(folder / "camera.json") << text;
    try {
        readCameraFile(folder / "camera.json");
    } catch (const Failure& failure) {
        return failure.what();
    }
    return "not refused";
}

TEST(CameraFileTest, IsReadAsItWasWrittenAndMayLackALens) {
    const ScratchFolder folder;
    const CameraFile written{{640, 480, 501.25, 502.5, 321.5, 238.75}, kLens};
    writeCameraFile(folder / "camera.json", written);
    const CameraFile read = readCameraFile(folder / "camera.json");
    EXPECT_EQ(read.camera, written.camera);
    EXPECT_EQ(read.distortion, written.distortion);

    std::ofstream(folder / "plain.json")
        << R"({"width": 64, "height": 48, "fx": 50, "fy": 51, "cx": 32, "cy": 24, "taken_with": "anything"})";
    EXPECT_EQ(readCameraFile(folder / "plain.json").distortion, Distortion{});
}

TEST(CameraFileTest, WhatIsNoCameraIsRefusedWithWhatIsWrong) {
    const ScratchFolder folder;
    EXPECT_THAT(refusalOf(folder, "[1]"), HasSubstr("is no camera"));
    EXPECT_THAT(refusalOf(folder, "{"), HasSubstr("is not valid JSON"));
    const std::string rest = R"("height": 48, "fx": 50, "fy": 51, "cx": 32, "cy": 24)";
    EXPECT_THAT(refusalOf(folder, "{" + rest + "}"), HasSubstr("\"width\" is missing"));
    EXPECT_THAT(refusalOf(folder, R"({"width": 64.5, )" + rest + "}"), HasSubstr("\"width\" is no number of pixels"));
    EXPECT_THAT(refusalOf(folder, R"({"width": "64", )" + rest + "}"), HasSubstr("\"width\" is no finite number"));
    EXPECT_THAT(refusalOf(folder, R"({"width": 64, "k1": null, )" + rest + "}"), HasSubstr("\"k1\" is no finite"));
    EXPECT_THAT(refusalOf(folder, R"({"width": 64, "height": 48, "fx": -1, "fy": 51, "cx": 32, "cy": 24})"),
                HasSubstr("not positive"));
    EXPECT_THAT(refusalOf(folder, R"({"width": 64, "k1": -4, )" + rest + "}"), HasSubstr("folds the picture"));
    EXPECT_THROW(readCameraFile(folder / "none.json"), Failure);
}

TEST(CameraFileTest, TheLensIsUndoneExactly) {
    for (double x = -0.7; x <= 0.7; x += 0.1)
        for (double y = -0.5; y <= 0.5; y += 0.1)
            EXPECT_LT(glm::distance(undistorted(kLens, distorted(kLens, {x, y})), glm::dvec2(x, y)), 1e-12);
}

/// Smooth in the plane at depth 1: what the world looks like there.
glm::dvec3 shadeAt(const glm::dvec2& place) {
    return {128 + 100 * std::sin(9 * place.x), 128 + 100 * std::cos(7 * place.y),
            128 + 60 * std::sin(5 * place.x + 4 * place.y)};
}

Image<Rgb8> pictureThrough(const CameraFile& file) {
    Image<Rgb8> picture(file.camera.width, file.camera.height);
    for (int y = 0; y < picture.height(); ++y)
        for (int x = 0; x < picture.width(); ++x) {
            const glm::dvec3 c =
                shadeAt(undistorted(file.distortion, glm::dvec2(rayThrough(file.camera, x + 0.5, y + 0.5))));
            const auto byte = [](double v) { return static_cast<std::uint8_t>(std::lround(v)); };
            picture(x, y) = {byte(c.x), byte(c.y), byte(c.z)};
        }
    return picture;
}

TEST(Straighten, GivesWhatAPinholeSeesAtItsOwnSizeAndSmaller) {
    const CameraFile file{{320, 240, 260, 262, 158, 122}, kLens};
    const Image<Rgb8> picture = pictureThrough(file);
    for (const Camera& pinhole : {file.camera, resized(file.camera, 133, 100)}) {
        const StraightPicture straight = straightened(picture, file, pinhole);
        ASSERT_EQ(straight.colour.width(), pinhole.width);
        double worst = 0;
        for (int y = 0; y < pinhole.height; ++y)
            for (int x = 0; x < pinhole.width; ++x) {
                if (!straight.isSeen(x, y)) continue;
                const glm::dvec3 c = shadeAt(glm::dvec2(rayThrough(pinhole, x + 0.5, y + 0.5)));
                worst = std::max(worst, std::abs(c.x - straight.colour(x, y).r));
                worst = std::max(worst, std::abs(c.y - straight.colour(x, y).g));
            }
        EXPECT_LT(worst, 3) << "a shift of one pixel would be 4 of 255";
    }
    // A wider pinhole looks where the photograph does not reach.
    Camera wide = file.camera;
    wide.fx /= 2, wide.fy /= 2;
    const StraightPicture straight = straightened(picture, file, wide);
    EXPECT_FALSE(straight.isSeen(0, 0));
    EXPECT_TRUE(straight.isSeen(160, 120));
}

} // namespace
} // namespace scene
