// The real window on a screen without a monitor, with real keys and a real mouse.

#include "tests/app/comparison.h"
#include "tests/app/made_sample.h"
#include "tests/app/program.h"
#include "tests/app/screen.h"
#include "tests/scene/scratch_folder.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <set>
#include <sstream>
#include <thread>
#include <vector>

namespace app {

namespace {

namespace fs = std::filesystem;

/// A small scene, a screen, and the program on it.
class Desktop : public testing::Test {
  protected:
    void SetUp() override {
        if (!canHaveScreen()) GTEST_SKIP() << "Xvfb, xdotool or import is missing";
        const fs::path capture = scratch_ / "capture";
        const Outcome made =
            makeSample({capture.string(), "--scene", "room", "--images", "6", "--size", "320x240"}, scratch_.path());
        ASSERT_EQ(made.status, 0) << made.output;
        const Outcome built = run({kRevisit, "build", capture.string(), "-o", scene()}, scratch_.path());
        ASSERT_EQ(built.status, 0) << built.output;
        screen_.emplace();
    }

    void TearDown() override {
        if (walk_ > 0) kill(walk_, SIGKILL);
    }

    std::string scene() const { return (scratch_ / "room.revisit").string(); }

    void startWalk(std::vector<std::string> options) {
        std::vector<std::string> command{kRevisit, "walk", scene(), "--desktop"};
        command.insert(command.end(), options.begin(), options.end());
        walk_ = start(screen_->around(scratch_.path().string(), command), log_);
        ASSERT_TRUE(screen_->focus("Revisit")) << waitFor().output;
    }

    Outcome waitFor() {
        const pid_t walk = walk_;
        walk_ = 0;
        return app::waitFor(walk, log_);
    }

    std::string log() const {
        std::ifstream file(log_, std::ios::binary);
        return {std::istreambuf_iterator<char>(file), {}};
    }

    /// Hits keys again and again until something is so; false if it never is.
    template <class IsSo>
    bool hitUntil(const std::vector<std::string>& keys, IsSo&& isSo) {
        const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(30);
        while (std::chrono::steady_clock::now() < deadline) {
            for (const std::string& key : keys)
                screen_->act({"key", key});
            std::this_thread::sleep_for(std::chrono::milliseconds(100));
            if (isSo()) return true;
        }
        return false;
    }

    /// Until the program has said a word so often.
    int timesSaid(const std::string& word) const {
        int said = 0;
        const std::string text = log();
        for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1))
            ++said;
        return said;
    }
    bool hitUntilSaid(const std::string& key, const std::string& word, int times) {
        return hitUntil({key}, [&] { return timesSaid(word) >= times; });
    }
    /// One at least, in which all that was done before is heard.
    bool letFramesPass() { return hitUntilSaid("F12", "kept revisit-", timesSaid("kept revisit-") + 1); }

    /// Where pictures were kept from, as the program has said.
    std::set<std::string> placesOfPictures() const {
        std::set<std::string> places;
        std::istringstream said(log());
        for (std::string line; std::getline(said, line);)
            if (const std::size_t at = line.find("seen from"); at != std::string::npos) places.insert(line.substr(at));
        return places;
    }

    fs::path onlyFile(const std::string& ending) const {
        fs::path found;
        for (const auto& entry : fs::directory_iterator(scratch_.path()))
            if (entry.path().filename().string().starts_with("revisit-") && entry.path().extension() == ending)
                if (found.empty() || entry.path() < found) found = entry.path();
        return found;
    }

    scene::ScratchFolder scratch_;
    std::optional<Screen> screen_;
    pid_t walk_ = 0;
    fs::path log_ = scratch_ / "walk.txt";
};

TEST_F(Desktop, ALostDeviceIsMadeAnewWhereTheWalkerStands) {
    const fs::path record = scratch_ / "record.json";
    walk_ = start(screen_->around(scratch_.path().string(),
                                  {"/usr/bin/env", "VK_LAYER_PATH=" REVISIT_FAULTY_LAYER,
                                   "VK_INSTANCE_LAYERS=VK_LAYER_REVISIT_faulty", "REVISIT_FAULT_LOSE=12", kRevisit,
                                   "walk", scene(), "--desktop", "--record", record.string()}),
                  log_);
    ASSERT_TRUE(screen_->focus("Revisit")) << waitFor().output;
    ASSERT_TRUE(hitUntilSaid("w", "the device was lost, and is made anew", 1)) << log();
    ASSERT_TRUE(hitUntil({"w", "F12"}, [&] { return placesOfPictures().size() >= 5; })) << "no more frames: " << log();
    screen_->act({"key", "Escape"});
    const Outcome ended = waitFor();
    ASSERT_EQ(ended.status, 0) << ended.output;
    const nlohmann::json poses = readJson(record).at("poses");
    ASSERT_GT(poses.size(), 14u);
    double farthest = 0;
    for (std::size_t i = 1; i < poses.size(); ++i)
        for (std::size_t axis = 0; axis < 3; ++axis)
            farthest = std::max(farthest, std::abs(poses[i].at("position").at(axis).get<double>() -
                                                   poses[i - 1].at("position").at(axis).get<double>()));
    EXPECT_LT(farthest, 1.0) << "nobody is set back";
}

