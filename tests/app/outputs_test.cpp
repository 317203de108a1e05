// What the programs put in the place of what: results of before, and nothing of another hand.

#include "tests/app/comparison.h"
#include "tests/app/program.h"
#include "tests/app/sample_scene.h"
#include "tests/scene/scratch_folder.h"

#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace app {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

const SampleScene& sampleRoom() {
    static const SampleScene room("room", 4, "80x60");
    return room;
}

class Outputs : public testing::Test {
  protected:
    std::string at(const std::string& name) const { return (scratch_ / name).string(); }
    Outcome revisit(std::vector<std::string> arguments) const {
        arguments.insert(arguments.begin(), REVISIT_PROGRAM);
        return run(arguments, scratch_.path());
    }
    /// As a shell runs it, where it may send its output.
    Outcome shell(const std::string& command) const {
        return run({"/bin/sh", "-c", std::string(REVISIT_PROGRAM) + " " + command}, scratch_.path());
    }
    void expectRefused(const std::vector<std::string>& arguments, const std::string& says, const std::string& kept) {
        const std::string before = scene::bytesOfFile(kept);
        const Outcome refused = revisit(arguments);
        EXPECT_EQ(refused.status, 1) << testing::PrintToString(arguments) << refused.output;
        EXPECT_THAT(refused.output, HasSubstr(says)) << testing::PrintToString(arguments);
        EXPECT_EQ(scene::bytesOfFile(kept), before) << testing::PrintToString(arguments);
    }
    void writePath(const std::string& name) const {
        scene::writeFile(at(name), R"({"space": "walk", "poses": [
            {"t": 0, "position": [0, 1.6, 0], "orientation": [0, 0, 0, 1]},
            {"t": 1, "position": [0.1, 1.6, 0], "orientation": [0, 0, 0, 1]}]})");
    }
    std::vector<std::string> walk(const std::vector<std::string>& further) const {
        std::vector<std::string> command{
            "walk", sampleRoom().scene(), "--headless", "--path", at("path.json"), "--frames", "2", "--size", "32x24"};
        command.insert(command.end(), further.begin(), further.end());
        return command;
    }

    scene::ScratchFolder scratch_;
};

TEST_F(Outputs, NoInputAndNoPartOfASceneIsReplaced) {
    writePath("path.json");
    scene::writeFile(at("board.jpg"), "a photograph");
    const std::string manifest = sampleRoom().scene() + "/scene.json";
    expectRefused({"calibrate", "camera", at("board.jpg"), "-o", at("board.jpg")}, "this command reads it",
                  at("board.jpg"));
    expectRefused({"calibrate", "camera", at("board.jpg"), "-o", manifest}, "nothing that this command writes",
                  manifest);
    expectRefused(walk({"--record", at("path.json")}), "this command reads it", at("path.json"));
    expectRefused(walk({"--record", manifest}), "nothing that this command writes", manifest);
    expectRefused({"plan", sampleRoom().scene(), "--out", manifest}, "nothing that this command writes", manifest);
}

TEST_F(Outputs, AWalkReplacesAWalkAndNothingElse) {
    writePath("path.json");
    const std::vector<std::string> command = walk({"--out", at("out"), "--picture-every", "1"});
    ASSERT_EQ(revisit(command).status, 0);
    const Outcome again = revisit(command);
    EXPECT_EQ(again.status, 0) << again.output;
    EXPECT_THAT(again.output, HasSubstr("holds pictures of an earlier walk, 4 of them"));
    // Of one that was killed there is no report: pictures alone, and what was beside them.
    fs::remove(at("out/report.json"));
    fs::remove(at("out/cameras.json"));
    scene::writeFile(at("out/log.txt"), "said");
    EXPECT_EQ(revisit(command).status, 0);
    fs::remove(at("out/report.json"));
    expectRefused(command, "holds cameras.json", at("out/cameras.json"));
    fs::remove(at("out/cameras.json"));
    scene::writeFile(at("out/mine.png"), "a photograph");
    expectRefused(command, "holds pictures of frames", at("out/frame-000000-left.png"));

    fs::create_directory(at("mine"));
    scene::writeFile(at("mine/report.json"), R"({"of": "another hand"})");
    expectRefused(walk({"--out", at("mine")}), "holds report.json", at("mine/report.json"));
    expectRefused({"render", sampleRoom().scene(), "--path", at("path.json"), "--size", "32x24", "--out", at("mine")},
                  "holds report.json", at("mine/report.json"));
    // A user's cameras beside what was drawn by them.
    scene::writeFile(at("mine/report.json"), R"({"samples_drawn": {}, "frames": 1})");
    scene::writeFile(at("mine/cameras.json"), R"({"cameras": []})");
    expectRefused(walk({"--out", at("mine"), "--picture-every", "1"}), "cameras.json", at("mine/cameras.json"));
}

