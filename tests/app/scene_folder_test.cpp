// What a build may put a scene in place of.

#include "app/scene_folder.h"
#include "scene/errors.h"
#include "scene/json_file.h"

#include "tests/scene/scratch_folder.h"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace app {
namespace {

using testing::HasSubstr;

void write(const std::filesystem::path& path, const std::string& text = "x") {
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path) << text;
}

std::string refusalOf(const std::filesystem::path& output, const std::vector<std::filesystem::path>& inputs = {}) {
    try {
        checkReplaceable(output, inputs);
    } catch (const scene::Failure& failure) {
        return failure.what();
    }
    return {};
}

class SceneFolder : public testing::Test {
  protected:
    void SetUp() override {
        write(
            scene_ / "scene.json",
            R"({"revisit": "scene", "images": [{"name": "a"}, {"name": "b"}, {"name": "caf\ufffd"}], "held_out": [{"name": "c"}]})");
        for (const char* name : {"tiles.bin", "coverage.bin", "notes.json", "start.json", "images/a.tiff",
                                 "images/b.tiff.part", "images/caf\xe9.tiff", "held_out/c.tiff", ".DS_Store"})
            write(scene_ / name);
    }
    scene::ScratchFolder scratch_;
    const std::filesystem::path scene_ = scratch_ / "room.revisit";
};

TEST_F(SceneFolder, AScenesOwnFilesAreReplacedAndNothingElse) {
    EXPECT_EQ(refusalOf(scene_, {scratch_ / "capture"}), "");
    EXPECT_EQ(refusalOf(scratch_ / "new.revisit"), "");
    std::filesystem::create_symlink("nowhere", scratch_ / "dangling");
    EXPECT_THAT(refusalOf(scratch_ / "dangling"), HasSubstr("is a link to what does not exist"));
    for (const char* name : {"station.e57", "frames/pose-0000-left.png", "images/00001.png", "images/mine.tiff",
                             "held_out/x.jpg", "notes.json.bak"}) {
        write(scene_ / name);
        const std::string first = std::filesystem::path(name).begin()->string();
        EXPECT_THAT(refusalOf(scene_), HasSubstr("holds " + (first == "frames" ? first : std::string(name)) + ","));
        std::filesystem::remove_all(scene_ / (first == "frames" ? first : std::string(name)));
    }
    EXPECT_EQ(refusalOf(scene_), "");
}

TEST_F(SceneFolder, NoInputIsReplaced) {
    EXPECT_THAT(refusalOf(scene_, {scene_ / "images" / "a.tiff"}), HasSubstr("would be lost"));
    EXPECT_THAT(refusalOf(scene_, {scratch_ / "other" / ".." / "room.revisit" / "tiles.bin"}),
                HasSubstr("would be lost"));
    EXPECT_EQ(refusalOf(scene_, {scratch_ / "room.revisit.e57"}), "");
}

TEST_F(SceneFolder, WhatOnlyLooksLikeASceneIsLeftAlone) {
    for (const char* manifest : {"{}", "", "[1]", R"({"revisit": "path"})"}) {
        write(scene_ / "scene.json", manifest);
        EXPECT_THAT(refusalOf(scene_), HasSubstr("is no scene")) << manifest;
    }
}

TEST_F(SceneFolder, NorIsAFolderOfSomebodysUnderTheNameOfAnUnfinishedScene) {
    const std::filesystem::path part = unfinishedSceneOf(scene_);
    write(part / "images" / "a.tiff.part");
    EXPECT_EQ(refusalOf(scene_), "") << "what a build that was killed leaves";
    write(part / "thesis.txt");
    EXPECT_THAT(refusalOf(scene_), HasSubstr("holds thesis.txt,"));
    std::filesystem::remove_all(part);
    write(part);
    EXPECT_THAT(refusalOf(scene_), HasSubstr("is in the way"));
}

} // namespace
} // namespace app
