// A capture of one image, drawn from where it was taken: it must be that image again.

#include "tests/app/comparison.h"
#include "tests/app/program.h"
#include "tests/scene/scratch_folder.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include <cstdio>
#include <fstream>

namespace app {

namespace {

TEST(Itself, AnImageFromItsOwnPlaceIsThatImage) {
    const scene::ScratchFolder scratch;
    const std::filesystem::path capture = scratch / "capture", scene = scratch / "one.revisit",
                                frames = scratch / "frames";
    const Outcome made =
        run({kMakeSample, capture.string(), "--scene", "room", "--images", "1", "--size", "640x480"}, scratch.path());
    ASSERT_EQ(made.status, 0) << made.output;
    const Outcome built = run({kRevisit, "build", capture.string(), "-o", scene.string()}, scratch.path());
    ASSERT_EQ(built.status, 0) << built.output;

    const nlohmann::json images = readJson(scene / "scene.json").at("images");
    ASSERT_EQ(images.size(), 1u);
    std::ofstream(scratch / "cameras.json") << nlohmann::json{{"cameras", images}};
    const Outcome drawn = run({kRevisit, "render", scene.string(), "--out", frames.string(), "--cameras",
                               (scratch / "cameras.json").string(), "--warp", "points", "--eyes", "1", "--aux"},
                              scratch.path());
    ASSERT_EQ(drawn.status, 0) << drawn.output;

    const std::string name = images[0].at("name");
    const cv::Mat3b picture = cv::imread((frames / (name + ".png")).string(), cv::IMREAD_COLOR),
                    truth = cv::imread((capture / "images" / (name + ".png")).string(), cv::IMREAD_COLOR);
    const cv::Mat1b pixelClass = cv::imread((frames / (name + "-class.png")).string(), cv::IMREAD_UNCHANGED);
    const cv::Mat1w range = cv::imread((capture / "depth" / (name + ".png")).string(), cv::IMREAD_UNCHANGED);
    ASSERT_EQ(truth.size(), cv::Size(640, 480));
    ASSERT_EQ(picture.size(), truth.size());
    ASSERT_EQ(pixelClass.size(), truth.size());
    int seen = 0, same = 0;
    for (int y = 0; y < truth.rows; ++y)
        for (int x = 0; x < truth.cols; ++x) {
            if (pixelClass(y, x) != 1) continue;
            ++seen;
            if (picture(y, x) == truth(y, x)) ++same;
        }
    std::printf("itself: %d pixels with range, %d seen, %d the same\n", cv::countNonZero(range), seen, same);
    EXPECT_GE(seen, 0.999 * cv::countNonZero(range)) << "every sample must come back";
    EXPECT_GE(same, 0.999 * seen);
}

} // namespace

} // namespace app
