// `revisit measure` on a small room: its figures are those of the pictures that `render` writes.

#include "tests/app/comparison.h"
#include "tests/app/made_sample.h"
#include "tests/app/program.h"
#include "tests/scene/scratch_folder.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include <algorithm>
#include <fstream>

namespace app {

namespace {

using nlohmann::json;

class Measure : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        scratch_ = new scene::ScratchFolder;
        const Outcome made =
            makeSample({path("capture"), "--scene", "room", "--images", "10", "--size", "160x120"}, folder());
        ASSERT_EQ(made.status, 0) << made.output;
        const Outcome built =
            run({kRevisit, "build", path("capture"), "-o", scene(), "--hold-out", "every:5:2"}, folder());
        ASSERT_EQ(built.status, 0) << built.output;
    }
    static void TearDownTestSuite() { delete scratch_; }

    static std::filesystem::path folder() { return scratch_->path(); }
    static std::string path(const std::string& name) { return (folder() / name).string(); }
    static std::string scene() { return path("room.revisit"); }
    static Outcome measure(const std::string& out, std::vector<std::string> options) {
        std::vector<std::string> command{kRevisit, "measure", scene(),    "--out", path(out),
                                         "--size", "80x60",   "--frames", "4"};
        command.insert(command.end(), options.begin(), options.end());
        return run(command, folder());
    }
    static json settingOf(const json& report, const std::string& name) {
        for (const json& setting : report.at("settings"))
            if (setting.at("name") == name) return setting;
        ADD_FAILURE() << "no setting " << name;
        return {};
    }

  private:
    static inline scene::ScratchFolder* scratch_ = nullptr;
};

TEST_F(Measure, SaysOfEachSettingWhatItsPicturesSay) {
    const Outcome measured = measure("swept", {"--sweep", "warp,resolution_scale"});
    ASSERT_EQ(measured.status, 0) << measured.output;
    const json report = readJson(path("swept/report.json"));
    EXPECT_EQ(report.at("frames"), 4);
    EXPECT_EQ(report.at("pictures"), 2);
    ASSERT_GE(report.at("settings").size(), 7u) << "three presets, and the knobs one at a time";
    EXPECT_GE(report.at("governor_rungs").size(), 2u);

    // The settings that were measured, given to render again, make the pictures that were compared.
    const json heldOut = readJson(scene() + "/scene.json").at("held_out");
    for (const std::string name : {"balanced", "best", "resolution_scale=0.5"}) {
        const json setting = settingOf(report, name);
        std::ofstream(path("quality.json")) << setting.at("quality");
        const Outcome drawn =
            run({kRevisit, "render", scene(), "--out", path("frames"), "--aux", "--quality", path("quality.json")},
                folder());
        ASSERT_EQ(drawn.status, 0) << drawn.output;
        const Agreement agreement = compareHeldOut(scene(), path("frames"), [](const std::string& camera) {
            return std::filesystem::path(path("capture/images/" + camera + ".png"));
        });
        EXPECT_NEAR(setting.at("psnr_seen_db").get<double>(), agreement.meanPsnr, 1e-6) << name;
        EXPECT_GT(setting.at("psnr_covered_db"), 18);
        EXPECT_GT(setting.at("ssim"), 0.5);
        EXPECT_LT(setting.at("ssim"), 1);
        EXPECT_LT(setting.at("hole_share"), 0.5);
        EXPECT_LE(setting.at("unseen_share"), setting.at("hole_share"));
        EXPECT_LT(setting.at("wrongly_solid_share"), 0.1);
        EXPECT_GT(setting.at("frame_ms").at("median"), 0);
        EXPECT_GE(setting.at("frame_ms").at("p99"), setting.at("frame_ms").at("median"));
        EXPECT_GT(setting.at("tiles_tested").at("median"), setting.at("tiles_rejected").at("median"));
        EXPECT_EQ(setting.at("pictures").size(), heldOut.size());
        const std::string worst = path("swept/worst-" + (name[0] == 'r' ? "resolution_scale-0.5" : name) + ".png");
        EXPECT_EQ(cv::imread(worst).size(), cv::Size(320, 120)) << worst;
    }

    // Whatever is on the front: nothing is faster and better.
    int onFront = 0;
    for (const json& a : report.at("settings")) {
        bool isBeaten = false;
        for (const json& b : report.at("settings"))
            isBeaten |=
                b["frame_ms"]["median"] < a["frame_ms"]["median"] && b["psnr_covered_db"] > a["psnr_covered_db"];
        EXPECT_FALSE(isBeaten && a.at("is_on_front").get<bool>()) << a.at("name");
        onFront += a.at("is_on_front").get<bool>() ? 1 : 0;
    }
    EXPECT_GE(onFront, 1);
    const std::string table = scene::bytesOfFile(path("swept/table.md"));
    for (const json& setting : report.at("settings"))
        EXPECT_NE(table.find("| " + setting.at("name").get<std::string>() + " |"), std::string::npos);
    EXPECT_NE(measured.output.find(table), std::string::npos) << "what is written is printed, too";
}

