// Instruments that are a little off, as a user meets them: calibrated by the program, and taken account of by builds;
// and exposures that drift.

#include "scene/pose.h"

#include "tests/app/comparison.h"
#include "tests/app/made_sample.h"
#include "tests/app/program.h"
#include "tests/scene/scratch_folder.h"

#include <cmath>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

namespace app {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class Instruments : public testing::Test {
  protected:
    std::filesystem::path folder() const { return scratch_.path(); }
    std::string path(const std::string& name) const { return (folder() / name).string(); }
    Outcome revisit(std::vector<std::string> arguments) const {
        arguments.insert(arguments.begin(), kRevisit);
        return run(arguments, folder());
    }
    Outcome sample(const std::vector<std::string>& arguments) const { return makeSample(arguments, folder()); }

  private:
    scene::ScratchFolder scratch_;
};

TEST_F(Instruments, AScannersConstantsAreFoundAndItsScansReadAnewWithThem) {
    const Outcome made = sample({path("walls"), "--scene", "room", "--scanner", "--scans", "1", "--density", "2",
                                 "--both-faces", "--wrong-constants", "--no-colour"});
    ASSERT_EQ(made.status, 0) << made.output;
    const Outcome found = revisit({"calibrate", "scanner", path("walls/scans.e57"), "-o", path("scanner.json")});
    ASSERT_EQ(found.status, 0) << found.output;
    EXPECT_THAT(found.output, HasSubstr("steps in half a turn"));
    const json truth = readJson(path("walls/truth.json")).at("constants").at("true"),
               constants = readJson(path("scanner.json")).at("constants");
    EXPECT_NEAR(constants.at("pan_steps_per_half_turn"), truth.at("pan_steps_per_half_turn").get<double>(), 1);
    EXPECT_NEAR(constants.at("mirror_deg"), truth.at("mirror_deg").get<double>(), 0.005);

    // Wrong constants part what the two faces saw of a wall; the right ones lay it on itself again.
    const auto samplesOf = [&](const std::vector<std::string>& more) {
        std::vector<std::string> command{"build", path("walls/scans.e57"), "-o", path("room.revisit")};
        command.insert(command.end(), more.begin(), more.end());
        const Outcome built = revisit(command);
        EXPECT_EQ(built.status, 0) << built.output;
        return readJson(path("room.revisit/scene.json")).at("figures").at("samples").get<double>();
    };
    const double asWritten = samplesOf({}), anew = samplesOf({"--scanner", path("scanner.json")});
    EXPECT_LT(anew, 0.95 * asWritten); // further images of a face hold what stands before or behind its surfaces
    const json scan = readJson(path("room.revisit/scene.json"));
    EXPECT_EQ(scan.at("options").at("scanner"), path("scanner.json"));
}

TEST_F(Instruments, FilesThatAreNoneAreRefusedInOneLine) {
    std::ofstream(path("empty.json")) << "{}";
    std::ofstream(path("odd.json")) << R"({"believed": {"pan_steps_per_half_turn": 14000, "mirror_deg": 85}})";
    ASSERT_EQ(sample({path("walls"), "--scene", "room", "--scanner", "--scans", "1", "--density", "0.5"}).status, 0);
    const std::string scans = path("walls/scans.e57"), out = path("x.revisit");
    const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
        {{"build", scans, "-o", out, "--scanner", path("empty.json")}, "has no \"believed\" constants"},
        {{"build", scans, "-o", out, "--scanner", path("odd.json")}, "has no \"mirror_deg\" that a scanner could have"},
        {{"build", scans, "-o", out, "--scanner", path("nowhere.json")}, "no such file"},
        {{"calibrate", "scanner", scans, "-o", path("x.json")}, "fewer than six planes"},
        {{"calibrate", "camera", path("nowhere"), "-o", path("c.json")}, "is not there"},
        {{"calibrate", "camera", path("empty.json"), "-o", path("c.json")}, "cannot be read as a picture"},
    };
    for (const auto& [command, says] : cases) {
        const Outcome outcome = revisit(command);
        EXPECT_EQ(outcome.status, 1) << testing::PrintToString(command) << outcome.output;
        EXPECT_THAT(outcome.output, HasSubstr(says));
    }
    EXPECT_FALSE(std::filesystem::exists(out));
    EXPECT_FALSE(std::filesystem::exists(path("c.json")));
}

TEST_F(Instruments, ExposuresThatDriftAreMadeEvenWhereAsked) {
    ASSERT_EQ(sample({path("capture"), "--scene", "room", "--images", "16", "--size", "160x120"}).status, 0);
    const auto evened = [&](const std::string& scene) {
        const Outcome built = revisit({"build", path("capture"), "-o", path(scene), "--colour-even"});
        EXPECT_EQ(built.status, 0) << built.output;
        return readJson(path(scene) + "/scene.json").at("colour_evening");
    };
    const json even = evened("even.revisit");
    EXPECT_LT(even.at("most_stops"), 0.03);
    int number = 0;
    for (const auto& entry : std::filesystem::directory_iterator(path("capture/images"))) {
        cv::Mat picture = cv::imread(entry.path().string());
        ASSERT_FALSE(picture.empty());
        // sRGB is about a power of 2.2: half a stop up or down.
        picture.convertTo(picture, -1, std::exp2((number++ % 3 - 1) * 0.5 / 2.2));
        cv::imwrite(entry.path().string(), picture);
    }
    const json uneven = evened("uneven.revisit");
    EXPECT_GT(uneven.at("seam_before"), 0.2);
    EXPECT_LT(uneven.at("seam_after").get<double>(), uneven.at("seam_before").get<double>() / 5);
    EXPECT_THAT(revisit({"info", path("uneven.revisit")}).output, HasSubstr("made even: across"));
    ASSERT_EQ(revisit({"build", path("capture"), "-o", path("as.revisit")}).status, 0);
    EXPECT_TRUE(readJson(path("as.revisit/scene.json")).at("colour_evening").is_null());
}

} // namespace
} // namespace app
