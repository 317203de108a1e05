// From a capture to stereo frames with the built programs; and what happens when they are killed or given rubbish.

#include "tests/app/comparison.h"
#include "tests/app/made_sample.h"
#include "tests/app/program.h"
#include "tests/scene/scratch_folder.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <opencv2/imgcodecs.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <fstream>

#include <unistd.h>

namespace app {

namespace {

/// A small capture, made once for all tests of the program.
class Walk : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        scratch_ = new scene::ScratchFolder;
        const Outcome made =
            makeSample({capture(), "--scene", "room", "--images", "10", "--size", "160x120"}, folder());
        ASSERT_EQ(made.status, 0) << made.output;
        const Outcome built =
            run({kRevisit, "build", capture(), "-o", path("room.revisit"), "--hold-out", "every:5:2"}, folder());
        ASSERT_EQ(built.status, 0) << built.output;
    }
    static void TearDownTestSuite() { delete scratch_; }

    static std::filesystem::path folder() { return scratch_->path(); }
    static std::string path(const std::string& name) { return (folder() / name).string(); }
    static std::string capture() { return path("capture"); }

  private:
    static inline scene::ScratchFolder* scratch_ = nullptr;
};

TEST_F(Walk, HeldOutViewsComeBackByBothWarps) {
    for (const std::string warp : {"points", "mesh"}) {
        const std::string out = path("held-" + warp);
        const Outcome drawn =
            run({kRevisit, "render", path("room.revisit"), "--out", out, "--aux", "--warp", warp}, folder());
        ASSERT_EQ(drawn.status, 0) << drawn.output;
        const nlohmann::json report = readJson(out + "/report.json");
        EXPECT_EQ(report.at("frames"), 2);
        EXPECT_GT(report.at("samples_drawn").at("median"), 1000);
        const nlohmann::json scene = readJson(path("room.revisit") + "/scene.json");
        ASSERT_EQ(scene.at("held_out").size(), 2u);
        for (const auto& camera : scene.at("held_out")) {
            const std::string name = camera.at("name");
            const cv::Mat3b drawnPicture = cv::imread(out + "/" + name + ".png", cv::IMREAD_COLOR);
            cv::Mat3b truth;
            for (const char* extension : {".png", ".jpg"})
                if (truth.empty()) truth = cv::imread(capture() + "/images/" + name + extension, cv::IMREAD_COLOR);
            const cv::Mat1b seen = cv::imread(out + "/" + name + "-class.png", cv::IMREAD_UNCHANGED);
            ASSERT_FALSE(drawnPicture.empty() || truth.empty() || seen.empty()) << name;
            EXPECT_GT(cv::countNonZero(seen), seen.rows * seen.cols / 3) << name << " by " << warp;
            EXPECT_GT(psnr(drawnPicture, truth, seen), 18) << name << " by " << warp;
        }
    }
}

TEST_F(Walk, StereoFramesHaveTheRightParallax) {
    const std::string out = path("stereo");
    nlohmann::json walk = readJson(capture() + "/walk.json");
    walk["poses"].erase(walk["poses"].begin() + 2, walk["poses"].end());
    std::ofstream(path("still.json")) << walk.dump();
    const Outcome drawn = run({kRevisit, "render", path("room.revisit"), "--out", out, "--path", path("still.json"),
                               "--size", "160x120", "--aux"},
                              folder());
    ASSERT_EQ(drawn.status, 0) << drawn.output;
    const cv::Mat1f left = cv::imread(out + "/pose-0000-left-depth.tiff", cv::IMREAD_UNCHANGED);
    const cv::Mat3b leftColour = cv::imread(out + "/pose-0000-left.png"),
                    rightColour = cv::imread(out + "/pose-0000-right.png");
    ASSERT_FALSE(left.empty() || leftColour.empty() || rightColour.empty());
    // A surface at depth z stands f ipd / z pixels farther left in the right eye; with that shift the pictures agree
    // better than with the opposite one.
    const double focal = 160 / (2 * std::tan(0.6));
    double rightWay = 0, wrongWay = 0;
    int count = 0;
    for (int y = 0; y < left.rows; ++y)
        for (int x = 20; x < left.cols - 20; ++x) {
            if (!(left(y, x) > 0) || !std::isfinite(left(y, x))) continue;
            const int shift = static_cast<int>(std::lround(focal * 0.063 / static_cast<double>(left(y, x))));
            if (shift < 2 || shift > 20) continue;
            ++count;
            for (int c = 0; c < 3; ++c) {
                rightWay += std::abs(leftColour(y, x)[c] - rightColour(y, x - shift)[c]);
                wrongWay += std::abs(leftColour(y, x)[c] - rightColour(y, x + shift)[c]);
            }
        }
    ASSERT_GT(count, 500);
    EXPECT_LT(rightWay, 0.7 * wrongWay);
}