TEST_F(Desktop, TheScreenshotIsWhatRenderDrawsFromThere) {
    const fs::path out = scratch_ / "out", frames = scratch_ / "frames";
    startWalk({"--out", out.string(), "--picture-every", "1000000"});
    ASSERT_TRUE(hitUntilSaid("F12", "kept revisit-", 1)) << log();
    EXPECT_TRUE(screen_->grab((scratch_ / "window.png").string()));
    screen_->act({"key", "Escape"});
    const Outcome ended = waitFor();
    ASSERT_EQ(ended.status, 0) << ended.output;

    const Outcome drawn = run({kRevisit, "render", scene(), "--out", frames.string(), "--cameras",
                               (out / "cameras.json").string(), "--eyes", "1"},
                              scratch_.path());
    ASSERT_EQ(drawn.status, 0) << drawn.output;
    const cv::Mat3b shot = cv::imread(onlyFile(".png").string(), cv::IMREAD_COLOR),
                    truth = cv::imread((frames / "frame-000000-left.png").string(), cv::IMREAD_COLOR);
    ASSERT_FALSE(shot.empty());
    ASSERT_EQ(shot.size(), truth.size());
    EXPECT_EQ(cv::norm(shot, truth, cv::NORM_INF), 0) << "nobody has moved";
    EXPECT_GT(readJson(out / "report.json").at("frames_standing").get<int>(), 0) << "and the scene was not warped anew";
    EXPECT_GT(cv::mean(truth)[1], 20) << "there is something to see";

    // And the window shows it: without the panel's part, and what scaling to the window costs.
    const cv::Mat3b window = cv::imread((scratch_ / "window.png").string(), cv::IMREAD_COLOR);
    ASSERT_EQ(window.size(), shot.size());
    const cv::Rect free(400, 100, 800, 600);
    EXPECT_GE(psnr(window(free), shot(free), cv::Mat1b(free.size(), std::uint8_t{1})), 45);
}

TEST_F(Desktop, AFilmIsKept) {
    startWalk({});
    ASSERT_TRUE(hitUntilSaid("F9", "kept revisit-", 1)) << log();
    screen_->act({"key", "Escape"});
    EXPECT_EQ(waitFor().status, 0);
    EXPECT_GT(fs::file_size(onlyFile(".avi")), 10000u);
}

TEST_F(Desktop, AWindowClosedInTheMiddleEndsTheWalkAndKeepsWhatWasRecorded) {
    const fs::path path = scratch_ / "path.json";
    startWalk({"--record", path.string()});
    ASSERT_TRUE(hitUntilSaid("F12", "kept revisit-", 1)) << log();
    screen_->closeWindow();
    const Outcome ended = waitFor();
    EXPECT_EQ(ended.status, 0) << ended.output;
    EXPECT_GE(readJson(path).at("poses").size(), 1u);
}