TEST_F(Measure, TakesCamerasWithTheirPicturesBesideThem) {
    // What render --aux writes is truth for measure: the same setting then has nothing wrong.
    ASSERT_EQ(run({kRevisit, "render", scene(), "--out", path("beside"), "--aux", "--warp", "mesh"}, folder()).status,
              0);
    std::ofstream(path("beside/cameras.json")) << json{{"cameras", readJson(scene() + "/scene.json").at("held_out")}};
    std::ofstream(path("settings.json"))
        << R"({"settings": [{"name": "same", "warp": "mesh"}, {"name": "other/one", "warp": "points"}]})";
    const Outcome measured = measure(
        "besides", {"--cameras", path("beside/cameras.json"), "--settings", path("settings.json"), "--threads", "1"});
    ASSERT_EQ(measured.status, 0) << measured.output;
    const json report = readJson(path("besides/report.json"));
    ASSERT_EQ(report.at("settings").size(), 2u);
    const json same = settingOf(report, "same"), other = settingOf(report, "other/one");
    EXPECT_EQ(same.at("psnr_all_db"), 100);
    EXPECT_NEAR(same.at("ssim").get<double>(), 1, 1e-9);
    EXPECT_EQ(same.at("hole_share"), 0);
    EXPECT_EQ(same.at("wrongly_solid_share"), 0);
    EXPECT_LT(other.at("psnr_all_db"), 60);
    EXPECT_TRUE(std::filesystem::exists(path("besides/worst-other-one.png")));

    // What the next run does not measure goes, and nothing else.
    std::ofstream(path("besides/worst-day.png")) << "of another hand";
    std::ofstream(path("settings.json")) << R"({"settings": [{"name": "same", "warp": "mesh"}]})";
    ASSERT_EQ(
        measure("besides", {"--cameras", path("beside/cameras.json"), "--settings", path("settings.json")}).status, 0);
    EXPECT_FALSE(std::filesystem::exists(path("besides/worst-other-one.png")));
    EXPECT_TRUE(std::filesystem::exists(path("besides/worst-same.png")));
    EXPECT_TRUE(std::filesystem::exists(path("besides/worst-day.png")));
}

