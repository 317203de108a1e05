// What a build may put a scene in place of.

#include "app/scene_folder.h"
#include "scene/errors.h"
#include "scene/json_file.h"

#include "tests/scene/scratch_folder.h"

#include <cerrno>
#include <cstring>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/syscall.h>
#include <unistd.h>

namespace app {
namespace {
int errorOfExchange = 0; ///< what renameat2 fails with; 0: the system decides
}
} // namespace app

/// In place of the system's own.
extern "C" int renameat2(int fromFolder, const char* from, int toFolder, const char* to, unsigned how) noexcept {
    if (app::errorOfExchange == 0) return static_cast<int>(syscall(SYS_renameat2, fromFolder, from, toFolder, to, how));
    errno = app::errorOfExchange;
    return -1;
}

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
    void TearDown() override { errorOfExchange = 0; }
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

TEST_F(SceneFolder, NoneIsPutWhereADiskIsMounted) {
    EXPECT_THAT(refusalOf("/proc"), HasSubstr("/proc: is where a disk is mounted"));
    EXPECT_THAT(refusalOf("/proc"), HasSubstr("; name a folder inside it"));
}

TEST_F(SceneFolder, AScenesPlaceIsWhereALinkLeads) {
    namespace fs = std::filesystem;
    fs::create_directory(scratch_ / "links");
    fs::create_symlink("../room.revisit", scratch_ / "links" / "first");
    fs::create_symlink("first", scratch_ / "links" / "second");
    const fs::path place = fs::canonical(scene_);
    for (const char* name : {"links/first", "links/second", "links/second/", "links/./second"})
        EXPECT_EQ(placeOfScene(scratch_ / name), place) << name;
    EXPECT_EQ(placeOfScene(scratch_ / "room.revisit/"), scene_);
    EXPECT_EQ(placeOfScene(scratch_ / "new.revisit"), scratch_ / "new.revisit");
    fs::create_symlink("nowhere", scratch_ / "dangling");
    EXPECT_EQ(placeOfScene(scratch_ / "dangling"), scratch_ / "dangling") << "which is refused";
}

TEST_F(SceneFolder, ANewOneTakesTheOldOnesPlaceOrTheOldOneStays) {
    const std::filesystem::path part = unfinishedSceneOf(scene_);
    const auto saidOf = [&](int error) {
        errorOfExchange = error;
        return scene::failureOf<scene::Failure>([&] { putInPlace(part, scene_); });
    };
    // In one step where the file system knows it, else in two; nothing else stays beside it.
    for (const int error : {0, EINVAL, ENOSYS}) {
        const std::string text = "new, exchange fails with " + std::to_string(error);
        write(part / "tiles.bin", text);
        EXPECT_EQ(saidOf(error), "");
        EXPECT_EQ(scene::bytesOfFile(scene_ / "tiles.bin"), text);
        EXPECT_FALSE(std::filesystem::exists(scene_ / "scene.json"));
        EXPECT_EQ(scratch_.fileCount(), 1u) << text;
    }
    // Here the second step fails: there is no new one.
    EXPECT_THAT(saidOf(EINVAL), HasSubstr(std::string("cannot be renamed into place (") + std::strerror(ENOENT)));
    EXPECT_TRUE(std::filesystem::exists(scene_ / "tiles.bin")) << "it was put back";
    EXPECT_EQ(scratch_.fileCount(), 1u);
    write(part / "tiles.bin");
    EXPECT_THAT(saidOf(EACCES), HasSubstr("cannot be exchanged for the new scene"));
    EXPECT_TRUE(std::filesystem::exists(part) && std::filesystem::exists(scene_));
    std::filesystem::remove_all(scene_);
    EXPECT_EQ(saidOf(EACCES), "") << "where nothing was, nothing is exchanged";
    EXPECT_TRUE(std::filesystem::exists(scene_ / "tiles.bin"));
}

} // namespace
} // namespace app