TEST_F(Desktop, KeysLeadTheWalkerAndWhatWasSetIsKept) {
    const fs::path path = scratch_ / "path.json";
    startWalk({"--record", path.string()});
    ASSERT_TRUE(hitUntilSaid("F12", "kept revisit-", 1)) << log();
    screen_->act({"key", "g"});
    const glm::dvec3 before = placeOfLastPicture(log());
    screen_->act({"keydown", "w"});
    // However long frames take here.
    int kept = 1;
    do
        ASSERT_TRUE(hitUntilSaid("F12", "kept revisit-", ++kept)) << log();
    while (glm::distance(placeOfLastPicture(log()), before) < 0.2 && kept < 200);
    ASSERT_GE(glm::distance(placeOfLastPicture(log()), before), 0.2) << log();
    screen_->act({"keyup", "w"});
    ASSERT_TRUE(hitUntilSaid("b", "begin here", 1)) << log();
    screen_->act({"key", "e"});
    ASSERT_TRUE(hitUntilSaid("F12", "kept revisit-", kept + 4)) << log();
    screen_->act({"key", "Escape"});
    ASSERT_EQ(waitFor().status, 0);

    const auto poses = readJson(path).at("poses");
    const auto &first = poses.front(), &last = poses.back();
    EXPECT_LT(last.at("position").at(2).get<double>(), first.at("position").at(2).get<double>() - 0.1) << "ahead is -z";
    EXPECT_NEAR(last.at("position").at(0).get<double>(), first.at("position").at(0).get<double>(), 1e-6);
    EXPECT_NEAR(last.at("rig").at("yaw").get<double>(), -30 * 3.14159265358979 / 180, 1e-9) << "one snap to the right";
    EXPECT_TRUE(readJson(scratch_ / "config/revisit/settings.json").at("floor_grid").get<bool>());
    const auto start = readJson(fs::path(scene()) / "start.json");
    EXPECT_NEAR(start.at("feet").at(2).get<double>(), last.at("position").at(2).get<double>(), 1e-9);

    // And the next walk begins there.
    startWalk({"--record", path.string()});
    ASSERT_TRUE(hitUntilSaid("F12", "kept revisit-", 1)) << log();
    screen_->act({"key", "Escape"});
    ASSERT_EQ(waitFor().status, 0);
    EXPECT_NEAR(readJson(path).at("poses").front().at("position").at(2).get<double>(),
                start.at("feet").at(2).get<double>(), 1e-9);
}

/// Nothing is waited for but what the program says.
TEST_F(Desktop, ClicksMeasureAndAreListedByInfo) {
    startWalk({});
    ASSERT_TRUE(hitUntilSaid("F12", "kept revisit-", 1)) << log();
    screen_->act({"key", "Page_Up"});
    // One click is one note, however often it is looked for.
    screen_->act({"mousemove", "--sync", "640", "500", "click", "1"});
    ASSERT_TRUE(hitUntilSaid("F12", "P1 at", 1)) << log();
    screen_->act({"keydown", "shift", "mousemove", "--sync", "600", "560", "click", "1"});
    ASSERT_TRUE(hitUntilSaid("F12", "to where?", 1)) << log();
    // Pressed with the Shift key it is a distance, even if that is let go before the button.
    screen_->act({"mousemove", "--sync", "760", "560", "mousedown", "1"});
    ASSERT_TRUE(letFramesPass()) << log();
    screen_->act({"keyup", "shift"});
    ASSERT_TRUE(letFramesPass()) << log();
    screen_->act({"mouseup", "1"});
    ASSERT_TRUE(hitUntilSaid("F12", "D2 ", 1)) << log();
    screen_->act({"mousemove", "--sync", "640", "300", "click", "1"});
    ASSERT_TRUE(hitUntilSaid("F12", "P3 at", 1)) << log();
    screen_->act({"key", "z"});
    ASSERT_TRUE(hitUntilSaid("F12", "P3 is taken back", 1)) << log();
    // What is clicked on the panel is meant for it, even if the mouse has only just come there.
    screen_->act({"mousemove", "60", "60", "click", "1"});
    ASSERT_TRUE(letFramesPass()) << log();
    ASSERT_TRUE(letFramesPass()) << log();
    screen_->act({"key", "Escape"});
    ASSERT_EQ(waitFor().status, 0);

    const Outcome told = run({kRevisit, "info", scene(), "--json"}, scratch_.path());
    ASSERT_EQ(told.status, 0) << told.output;
    const auto notes = nlohmann::json::parse(told.output).at("notes");
    ASSERT_EQ(notes.size(), 2u) << "the third was taken back: " << notes;
    EXPECT_EQ(notes[0].at("kind"), "point");
    EXPECT_EQ(notes[1].at("kind"), "distance");
    const auto a = notes[1].at("from").get<std::vector<double>>(), b = notes[1].at("to").get<std::vector<double>>();
    EXPECT_NEAR(notes[1].at("distance_m").get<double>(), std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]), 1e-3);
    for (const nlohmann::json& note : notes)
        EXPECT_GT(note.at("known_to_m").get<double>(), 0) << note;
    EXPECT_NE(notes[1].at("label").get<std::string>().find(" +-"), std::string::npos);
}

TEST_F(Desktop, WithoutADisplayOneLineSaysSo) {
    const Outcome ended =
        run({"/usr/bin/env", "-u", "DISPLAY", "-u", "WAYLAND_DISPLAY", kRevisit, "walk", scene(), "--desktop"},
            scratch_.path());
    EXPECT_EQ(ended.status, 1);
    EXPECT_NE(ended.output.find("revisit: the desktop: no display answers"), std::string::npos) << ended.output;
    EXPECT_EQ(std::count(ended.output.begin(), ended.output.end(), '\n'), 1) << ended.output;
}

} // namespace

} // namespace app