TEST_F(Walk, InOnePassPicturesAreTheSameAndWhatHasNoneSaysSo) {
    const auto draw = [&](const std::string& warp, const std::string& onePass) {
        const std::string out = path("pass-" + onePass);
        std::filesystem::remove_all(out);
        const Outcome drawn =
            run({kRevisit, "render", path("room.revisit"), "--out", out, "--aux", "--path", capture() + "/walk.json",
                 "--size", "160x120", "--warp", warp, "--one-pass", onePass, "--squares-near", "false"},
                folder());
        EXPECT_EQ(drawn.status, 0) << drawn.output;
        return drawn.output;
    };
    const auto isSaid = [](const std::string& output) { return output.find("--one-pass") != std::string::npos; };
    for (const std::string warp : {"points", "splats", "mesh"}) {
        EXPECT_FALSE(isSaid(draw(warp, "false")));
        EXPECT_EQ(isSaid(draw(warp, "true")), warp == "mesh");
        const nlohmann::json report = readJson(path("pass-true") + "/report.json");
        EXPECT_EQ(report.at("frames_in_one_pass"), warp == "mesh" ? nlohmann::json(0) : report.at("frames"));
        auto apart = filesOf(path("pass-false")), together = filesOf(path("pass-true"));
        for (auto* files : {&apart, &together})
            std::erase_if(*files, [](const auto& file) { return file.first.ends_with("report.json"); });
        EXPECT_EQ(together, apart) << warp;
        EXPECT_FALSE(apart.empty());
    }
}

TEST_F(Walk, WhoIsLedSeesWhatRenderDraws) {
    nlohmann::json poses = nlohmann::json::array();
    for (int i = 0; i < 6; ++i) {
        const double half = 0.07 * i, tilt = 0.02 * i - 0.05;
        poses.push_back({{"t", i / 10.0},
                         {"position", {0.03 * i, 0.002 * i * i, 0.05 * i}},
                         {"orientation",
                          {std::cos(half) * std::sin(tilt), std::sin(half) * std::cos(tilt),
                           -std::sin(half) * std::sin(tilt), std::cos(half) * std::cos(tilt)}}});
    }
    for (const std::string space : {"walk", "world"}) {
        const std::string file = path(space + ".json"), walked = path("walked-" + space),
                          drawn = path("drawn-" + space);
        std::ofstream(file) << nlohmann::json{{"space", space}, {"poses", poses}}.dump();
        // Three frames from key to key.
        const Outcome led = run({kRevisit, "walk", path("room.revisit"), "--headless", "--path", file, "--rate", "30",
                                 "--size", "160x120", "--out", walked, "--picture-every", "3"},
                                folder());
        ASSERT_EQ(led.status, 0) << led.output;
        ASSERT_EQ(run({kRevisit, "render", path("room.revisit"), "--path", file, "--size", "160x120", "--out", drawn},
                      folder())
                      .status,
                  0);
        EXPECT_EQ(readJson(walked + "/report.json").at("frames"), 16);
        for (int i = 0; i < 6; ++i)
            for (const std::string eye : {"left", "right"}) {
                char number[16];
                std::snprintf(number, sizeof number, "%06d", 3 * i);
                EXPECT_EQ(scene::bytesOfFile(walked + "/frame-" + number + "-" + eye + ".png"),
                          scene::bytesOfFile(drawn + "/pose-000" + std::to_string(i) + "-" + eye + ".png"))
                    << "pose " << i << " in " << space;
            }
    }
    EXPECT_EQ(run({kRevisit, "walk", path("room.revisit"), "--headless"}, folder()).status, 2) << "leads nowhere";
    const Outcome late = run({kRevisit, "walk", path("room.revisit"), "--headless", "--path", path("walk.json"),
                              "--out", path("never"), "--record", path("no/walk.json")},
                             folder());
    EXPECT_EQ(late.status, 1);
    EXPECT_NE(late.output.find("no/walk.json: cannot be written"), std::string::npos) << late.output;
    EXPECT_FALSE(std::filesystem::exists(path("never/report.json"))) << "found out before the walk";
}

