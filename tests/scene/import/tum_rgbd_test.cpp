#include "scene/import/tum_rgbd.h"

#include "scene/errors.h"
#include "scene/import/importer.h"
#include "scene/import/photo.h"
#include "tests/scene/import/pictures.h"
#include "tests/scene/scratch_folder.h"

#include <cmath>

#include <glm/geometric.hpp>

namespace scene {
namespace {

class TumRgbd : public testing::Test {
  protected:
    void SetUp() override {
        writePicture(folder_ / "rgb/1.png", gradientPicture(40, 30));
        writePicture(folder_ / "depth/1.png", flatDepth(40, 30, 10000));
        write("rgb.txt", "# colour\n# timestamp filename\n1.00 rgb/1.png\n");
        write("depth.txt", "1.01 depth/1.png\n");
        write("groundtruth.txt", "1.00 1 2 3 0 0 0 1\n");
        write("intrinsics.txt", "30 31 19.5 14.5\n");
    }
    void write(const char* name, const std::string& text) { writeFile(folder_ / name, text); }
    Capture list() {
        Capture capture;
        listTumRgbd(folder_.path(), capture);
        return capture;
    }
    void expectRefused(const std::string& words) {
        const std::string message = failureOf<Failure>([&] { list(); });
        EXPECT_EQ(message.find(folder_.path().string()), 0u) << "'" << message << "'";
        EXPECT_NE(message.find(words), std::string::npos) << "'" << message << "' does not say '" << words << "'";
    }

