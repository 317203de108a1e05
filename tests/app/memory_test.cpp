// A scene that may take less memory than it is large, or of which something was damaged, drawn by the program.

#include "tests/app/comparison.h"
#include "tests/app/made_sample.h"
#include "tests/app/program.h"
#include "tests/scene/scratch_folder.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <opencv2/imgcodecs.hpp>

#include <algorithm>
#include <fstream>

namespace app {

namespace {

class MemoryOfScene : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        scratch_ = new scene::ScratchFolder;
        const Outcome made =
            makeSample({path("capture"), "--scene", "room", "--images", "10", "--size", "320x240"}, folder());
        ASSERT_EQ(made.status, 0) << made.output;
        const Outcome built =
            run({kRevisit, "build", path("capture"), "-o", path("room.revisit"), "--hold-out", "every:5:2"}, folder());
        ASSERT_EQ(built.status, 0) << built.output;
    }
    static void TearDownTestSuite() { delete scratch_; }

    static std::filesystem::path folder() { return scratch_->path(); }
    static std::string path(const std::string& name) { return (folder() / name).string(); }

    static Outcome render(const std::string& scene, const std::string& out, std::vector<std::string> further = {}) {
        std::vector<std::string> command{kRevisit, "render", path(scene), "--out", path(out), "--aux"};
        command.insert(command.end(), further.begin(), further.end());
        return run(command, folder());
    }

    /// Pictures by name.
    static std::vector<cv::Mat> picturesIn(const std::string& out, const std::string& ending) {
        std::vector<std::filesystem::path> files;
        for (const auto& entry : std::filesystem::directory_iterator(path(out)))
            if (entry.path().string().ends_with(ending)) files.push_back(entry.path());
        std::sort(files.begin(), files.end());
        std::vector<cv::Mat> pictures;
        for (const auto& file : files)
            pictures.push_back(cv::imread(file.string(), cv::IMREAD_UNCHANGED));
        return pictures;
    }

  private:
    static inline scene::ScratchFolder* scratch_ = nullptr;
};

TEST_F(MemoryOfScene, OfADeviceWithLittleRoomNoMoreIsTakenThanItSays) {
    const auto reportOf = [&](const std::string& out) { return readJson(path(out) + "/report.json"); };
    ASSERT_EQ(render("room.revisit", "roomy").status, 0);
    const auto whole = reportOf("roomy").at("bytes_resident").get<std::uint64_t>();
    EXPECT_FALSE(reportOf("roomy").contains("stream"));
    const std::string room = "REVISIT_FAULT_ROOM=" + std::to_string(whole);
    const Outcome drawn =
        run({"/usr/bin/env", "VK_LAYER_PATH=" REVISIT_FAULTY_LAYER, "VK_INSTANCE_LAYERS=VK_LAYER_REVISIT_faulty", room,
             kRevisit, "render", path("room.revisit"), "--out", path("narrow"), "--aux"},
            folder());
    ASSERT_EQ(drawn.status, 0) << drawn.output;
    EXPECT_TRUE(reportOf("narrow").contains("stream")) << "a part of the scene at a time";
    EXPECT_LE(reportOf("narrow").at("bytes_resident").get<std::uint64_t>(), whole / 4 * 3);
    EXPECT_EQ(picturesIn("narrow", ".png").size(), picturesIn("roomy", ".png").size());
}

TEST_F(MemoryOfScene, LessThanAllIsEnoughAndDrawsTheSameTwice) {
    ASSERT_EQ(render("room.revisit", "whole").status, 0);
    const nlohmann::json whole = readJson(path("whole/report.json"));
    EXPECT_FALSE(whole.contains("stream"));
    for (const char* out : {"less", "again"}) {
        const Outcome drawn = render("room.revisit", out, {"--memory", "4M"});
        ASSERT_EQ(drawn.status, 0) << drawn.output;
    }
    const nlohmann::json less = readJson(path("less/report.json"));
    EXPECT_LE(less.at("bytes_resident"), 4 << 20);
    EXPECT_GT(whole.at("bytes_resident"), 8 << 20);
    EXPECT_GT(less.at("stream").at("chunks_loaded"), 0);
    const auto classes = picturesIn("less", "-class.png"), all = picturesIn("whole", "-class.png");
    ASSERT_EQ(classes.size(), 2u);
    for (std::size_t i = 0; i < classes.size(); ++i) {
        const cv::Mat vanished = (classes[i] == 0) & (all[i] != 0);
        EXPECT_LE(cv::countNonZero(vanished), 1e-3 * static_cast<double>(vanished.total())) << "nothing vanishes";
    }
    const auto first = picturesIn("less", ".png"), second = picturesIn("again", ".png");
    for (std::size_t i = 0; i < first.size(); ++i)
        EXPECT_EQ(cv::norm(first[i], second[i], cv::NORM_INF), 0);
}

TEST_F(MemoryOfScene, TooLittleIsRefusedInALine) {
    const Outcome drawn = render("room.revisit", "none", {"--memory", "1M"});
    EXPECT_EQ(drawn.status, 1);
    EXPECT_NE(drawn.output.find("--memory"), std::string::npos) << drawn.output;
    EXPECT_EQ(std::count(drawn.output.begin(), drawn.output.end(), '\n'), 1) << drawn.output;
}

