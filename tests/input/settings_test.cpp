#include "input/settings.h"

#include "scene/errors.h"
#include "tests/scene/scratch_folder.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include <nlohmann/json.hpp>

namespace input {

namespace {

class SettingsFile : public testing::Test {
  protected:
    std::string failureOfReading(const std::string& text) const {
        scene::writeFile(file_, text);
        return scene::failureOf<scene::Failure>([&] { readSettings(file_); });
    }
    scene::ScratchFolder scratch_;
    std::filesystem::path file_ = scratch_ / "settings.json";
};

TEST_F(SettingsFile, ComesBackAndKeepsWhatItDoesNotKnow) {
    Settings settings;
    settings.locomotion.snapDegrees = 45;
    settings.locomotion.flies = true;
    settings.locomotion.hasVignette = false;
    settings.locomotion.vignetteFallSeconds = 0.7;
    settings.eyeHeightMetres = 1.25;
    settings.showsFloorGrid = true;
    scene::writeFile(file_, R"({"of_a_later_version": [1, 2], "snap_degrees": 15})");
    scene::writeFile(file_, textOf(settings, file_));
    const Settings again = readSettings(file_);
    EXPECT_EQ(again.locomotion.snapDegrees, 45);
    EXPECT_TRUE(again.locomotion.flies);
    EXPECT_FALSE(again.locomotion.hasVignette);
    EXPECT_EQ(again.locomotion.vignetteFallSeconds, 0.7);
    EXPECT_EQ(again.eyeHeightMetres, 1.25);
    EXPECT_TRUE(again.showsFloorGrid);
    EXPECT_EQ(again.locomotion.metresPerSecond, 1.4) << "as the defaults have it";
    EXPECT_NE(textOf(again, file_).find("of_a_later_version"), std::string::npos);
}

TEST_F(SettingsFile, ThatIsNotThereMeansTheDefaults) {
    EXPECT_EQ(readSettings(file_).locomotion.snapDegrees, 30);
    EXPECT_EQ(readSettings({}).locomotion.snapDegrees, 30);
    EXPECT_FALSE(readStart(scratch_ / "start.json"));
}

TEST_F(SettingsFile, ThatIsBrokenIsRefusedByName) {
    for (const char* text : {"{", "[]", "3", R"({"snap_degrees": "much"})", R"({"snap_degrees": -1})",
                             R"({"metres_per_second": 1000})", R"({"vignette": 1})", R"({"snap_degrees": null})"}) {
        const std::string failure = failureOfReading(text);
        EXPECT_EQ(failure.find(file_.string()), 0u) << text << ": " << failure;
        EXPECT_EQ(failure.find('\n'), std::string::npos) << failure;
    }
}

TEST_F(SettingsFile, WhatIsOutOfItsRangeIsToldWithTheRange) {
    const std::string failure = failureOfReading(R"({"snap_degrees": 91})");
    EXPECT_NE(failure.find("snap_degrees is no number from 0 to 90;"), std::string::npos) << failure;
    EXPECT_NE(failureOfReading(R"({"metres_per_second": 0.01})").find(" from 0.1 to 50;"), std::string::npos);
    for (const char* text : {R"({"snap_degrees": 0})", R"({"snap_degrees": 90})", R"({"vignette_fall_seconds": 0})"})
        EXPECT_EQ(failureOfReading(text), "") << text;
}

TEST_F(SettingsFile, ThatCannotBeLookedForIsAFailureLikeAnother) {
    const std::filesystem::path loop = scratch_ / "loop";
    std::filesystem::create_symlink(loop, loop);
    for (const std::filesystem::path& file :
         {loop / "settings.json", loop, scratch_.path() / std::string(5000, 'x'), scratch_.path()}) {
        EXPECT_NE(scene::failureOf<scene::Failure>([&] { readSettings(file); }), "") << file;
        EXPECT_NE(scene::failureOf<scene::Failure>([&] { readStart(file); }), "") << file;
        EXPECT_NE(scene::failureOf<scene::Failure>([&] { textOf(Settings(), file); }), "") << file;
    }
    // A file where a folder should be: there are no settings below it.
    scene::writeFile(file_, "");
    EXPECT_EQ(failureOfReading("{}"), "");
    EXPECT_EQ(readSettings(file_ / "settings.json").locomotion.snapDegrees, 30);
}

TEST_F(SettingsFile, NothingIsWrittenOverWhatIsNoSettings) {
    for (const char* text : {"{", "[]", "3", "null", "\"all\""}) {
        scene::writeFile(file_, text);
        const std::string failure = scene::failureOf<scene::Failure>([&] { textOf(Settings(), file_); });
        EXPECT_EQ(failure.find(file_.string()), 0u) << text << ": " << failure;
    }
}

TEST_F(SettingsFile, StandsWhereTheDesktopWantsIt) {
    setenv("XDG_CONFIG_HOME", "/somewhere", 1);
    EXPECT_EQ(settingsFile(), "/somewhere/revisit/settings.json");
    setenv("XDG_CONFIG_HOME", "not/absolute", 1);
    setenv("HOME", "/people/a", 1);
    EXPECT_EQ(settingsFile(), "/people/a/.config/revisit/settings.json");
    unsetenv("HOME");
    unsetenv("XDG_CONFIG_HOME");
    EXPECT_TRUE(settingsFile().empty());
}

TEST_F(SettingsFile, AStartComesBack) {
    const std::filesystem::path file = scratch_ / "start.json";
    scene::writeFile(file, textOf(StartPose{{1, 2, 3}, 0.5, 2}));
    const auto start = readStart(file);
    ASSERT_TRUE(start);
    EXPECT_EQ(start->feet, glm::dvec3(1, 2, 3));
    EXPECT_EQ(start->heading, 0.5);
    EXPECT_EQ(start->scale, 2);
    for (const char* text :
         {"{}", "[]", "7", R"({"feet": [1, 2], "heading": 0, "scale": 1})",
          R"({"feet": [1, 2, 3], "heading": 0, "scale": 0})", R"({"feet": [1, 2, 3], "heading": 0, "scale": 1e-9})",
          R"({"feet": [1, 2, 3], "heading": 0, "scale": 1e9})", R"({"feet": [1, 2, 1e10], "heading": 0, "scale": 1})",
          R"({"feet": [1, 2, 3], "heading": "north", "scale": 1})"}) {
        scene::writeFile(file, text);
        const std::string failure = scene::failureOf<scene::Failure>([&] { readStart(file); });
        EXPECT_EQ(failure.find(file.string()), 0u) << text << ": " << failure;
        EXPECT_EQ(failure.find('\n'), std::string::npos) << failure;
    }
}

} // namespace

} // namespace input