TEST_F(Walk, AStageThatIsDamagedIsNamedWithTheFolderToRemove) {
    const std::string scene = path("hurt.revisit"), work = scene + ".build";
    const std::vector<std::string> build{kRevisit, "build", capture(), "-o", scene, "--hold-out", "every:5:2"};
    ASSERT_EQ(run(build, folder()).status, 0);
    std::filesystem::path block;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(work))
        if (entry.path().extension() == ".block") block = entry.path();
    ASSERT_FALSE(block.empty());
    std::filesystem::resize_file(block, 100);
    std::filesystem::remove_all(scene);
    const Outcome hurt = run(build, folder());
    EXPECT_EQ(hurt.status, 1);
    EXPECT_NE(
        hurt.output.find("revisit: " + work + ": holds results of an earlier run that are damaged (" + block.string()),
        std::string::npos)
        << hurt.output;
    EXPECT_NE(hurt.output.find("remove this folder"), std::string::npos) << hurt.output;
    std::filesystem::remove_all(work);
    EXPECT_EQ(run(build, folder()).status, 0);
}

TEST_F(Walk, TheSameBytesOnOneThreadAndAfterBeingKilled) {
    const auto whole = filesOf(path("room.revisit"));
    ASSERT_FALSE(whole.empty());
    const std::string scene = path("killed.revisit");
    const std::vector<std::string> build{kRevisit,     "build",     capture(),   "-o", scene,
                                         "--hold-out", "every:5:2", "--threads", "1"};
    const auto begin = std::chrono::steady_clock::now();
    ASSERT_EQ(run(build, folder()).status, 0);
    const auto length = std::chrono::steady_clock::now() - begin;
    EXPECT_EQ(filesOf(scene), whole) << "one thread or all";

    // Killed at points spread over the build's length, each time going on from what the last left.
    std::filesystem::remove_all(scene);
    std::filesystem::remove_all(scene + ".build");
    constexpr int kKills = 20;
    int killed = 0;
    for (int i = 1; i <= kKills; ++i) {
        if (i % 5 == 0) std::filesystem::remove_all(scene + ".build");
        const pid_t process = start(build, folder() / "killed.txt");
        usleep(static_cast<useconds_t>(std::chrono::duration_cast<std::chrono::microseconds>(length).count() * i /
                                       (kKills + 1)));
        kill(process, SIGKILL);
        if (waitFor(process, folder() / "killed.txt").status == 128 + SIGKILL) ++killed;
        if (std::filesystem::exists(scene)) {
            EXPECT_EQ(filesOf(scene), whole) << "a scene under the name must be whole, after kill " << i;
            std::filesystem::remove_all(scene);
        }
    }
    EXPECT_GT(killed, kKills / 4) << "the kills must hit";
    const Outcome finished = run(build, folder());
    ASSERT_EQ(finished.status, 0) << finished.output;
    EXPECT_EQ(filesOf(scene), whole);
    EXPECT_FALSE(std::filesystem::exists(scene + ".part"));
}

