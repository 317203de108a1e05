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
    settings.eyeHeightMetres = 1.25;
    settings.showsFloorGrid = true;
    scene::writeFile(file_, R"({"of_a_later_version": [1, 2], "snap_degrees": 15})");
    scene::writeFile(file_, textOf(settings, file_));
    const Settings again = readSettings(file_);
    EXPECT_EQ(again.locomotion.snapDegrees, 45);
    EXPECT_TRUE(again.locomotion.flies);
    EXPECT_FALSE(again.locomotion.hasVignette);
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
         {"{}", R"({"feet": [1, 2], "heading": 0, "scale": 1})", R"({"feet": [1, 2, 3], "heading": 0, "scale": 0})"}) {
        scene::writeFile(file, text);
        EXPECT_NE(scene::failureOf<scene::Failure>([&] { readStart(file); }), "") << text;
    }
}

} // namespace

} // namespace input