TEST_F(MemoryOfScene, UnseenSpaceTakesAQuarterAndImagesComeFirst) {
    const Outcome built =
        run({kRevisit, "build", path("capture"), "-o", path("seen.revisit"), "--hold-out", "every:5:2", "--coverage"},
            folder());
    ASSERT_EQ(built.status, 0) << built.output;
    constexpr std::size_t kMiB = 1 << 20;
    const auto reportWith = [&](double mebibytes, std::string& says) {
        const std::string memory = nlohmann::json(mebibytes).dump() + "M";
        const Outcome drawn = render("seen.revisit", "part", {"--memory", memory});
        EXPECT_EQ(drawn.status, 0) << drawn.output;
        says = drawn.output;
        return readJson(path("part/report.json"));
    };
    std::string says;
    const nlohmann::json all = reportWith(8192, says);
    EXPECT_EQ(says.find("told by cells"), std::string::npos) << says;
    // A quarter that is too little for all of it, and enough for its coarsest form.
    const std::size_t little = all.at("coverage").at("bytes").get<std::size_t>() / kMiB * 4;
    const nlohmann::json part = reportWith(static_cast<double>(little), says);
    EXPECT_NE(says.find("told by cells"), std::string::npos) << says;
    EXPECT_LT(part.at("coverage").at("bytes"), all.at("coverage").at("bytes"));
    EXPECT_LE(part.at("coverage").at("bytes"), little * kMiB / 4);
    EXPECT_LE(part.at("bytes_resident").get<std::size_t>() + part.at("coverage").at("bytes").get<std::size_t>(),
              little * kMiB);
    // Its coarsest form is shown even beyond its quarter, and what is left is for images.
    const nlohmann::json beyond = reportWith(6, says);
    EXPECT_GT(beyond.at("coverage").at("bytes"), 6 * kMiB / 4);
    EXPECT_LE(beyond.at("bytes_resident"), 6 * kMiB * 3 / 4);
    // Where images need all of it, they have all.
    const Outcome none = render("seen.revisit", "part", {"--memory", "1M"});
    EXPECT_EQ(none.status, 1);
    const std::string needs = "needs at least ";
    ASSERT_NE(none.output.find(needs), std::string::npos) << none.output;
    const double least = std::stod(none.output.substr(none.output.find(needs) + needs.size()));
    EXPECT_GT(least, 1) << "more than it had";
    const nlohmann::json tight = reportWith(least, says);
    EXPECT_EQ(tight.at("coverage").at("levels"), 4);
    EXPECT_LE(tight.at("bytes_resident").get<double>(), least * kMiB);
    EXPECT_NE(says.find(needs), std::string::npos) << "why cells are coarse:\n" << says;
}

TEST_F(MemoryOfScene, WhatIsDamagedIsToldOnceAndTheRestIsDrawn) {
    ASSERT_EQ(render("room.revisit", "sound").status, 0);
    std::filesystem::copy(path("room.revisit"), path("hurt.revisit"), std::filesystem::copy_options::recursive);
    const std::string tiles = path("hurt.revisit/tiles.bin");
    const auto size = static_cast<std::streamoff>(std::filesystem::file_size(tiles));
    std::fstream file(tiles, std::ios::binary | std::ios::in | std::ios::out);
    file.seekp(size / 2);
    file.write("vandals were here", 17);
    file.close();
    const Outcome drawn = render("hurt.revisit", "hurt");
    EXPECT_EQ(drawn.status, 0) << drawn.output;
    const std::string says = "tiles.bin: what image ";
    const auto at = drawn.output.find(says);
    ASSERT_NE(at, std::string::npos) << drawn.output;
    EXPECT_EQ(drawn.output.find(says, at + 1), std::string::npos) << "once:\n" << drawn.output;
    EXPECT_NE(drawn.output.find("drawn as unseen"), std::string::npos) << drawn.output;
    EXPECT_EQ(readJson(path("hurt/report.json")).at("damaged_chunks"), 1);
    const auto hurt = picturesIn("hurt", "-class.png"), sound = picturesIn("sound", "-class.png");
    for (std::size_t i = 0; i < hurt.size(); ++i) {
        const cv::Mat lost = (hurt[i] == 0) & (sound[i] != 0);
        EXPECT_LE(cv::countNonZero(lost), 0.01 * static_cast<double>(lost.total())) << "not shown as emptiness";
    }

    // Where the head of an image's block is hurt, nothing of that image is left, but the others are.
    std::fstream head(tiles, std::ios::binary | std::ios::in | std::ios::out);
    constexpr std::streamoff kFirstEntry = 64; // scene/scene_file.h
    std::uint64_t block = 0;
    head.seekg(kFirstEntry);
    head.read(reinterpret_cast<char*>(&block), sizeof block);
    head.seekp(static_cast<std::streamoff>(block) + 5);
    head.write("vandals", 7);
    head.close();
    const Outcome headless = render("hurt.revisit", "hurt-head");
    EXPECT_EQ(headless.status, 0) << headless.output;
    const std::string first = readJson(path("hurt.revisit/scene.json")).at("images").at(0).at("name");
    EXPECT_NE(headless.output.find("tiles.bin: nothing of image " + first + " can be read"), std::string::npos)
        << headless.output;
    const Outcome told = run({kRevisit, "info", path("hurt.revisit")}, folder());
    EXPECT_EQ(told.status, 1);
    EXPECT_NE(told.output.find("damaged block (" + first + ")"), std::string::npos) << told.output;
}

} // namespace
} // namespace app