TEST_F(Walk, PathsNeedNotBeUtf8) {
    const std::string latin = path("caf\xe9"), scene = path("caf\xe9.revisit");
    std::filesystem::create_directory_symlink(capture(), latin);
    for (const std::vector<std::string>& command :
         {std::vector<std::string>{kRevisit, "build", latin, "-o", scene, "--hold-out", "every:5:2"},
          {kRevisit, "info", scene, "--json"},
          {kRevisit, "render", scene, "--out", path("caf\xe9-frames")}}) {
        const Outcome outcome = run(command, folder());
        EXPECT_EQ(outcome.status, 0) << command[1] << "\n" << outcome.output;
    }
    EXPECT_GT(readJson(path("caf\xe9-frames") + "/report.json").at("samples_drawn").at("median"), 1000);
}

TEST_F(Walk, PicturesOfAnEarlierRunAreTold) {
    const std::string out = path("twice");
    const auto render = [&](const std::vector<std::string>& further) {
        std::vector<std::string> command{kRevisit, "render", path("room.revisit"), "--out", out};
        command.insert(command.end(), further.begin(), further.end());
        const Outcome drawn = run(command, folder());
        EXPECT_EQ(drawn.status, 0) << drawn.output;
        return drawn.output;
    };
    EXPECT_EQ(render({"--aux"}).find("note:"), std::string::npos);
    EXPECT_EQ(render({"--aux"}).find("note:"), std::string::npos) << "each was drawn anew";
    EXPECT_NE(render({}).find("pictures that this run did not draw"), std::string::npos) << "depth and class are older";
}

TEST_F(Walk, NoPictureOfAnotherHandIsReplaced) {
    const std::filesystem::path folder_(path("photographs"));
    std::filesystem::create_directories(folder_);
    std::ofstream(folder_ / "pose-0000-left.png") << "mine";
    std::ofstream(folder_ / "other.png") << "mine, too";
    const std::vector<std::string> command{kRevisit,         "render", path("room.revisit"), "--out",
                                           folder_.string(), "--path", path("stand.json")};
    std::ofstream(path("stand.json"))
        << R"({"space": "walk", "poses": [{"t": 0, "position": [0, 1.6, 0], "orientation": [0, 0, 0, 1]}]})";
    const Outcome refused = run(command, folder());
    EXPECT_EQ(refused.status, 1);
    EXPECT_NE(refused.output.find("pose-0000-left.png would be replaced"), std::string::npos) << refused.output;
    EXPECT_EQ(std::filesystem::file_size(folder_ / "pose-0000-left.png"), 4u);
    // What a run that was stopped has drawn is drawn again.
    std::filesystem::remove(folder_ / "other.png");
    EXPECT_EQ(run(command, folder()).status, 0);
}

TEST_F(Walk, PicturesThatShowNothingAreToldOf) {
    std::ofstream(path("centimetres.json"))
        << R"({"space": "walk", "poses": [{"t": 0, "position": [0, 160, 0], "orientation": [0.7071, 0, 0, 0.7071]}]})";
    for (const std::vector<std::string>& command :
         {std::vector<std::string>{"render", path("room.revisit"), "--out", path("far-frames")},
          {"walk", path("room.revisit"), "--headless", "--frames", "2", "--out", path("far-walk")}}) {
        std::vector<std::string> whole{kRevisit};
        whole.insert(whole.end(), command.begin(), command.end());
        whole.insert(whole.end(), {"--path", path("centimetres.json")});
        const Outcome drawn = run(whole, folder());
        EXPECT_EQ(drawn.status, 0) << drawn.output;
        EXPECT_NE(drawn.output.find("nothing of the scene is in view in any frame"), std::string::npos) << drawn.output;
    }
}

TEST_F(Walk, WhatHasNothingToWorkOnIsToldOf) {
    const Outcome drawn =
        run({kRevisit, "render", path("room.revisit"), "--out", path("uncovered"), "--coverage-cell", "0.1"}, folder());
    EXPECT_EQ(drawn.status, 0) << drawn.output;
    EXPECT_NE(drawn.output.find("--coverage-cell changes nothing"), std::string::npos) << drawn.output;
}

TEST_F(Walk, StandsUprightThoughNoCameraWasHeldSo) {
    const nlohmann::json walkFromWorld = readJson(path("room.revisit") + "/scene.json").at("walk_from_world");
    // The sample's world has +Z up and its floor at 0.
    EXPECT_GT(walkFromWorld.at(6).get<double>(), std::cos(0.005)) << walkFromWorld;
    EXPECT_NEAR(walkFromWorld.at(7).get<double>(), 0, 0.03) << walkFromWorld;
}