TEST_F(Outputs, ARecordGoesWhereALinkLeadsAndIntoADevice) {
    writePath("path.json");
    fs::create_symlink("real.json", at("link.json"));
    expectRefused(walk({"--record", at("link.json")}), "is a link to what does not exist", at("path.json"));
    ASSERT_EQ(revisit(walk({"--record", at("real.json")})).status, 0);
    ASSERT_EQ(revisit(walk({"--record", at("link.json")})).status, 0);
    EXPECT_TRUE(fs::is_symlink(at("link.json")));
    EXPECT_EQ(revisit(walk({"--record", "/dev/null"})).status, 0);
    EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST_F(Outputs, ASceneGoesWhereALinkLeads) {
    fs::create_directory(at("other-disk"));
    fs::copy(sampleRoom().scene(), at("other-disk/room.revisit"), fs::copy_options::recursive);
    fs::create_directory_symlink("other-disk/room.revisit", at("link.revisit"));
    scene::writeFile(at("link.revisit/start.json"), "{}");
    scene::writeFile(at("link.revisit/tiles.bin"), "to be replaced");
    const Outcome built = revisit({"build", sampleRoom().capture(), "-o", at("link.revisit")});
    ASSERT_EQ(built.status, 0) << built.output;
    EXPECT_TRUE(fs::is_symlink(at("link.revisit")));
    EXPECT_GT(fs::file_size(at("other-disk/room.revisit/tiles.bin")), 1000u);
    EXPECT_EQ(scene::bytesOfFile(at("other-disk/room.revisit/start.json")), "{}");
}

TEST_F(Outputs, WhatCannotBeWrittenToStandardOutputIsNoSuccess) {
    for (const std::string command : {"--help", "info --json "}) {
        const std::string whole = command + (command[0] == 'i' ? sampleRoom().scene() : std::string());
        const Outcome full = shell(whole + " > /dev/full");
        EXPECT_EQ(full.status, 1) << full.output;
        EXPECT_THAT(full.output, HasSubstr("standard output: cannot be written to"));
        EXPECT_EQ(shell(whole + " > /dev/null").status, 0);
    }
}

TEST_F(Outputs, NotesOfImagesThatStoodElsewhereAreSaidToBe) {
    fs::copy(sampleRoom().capture(), at("moved"), fs::copy_options::recursive);
    const std::string manifest = at("moved/transforms.json"), room = at("room.revisit");
    ASSERT_EQ(revisit({"build", at("moved"), "-o", room}).status, 0);
    scene::writeFile(room + "/notes.json", R"({"format": "revisit notes", "version": 1, "unit": "m", "notes":
        [{"number": 1, "kind": "point", "label": "P1", "position": [1, 2, 3]}]})");
    EXPECT_THAT(revisit({"build", at("moved"), "-o", room}).output, Not(HasSubstr("note was kept")));
    nlohmann::json capture = readJson(manifest);
    for (nlohmann::json& frame : capture.at("frames"))
        frame.at("transform_matrix")[0][3] = frame.at("transform_matrix")[0][3].get<double>() + 0.5;
    scene::writeFile(manifest, capture.dump());
    const Outcome moved = revisit({"build", at("moved"), "-o", room});
    EXPECT_EQ(moved.status, 0);
    EXPECT_THAT(moved.output, HasSubstr("1 note was kept, but its images stood elsewhere"));
    EXPECT_THAT(revisit({"info", room}).output, HasSubstr("1 note was kept"));
    EXPECT_THAT(revisit({"build", at("moved"), "-o", room}).output, HasSubstr("1 note was kept")) << "as before";
}

TEST_F(Outputs, InfoInJsonOutlivesDamagedNotes) {
    fs::copy(sampleRoom().scene(), at("noted.revisit"), fs::copy_options::recursive);
    scene::writeFile(at("noted.revisit/notes.json"), "");
    const Outcome told = shell("info --json " + at("noted.revisit") + " 2> /dev/null");
    EXPECT_EQ(told.status, 1);
    const nlohmann::json info = nlohmann::json::parse(told.output);
    EXPECT_TRUE(info.at("notes").is_null());
    EXPECT_GT(info.at("figures").at("samples"), 0);
}

} // namespace
} // namespace app