TEST_F(Measure, RefusesInOneLine) {
    std::ofstream(path("unknown.json")) << R"({"wrap": "mesh"})";
    std::ofstream(path("range.json")) << R"({"settings": [{"name": "a", "max_footprint": 1000}]})";
    std::ofstream(path("shared.json")) << R"({"settings": [{"name": "a/b"}, {"name": "a-b"}]})";
    std::ofstream(path("broken.json")) << R"({"warp": )";
    json lonely{{"cameras", readJson(scene() + "/scene.json").at("held_out")}};
    lonely["cameras"][0]["name"] = "nobody";
    std::ofstream(path("lonely.json")) << lonely;
    const std::string untaught = path("untaught.revisit");
    std::filesystem::copy(scene(), untaught, std::filesystem::copy_options::recursive);
    std::filesystem::remove_all(untaught + "/held_out");

    struct Case {
        std::vector<std::string> command;
        int status;
        const char* says;
    };
    const std::vector<Case> cases{
        {{"--quality", path("unknown.json")}, 1, "wrap"},
        {{"--quality", path("broken.json")}, 1, "broken.json"},
        {{"--quality", path("nothing.json")}, 1, "neither a preset nor a file"},
        {{"--settings", path("range.json")}, 1, "a whole number of 1 to 64"},
        {{"--settings", path("shared.json")}, 1, "would be the picture of two settings"},
        {{"--sweep", "colour"}, 1, "resolution_scale"},
        {{"--cameras", path("lonely.json")}, 1, "nobody"},
        {{"--max-footprint", "0"}, 2, "1 to 64"},
        {{"--warp", "lines"}, 2, "mesh"},
        {{"--frames", "0"}, 2, "frames"},
        {{"--sweep", "warp", "--settings", path("range.json")}, 2, "excludes"},
    };
    for (const Case& c : cases) {
        const Outcome outcome = measure("refused", c.command);
        EXPECT_EQ(outcome.status, c.status) << c.command[1] << "\n" << outcome.output;
        EXPECT_NE(outcome.output.find(c.says), std::string::npos) << outcome.output;
        if (c.status != 1) continue;
        EXPECT_EQ(std::count(outcome.output.begin(), outcome.output.end(), '\n'), 1) << outcome.output;
    }
    const Outcome blind = run({kRevisit, "measure", untaught, "--out", path("refused")}, folder());
    EXPECT_EQ(blind.status, 1);
    EXPECT_NE(blind.output.find("build the scene again"), std::string::npos) << blind.output;
}

TEST_F(Measure, ARateThatCannotBeHeldCostsQualityAndIsReported) {
    json walk = readJson(path("capture/walk.json"));
    constexpr std::size_t kPoses = 3;
    ASSERT_GE(walk["poses"].size(), kPoses);
    walk["poses"].erase(walk["poses"].begin() + kPoses, walk["poses"].end());
    for (std::size_t i = 0; i < kPoses; ++i)
        walk["poses"][i]["t"] = 0.02 * static_cast<double>(i);
    std::ofstream(path("walk.json")) << walk;
    const auto report = [&](const std::string& out, const std::string& how) {
        const Outcome walked = run({kRevisit, "walk", scene(), "--headless", "--path", path("walk.json"), "--rate",
                                    "1000", how, "--quality", "best", "--size", "640x480", "--out", path(out)},
                                   folder());
        EXPECT_EQ(walked.status, 0) << walked.output;
        return readJson(path(out) + "/report.json");
    };
    // A millisecond for two eyes of 640x480 is more than a processor can hold; where it is held nothing may change.
    const json held = report("held", "--hold-rate");
    EXPECT_EQ(held.at("width"), 640);
    EXPECT_EQ(held.at("height"), 480);
    ASSERT_TRUE(held.contains("governor"));
    const json governor = held.at("governor");
    EXPECT_EQ(governor.at("rate_hz"), 1000);
    std::uint64_t frames = 0;
    for (const json& rung : governor.at("rungs"))
        frames += rung.at("frames").get<std::uint64_t>();
    EXPECT_EQ(frames, held.at("frames"));
    const bool isTooMuch = held.at("gpu_ms").contains("frame") && held["gpu_ms"]["frame"]["median"] > 1;
    EXPECT_GE(governor.at("changes").size(), isTooMuch ? 1u : 0u);
    EXPECT_FALSE(report("fixed", "--fixed-quality").contains("governor"));
}

} // namespace

} // namespace app