TEST_F(Walk, InfoTellsHowLargeThePlaceIs) {
    const Outcome told = run({kRevisit, "info", path("room.revisit"), "--json"}, folder());
    ASSERT_EQ(told.status, 0) << told.output;
    const nlohmann::json extent = nlohmann::json::parse(told.output).at("extent");
    for (const double metres : extent.at("places_m"))
        EXPECT_LT(metres, 6) << extent;
    EXPECT_GT(extent.at("median_depth_m"), 0.5) << extent;
    EXPECT_LT(extent.at("median_depth_m"), 6) << extent;
    EXPECT_GT(extent.at("nearly_all_depth_m"), extent.at("median_depth_m")) << extent;
    EXPECT_LT(extent.at("nearly_all_depth_m"), 10) << extent;
}

/// Of one photograph, whose range in floats ends before its time: OpenCV has much to say about such a one.
void writeCaptureWithACutOffTiff(const std::filesystem::path& folder) {
    std::filesystem::create_directory(folder);
    // Little-endian, one directory, one strip of floats without compression, of which most is missing.
    constexpr std::uint32_t kShort = 3, kLong = 4, kStripAt = 8 + 2 + 10 * 12 + 4, kStripBytes = 64 * 48 * 4;
    const std::array<std::array<std::uint32_t, 3>, 10> tags{{{256, kLong, 64},       // width
                                                             {257, kLong, 48},       // height
                                                             {258, kShort, 32},      // bits
                                                             {259, kShort, 1},       // no compression
                                                             {262, kShort, 1},       // grey
                                                             {273, kLong, kStripAt}, // where the strip is
                                                             {277, kShort, 1},       // channels
                                                             {278, kLong, 48},       // rows of the strip
                                                             {279, kLong, kStripBytes},
                                                             {339, kShort, 3}}}; // floats
    std::string tiff("II\x2a\0\x08\0\0\0\x0a\0", 10);
    const auto append = [&](std::uint32_t value, std::size_t bytes) {
        tiff.append(reinterpret_cast<const char*>(&value), bytes);
    };
    for (const auto& [tag, type, value] : tags)
        append(tag, 2), append(type, 2), append(1, 4), append(value, 4);
    append(0, 4); // no further directory
    tiff.resize(tiff.size() + kStripBytes / 3, '\x3f');
    scene::writeFile(folder / "depth.tiff", tiff);
    ASSERT_TRUE(cv::imwrite((folder / "colour.png").string(), cv::Mat3b(48, 64, cv::Vec3b(9, 9, 9))));
    const nlohmann::json frame{{"file_path", "colour.png"},
                               {"depth_file_path", "depth.tiff"},
                               {"transform_matrix", {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}}};
    std::ofstream(folder / "transforms.json") << nlohmann::json{
        {"fl_x", 60}, {"fl_y", 60}, {"cx", 32}, {"cy", 24}, {"w", 64}, {"h", 48}, {"frames", {frame}}};
}

TEST_F(Walk, AFileThatMayNotGrowIsToldOfAsAFullDiskIs) {
    // A shell's unit is half a kilobyte.
    const Outcome outcome = run({"/bin/sh", "-c", R"(ulimit -f 64; exec "$@")", "sh", kRevisit, "build", capture(),
                                 "-o", path("small.revisit"), "--hold-out", "every:5:2"},
                                folder());
    EXPECT_EQ(outcome.status, 1) << outcome.output;
    EXPECT_NE(outcome.output.find("; check that the disk has room"), std::string::npos) << outcome.output;
    EXPECT_FALSE(std::filesystem::exists(path("small.revisit")));
}