    ScratchFolder folder_;
};

TEST_F(TumRgbd, GivesPicturesWithDepthAndPose) {
    const std::filesystem::path inputs[] = {folder_.path()};
    const Capture capture = openCapture(inputs);
    ASSERT_EQ(capture.photos.size(), 1u);
    EXPECT_TRUE(capture.remarks.empty());
    const PhotoSource& photo = capture.photos[0];
    EXPECT_EQ(photo.camera, (Camera{40, 30, 30, 31, 20, 15})) << "the benchmark counts pixel centres at whole numbers";
    EXPECT_EQ(photo.worldFromCamera.translation, glm::dvec3(1, 2, 3));
    const DepthImage image = readPhoto(photo);
    EXPECT_FLOAT_EQ(image.disparity(3, 4), 0.5f) << "10000 steps of 1/5000 m";
}

TEST_F(TumRgbd, AssociatesTheNearestWithinTwentyMilliseconds) {
    write("rgb.txt", "1.000 rgb/1.png\n3.000 rgb/3.png\n2.000 rgb/2.png\n4.000 rgb/4.png\n");
    // Out of order; the nearer of two; just too far; exactly between is the later one's.
    write("depth.txt",
          "2.015 depth/b.png\n0.985 depth/a.png\n1.990 depth/c.png\n3.021 depth/d.png\n4.019 depth/e.png\n");
    write("groundtruth.txt", "0.5 0 0 0 0 0 0 1\n1.0 0 0 0 0 0 0 1\n1.99 0 0 0 0 0 0 1\n2.01 0 0 0 0 0 0 1\n3 0 0 0 0 "
                             "0 0 1\n3.99 0 0 0 0 0 0 1\n");
    const Capture capture = list();
    ASSERT_EQ(capture.photos.size(), 3u);
    EXPECT_EQ(capture.photos[0].depthPath, folder_ / "depth/a.png");
    EXPECT_EQ(capture.photos[1].depthPath, folder_ / "depth/c.png");
    EXPECT_EQ(capture.photos[2].depthPath, folder_ / "depth/e.png") << "the last pose is 10 ms before the picture";
    ASSERT_EQ(capture.remarks.size(), 1u);
    EXPECT_NE(capture.remarks[0].find("1 of 4 pictures"), std::string::npos) << capture.remarks[0];
}

TEST_F(TumRgbd, InterpolatesThePose) {
    write("rgb.txt", "1.005 rgb/1.png\n");
    // A quarter turn about z within 20 ms; the second quaternion with the opposite sign means the same.
    const std::string half = std::to_string(std::sqrt(0.5));
    for (const std::string& second : {"0 0 " + half + " " + half, "0 0 -" + half + " -" + half}) {
        write("groundtruth.txt", "1.00 0 0 0 0 0 0 1\n1.02 4 0 -8 " + second + "\n");
        const Capture capture = list();
        ASSERT_EQ(capture.photos.size(), 1u);
        const Pose& pose = capture.photos[0].worldFromCamera;
        EXPECT_LT(glm::distance(pose.translation, glm::dvec3(1, 0, -2)), 1e-9);
        const double angle = 3.14159265358979 / 8;
        EXPECT_LT(glm::distance(pose.rotation * glm::dvec3(1, 0, 0), glm::dvec3(std::cos(angle), std::sin(angle), 0)),
                  1e-6);
    }
}

TEST_F(TumRgbd, BadLinesAreNamed) {
    const auto refuse = [&](const char* file, const std::string& text, const std::string& words) {
        const std::string before = bytesOfFile(folder_ / file);
        write(file, text);
        expectRefused(words);
        expectRefused(file);
        write(file, before);
    };
    refuse("rgb.txt", "1.0 rgb/1.png\n2.0\n", "line 2: has no file name");
    refuse("rgb.txt", "one rgb/1.png\n", "line 1: 'one' is not a number");
    refuse("depth.txt", "\n# x\nnan depth/1.png\n", "line 3: 'nan' is not a number");
    refuse("depth.txt", "1e999 depth/1.png\n", "line 1: '1e999' is not a number");
    refuse("groundtruth.txt", "1 0 0 0 0 0 0\n", "line 1: is not a pose");
    refuse("groundtruth.txt", "1 0 0 0 0 0 0 0\n", "line 1: quaternion is not of length 1");
    refuse("groundtruth.txt", "1 0 0 0 0 0 0 9\n", "line 1: quaternion is not of length 1");
    refuse("groundtruth.txt", "1 0 inf 0 0 0 0 1\n", "line 1: 'inf' is not a number");
    refuse("intrinsics.txt", "30 31 19.5\n", "fewer than four numbers");
    refuse("intrinsics.txt", "30 31 19.5 x\n", "line 1: 'x' is not a number");
    refuse("intrinsics.txt", "0 31 19.5 14.5\n", "focal length");
    refuse("intrinsics.txt", "30 -31 19.5 14.5\n", "focal length");
    write("rgb.txt", "1.00 rgb/1.png\r\n");
    EXPECT_EQ(list().photos.size(), 1u) << "lines may end as on Windows";
}

TEST_F(TumRgbd, MissingListsAndPicturesAreNamed) {
    for (const char* file : {"rgb.txt", "depth.txt", "groundtruth.txt"}) {
        const std::string before = bytesOfFile(folder_ / file);
        std::filesystem::remove(folder_ / file);
        expectRefused(file);
        write(file, "");
        expectRefused("within 20 ms");
        write(file, before);
    }
    write("rgb.txt", "1.00 rgb/none.png\n");
    expectRefused("none.png");
    // A header that claims more pixels than OpenCV reads.
    write("rgb/1.png", "P6\n100000 100000\n255\nabc");
    write("rgb.txt", "1.00 rgb/1.png\n");
    expectRefused("1.png");
}

TEST_F(TumRgbd, KnownCamerasAreTakenByTheFoldersNameWithARemark) {
    std::filesystem::remove(folder_ / "intrinsics.txt");
    expectRefused("has no intrinsics.txt, and what is usual is of pictures of 640x480, not 40x30");
    writePicture(folder_ / "rgb/1.png", gradientPicture(640, 480));
    writePicture(folder_ / "depth/1.png", flatDepth(640, 480, 10000));
    Capture capture = list();
    EXPECT_EQ(capture.photos[0].camera.fx, 525.0);
    ASSERT_EQ(capture.remarks.size(), 1u);
    const auto named = folder_ / "rgbd_dataset_freiburg3_office";
    std::filesystem::create_directory(named);
    for (const char* name : {"rgb", "depth", "rgb.txt", "depth.txt", "groundtruth.txt"})
        std::filesystem::rename(folder_ / name, named / name);
    capture = {};
    listTumRgbd(named, capture);
    EXPECT_EQ(capture.photos[0].camera.fy, 539.2);
    EXPECT_EQ(capture.photos[0].camera.cx, 320.6);
    EXPECT_NE(capture.remarks.at(0).find("freiburg3"), std::string::npos);
}

TEST_F(TumRgbd, OpenCaptureNamesWhatItDoesNotKnow) {
    const auto refuse = [&](const std::filesystem::path& input, const std::string& words) {
        const std::filesystem::path inputs[] = {input};
        const std::string message = failureOf<Failure>([&] { openCapture(inputs); });
        EXPECT_EQ(message.find(input.string()), 0u) << "'" << message << "'";
        EXPECT_NE(message.find(words), std::string::npos) << "'" << message << "' does not say '" << words << "'";
    };
    refuse(folder_ / "gone", "no such file or folder");
    refuse(folder_ / "rgb", "no capture that Revisit knows");
    refuse(folder_ / "rgb.txt", "format .txt is not known");
    write("noending", "x");
    refuse(folder_ / "noending", "without an extension");
    std::filesystem::create_directory(folder_ / "rgb/transforms.json");
    const std::filesystem::path inputs[] = {folder_ / "rgb"};
    EXPECT_NE(failureOf<Failure>([&] { openCapture(inputs); }).find("transforms.json"), std::string::npos)
        << "a folder by that name";
}

} // namespace
} // namespace scene
