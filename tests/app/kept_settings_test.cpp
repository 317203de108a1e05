#include "app/kept_settings.h"

#include "scene/json_file.h"
#include "tests/scene/scratch_folder.h"

#include <gtest/gtest.h>

#include <vector>

namespace app {

namespace {

namespace fs = std::filesystem;

class Kept : public testing::Test {
  protected:
    KeptSettings settingsOf(const fs::path& file) {
        return {file, [this](const std::string& sentence) { told_.push_back(sentence); }};
    }
    static input::Settings changed() {
        input::Settings settings;
        settings.locomotion.snapDegrees = 45;
        return settings;
    }
    void expectToldOnce(const std::string& about) const {
        ASSERT_EQ(told_.size(), 1u) << about;
        EXPECT_EQ(told_[0].find(about), 0u) << told_[0];
        EXPECT_EQ(told_[0].find('\n'), std::string::npos) << told_[0];
    }

    scene::ScratchFolder scratch_;
    fs::path file_ = scratch_ / "config/revisit/settings.json";
    std::vector<std::string> told_;
};

TEST_F(Kept, TheyComeBackInTheNextWalk) {
    settingsOf(file_).keep(changed());
    EXPECT_EQ(settingsOf(file_).read().locomotion.snapDegrees, 45);
    EXPECT_TRUE(told_.empty());
    EXPECT_FALSE(fs::exists(file_.string() + ".part"));
}

TEST_F(Kept, NothingIsWrittenWhereNothingWasChanged) {
    settingsOf(file_).keep({});
    EXPECT_FALSE(fs::exists(scratch_ / "config"));
    fs::create_directories(file_.parent_path());
    scene::writeFile(file_, R"({"snap_degrees":45})");
    settingsOf(file_).keep(changed());
    EXPECT_EQ(scene::bytesOfFile(file_), R"({"snap_degrees":45})");
}

TEST_F(Kept, ABrokenFileIsToldOfAndLeftAsItIs) {
    fs::create_directories(file_.parent_path());
    for (const char* text : {"{", R"({"snap_degrees": 400, "of_a_later_version": 1})"}) {
        told_.clear();
        scene::writeFile(file_, text);
        const KeptSettings kept = settingsOf(file_);
        EXPECT_EQ(kept.read().locomotion.snapDegrees, 30) << "the defaults";
        kept.keep(changed());
        EXPECT_EQ(scene::bytesOfFile(file_), text);
        expectToldOnce(file_.string());
    }
}

TEST_F(Kept, AFileThatBreaksDuringTheWalkIsLeftToo) {
    const KeptSettings kept = settingsOf(file_);
    fs::create_directories(file_.parent_path());
    for (const char* text : {"{", "[1, 2]"}) {
        told_.clear();
        scene::writeFile(file_, text);
        kept.keep(changed());
        EXPECT_EQ(scene::bytesOfFile(file_), text);
        expectToldOnce(file_.string());
    }
}

TEST_F(Kept, WhatAnotherWalkAddedMeanwhileStays) {
    const KeptSettings kept = settingsOf(file_);
    fs::create_directories(file_.parent_path());
    scene::writeFile(file_, R"({"of_a_later_version": [1, 2]})");
    kept.keep(changed());
    EXPECT_EQ(scene::readJsonFile(file_).at("of_a_later_version").size(), 2u);
    EXPECT_EQ(scene::readJsonFile(file_).at("snap_degrees"), 45);
}

TEST_F(Kept, WhereTheyCannotBeWrittenOneGoesOnWithout) {
    scene::writeFile(scratch_ / "config", "a file where a folder should be");
    const KeptSettings kept = settingsOf(file_);
    EXPECT_TRUE(told_.empty()) << "there are none yet";
    kept.keep(changed());
    expectToldOnce(file_.string());
}

TEST_F(Kept, WithoutAHomeOneGoesOnWithout) {
    const KeptSettings kept = settingsOf({});
    kept.keep({});
    EXPECT_TRUE(told_.empty());
    kept.keep(changed());
    expectToldOnce("settings: are not kept");
}

TEST_F(Kept, ALinkStaysALink) {
    const fs::path elsewhere = scratch_ / "elsewhere.json";
    scene::writeFile(elsewhere, R"({"floor_grid": true})");
    fs::create_directories(file_.parent_path());
    fs::create_symlink(elsewhere, file_);
    settingsOf(file_).keep(changed());
    EXPECT_TRUE(fs::is_symlink(file_));
    EXPECT_EQ(scene::readJsonFile(elsewhere).at("snap_degrees"), 45);
}

} // namespace

} // namespace app