TEST_F(Walk, WrongUsageIsTwoAndWhatCannotBeDoneIsOne) {
    struct Case {
        std::vector<std::string> command;
        int status;
        const char* says;
    };
    const std::string room = path("room.revisit"), cut = path("cut");
    writeCaptureWithACutOffTiff(cut);
    const std::vector<Case> cases{
        {{kRevisit}, 2, "subcommand"},
        {{kRevisit, "buid", "x"}, 2, "'buid' is no command"},
        {{kRevisit, "build"}, 2, "INPUT"},
        {{kRevisit, "build", capture(), "-o", ""}, 2, "is empty"},
        {{kRevisit, "build", "", "-o", path("x.revisit")}, 2, "INPUT is empty"},
        {{kRevisit, "render", room, "--out", ""}, 2, "--out is empty"},
        {{kRevisit, "build", capture(), "-o", path("x.revisit"), "--scanner", "x.json"}, 1, "is for laser scans"},
        {{kRevisit, "build", capture(), "-o", path("x.revisit"), "--register", "x.json"}, 1, "about laser scans"},
        {{kRevisit, "build", capture(), "-o", path("x.revisit"), "--memory", "lots"}, 2, "--memory"},
        {{kRevisit, "render", room, "--out", path("x"), "--size", "0x10"}, 2, "--size"},
        {{kRevisit, "render", room, "--out", path("x"), "--warp", "bubbles"}, 2, "bubbles"},
        {{kRevisit, "build", path("nowhere"), "-o", path("x.revisit")}, 1, "no such file"},
        {{kRevisit, "build", path("no\nwhere"), "-o", path("x.revisit")}, 1, "no\\x0awhere"},
        {{kRevisit, "build", path("no\xc2\x9bwhere\xc2\xb5"), "-o", path("x.revisit")}, 1, "no\\xc2\\x9bwhere\xc2\xb5"},
        {{kRevisit, "build", cut, "-o", path("x.revisit")}, 1, "depth.tiff: picture is empty, damaged"},
        {{kRevisit, "walk", room, "--headless", "--path", capture() + "/walk.json", "--picture-every", "2"},
         2,
         "--out"},
        {{kRevisit, "build", room, "-o", path("x.revisit")}, 1, "a scene already"},
        {{kRevisit, "build", folder().string(), "-o", path("x.revisit")}, 1, "no capture"},
        {{kRevisit, "build", capture(), "-o", capture()}, 1, "is no scene"},
        {{kRevisit, "info", capture()}, 1, "scene.json"},
        {{kRevisit, "render", room, "--out", path("x"), "--path", path("nowhere.json")}, 1, "no such file"},
        {{kRevisit, "render", room, "--out", path("x"), "--cameras", capture() + "/walk.json"}, 1, "no cameras"},
        {{kRevisit, "render", room, "--out", "/proc/nowhere", "--cameras", capture() + "/walk.json"}, 1, ""},
    };
    for (const Case& c : cases) {
        const Outcome outcome = run(c.command, folder());
        EXPECT_EQ(outcome.status, c.status) << testing::PrintToString(c.command) << "\n" << outcome.output;
        EXPECT_NE(outcome.output.find(c.says), std::string::npos) << testing::PrintToString(c.command) << "\n"
                                                                  << outcome.output;
        if (c.status == 1) {
            EXPECT_EQ(std::count(outcome.output.begin(), outcome.output.end(), '\n'), 1) << "one line:\n"
                                                                                         << outcome.output;
        }
    }
    EXPECT_FALSE(std::filesystem::exists(path("x.revisit"))) << "nothing half-written";
}

TEST_F(Walk, ADamagedSceneIsRefusedByName) {
    const std::string damaged = path("damaged.revisit");
    for (const char* file : {"tiles.bin", "scene.json"}) {
        std::filesystem::remove_all(damaged);
        std::filesystem::copy(path("room.revisit"), damaged, std::filesystem::copy_options::recursive);
        const std::filesystem::path victim = std::filesystem::path(damaged) / file;
        const auto size = std::filesystem::file_size(victim);
        for (const std::uintmax_t cut : {std::uintmax_t{0}, std::uintmax_t{30}, size / 2, size - 1}) {
            std::filesystem::copy_file(path("room.revisit") + "/" + file, victim,
                                       std::filesystem::copy_options::overwrite_existing);
            std::filesystem::resize_file(victim, cut);
            const Outcome outcome = run({kRevisit, "info", damaged}, folder());
            // scene.json ends in a line feed that it can do without.
            if (std::string(file) == "scene.json" && cut == size - 1) continue;
            EXPECT_EQ(outcome.status, 1) << file << " cut to " << cut << "\n" << outcome.output;
            EXPECT_NE(outcome.output.find(file), std::string::npos) << outcome.output;
        }
    }
    std::filesystem::remove_all(damaged);
    std::filesystem::copy(path("room.revisit"), damaged, std::filesystem::copy_options::recursive);
    const std::filesystem::path tiles = std::filesystem::path(damaged) / "tiles.bin";
    const auto size = std::filesystem::file_size(tiles);
    for (std::uintmax_t at = 0; at < 400; at += 7) {
        std::fstream file(tiles, std::ios::in | std::ios::out | std::ios::binary);
        const std::uintmax_t place = at < 200 ? at : size * at / 400;
        file.seekg(static_cast<std::streamoff>(place));
        const int byte = file.get();
        file.seekp(static_cast<std::streamoff>(place));
        file.put(static_cast<char>(byte ^ 0x10));
        file.close();
        const Outcome outcome = run({kRevisit, "info", damaged}, folder());
        EXPECT_TRUE(outcome.status == 1 || outcome.status == 0) << "byte " << place << "\n" << outcome.output;
        if (place < 64) {
            EXPECT_EQ(outcome.status, 1) << "header byte " << place;
        }
        std::fstream back(tiles, std::ios::in | std::ios::out | std::ios::binary);
        back.seekp(static_cast<std::streamoff>(place));
        back.put(static_cast<char>(byte));
    }
}

TEST_F(Walk, NotesAreToldByInfoAndOutliveANewBuild) {
    const std::string scene = path("noted.revisit"), file = scene + "/notes.json";
    const std::vector<std::string> build{kRevisit, "build", capture(), "-o", scene}, info{kRevisit, "info", scene};
    const std::vector<std::string> infoJson{kRevisit, "info", scene, "--json"};
    ASSERT_EQ(run(build, folder()).status, 0);
    EXPECT_EQ(nlohmann::json::parse(run(infoJson, folder()).output).at("notes"), nlohmann::json::array());
    const nlohmann::json notes{
        {{"number", 1}, {"kind", "point"}, {"label", "front door"}, {"position", {1.5, 2, 3}}},
        {{"number", 2}, {"kind", "distance"}, {"label", "D2 5.000 m"}, {"from", {0, 0, 0}}, {"to", {3, 4, 0}}}};
    const nlohmann::json root{{"format", "revisit notes"}, {"version", 1}, {"unit", "m"}, {"notes", notes}};
    scene::writeFile(file, root.dump());
    EXPECT_EQ(nlohmann::json::parse(run(infoJson, folder()).output).at("notes"), notes);
    const std::string told = run(info, folder()).output;
    EXPECT_NE(told.find("front door: 1.500 2.000 3.000"), std::string::npos) << told;
    EXPECT_NE(told.find("D2 5.000 m: from 0.000 0.000 0.000 to 3.000 4.000 0.000, 5.000 m\n"), std::string::npos)
        << told;

    scene::writeFile(scene + "/start.json", "{}");
    ASSERT_EQ(run(build, folder()).status, 0);
    EXPECT_EQ(nlohmann::json::parse(run(infoJson, folder()).output).at("notes"), notes);
    EXPECT_EQ(scene::bytesOfFile(scene + "/start.json"), "{}") << "where walks begin outlives it, too";
    EXPECT_EQ(run(info, folder()).output.find("notes were kept"), std::string::npos) << "nothing moved";

    scene::writeFile(file, root.dump().substr(1));
    const Outcome refused = run(info, folder());
    EXPECT_EQ(refused.status, 1);
    EXPECT_NE(refused.output.find("notes.json: is damaged"), std::string::npos) << refused.output;
    EXPECT_NE(refused.output.find("  tiles      "), std::string::npos) << "the rest is told: " << refused.output;
    EXPECT_EQ(scene::bytesOfFile(file), root.dump().substr(1));
}

} // namespace

} // namespace app
