#include "app/stage_store.h"

#include "app/build_stages.h"
#include "scene/errors.h"
#include "tests/app/refused_lock.h"
#include "tests/scene/scratch_folder.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <set>
#include <stdexcept>

#include <gtest/gtest.h>

#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

/// In place of the system's own.
extern "C" int flock(int descriptor, int how) noexcept {
    if (app::RefusedLock::errorOfAll == 0) return static_cast<int>(syscall(SYS_flock, descriptor, how));
    errno = app::RefusedLock::errorOfAll;
    return -1;
}

namespace app {
namespace {

using nlohmann::json;
using scene::Failure;
using scene::failureOf;

class Stages : public testing::Test {
  protected:
    std::filesystem::path folder() const { return scratch_ / "scene.build"; }
    scene::ScratchFolder scratch_;
};

TEST(StageKeys, ChangeWithAnyInput) {
    const json original{3, "name", {{"size", 640}, {"near", 0.5}}, {1, 2.5, true, nullptr}};
    std::set<std::string> keys{keyOf(original)};
    EXPECT_EQ(keyOf(json::parse(original.dump())), *keys.begin()) << "the same again";
    EXPECT_EQ(keyOf({{"a", 1}, {"b", 2}}), keyOf({{"b", 2}, {"a", 1}})) << "names have no order";
    const auto changed = [&](const char* pointer, const json& value) {
        json other = original;
        other[json::json_pointer(pointer)] = value;
        const std::string key = keyOf(other);
        EXPECT_EQ(key.size(), 32u);
        EXPECT_EQ(key.find_first_not_of("0123456789abcdef"), std::string::npos) << key;
        EXPECT_TRUE(keys.insert(key).second) << pointer << " = " << value;
    };
    changed("/0", 4);
    changed("/1", "Name");
    changed("/2/size", 641);
    changed("/2/near", std::nextafter(0.5, 1.0));
    changed("/2/far", 0.5);
    changed("/3/0", 2);
    changed("/3/1", 2.25);
    changed("/3/2", false);
    changed("/3/3", 0);
    changed("/3/4", nullptr);
    changed("/4", json::array());
    EXPECT_TRUE(keys.insert(keyOf({2.5, 1})).second && keys.insert(keyOf({1, 2.5})).second) << "order counts";
    EXPECT_TRUE(keys.insert(keyOf({"ab", "c"})).second && keys.insert(keyOf({"a", "bc"})).second);
}

TEST_F(Stages, FilesAreKnownByPlaceSizeAndTime) {
    const std::filesystem::path file = scratch_ / "picture.png", other = scratch_ / "other.png";
    scene::writeFile(file, "12345");
    const auto time = std::filesystem::last_write_time(file);
    const json before = fingerprintOf(file);
    EXPECT_EQ(fingerprintOf(file), before);
    scene::writeFile(other, "12345");
    std::filesystem::last_write_time(other, time);
    EXPECT_NE(fingerprintOf(other), before) << "another place";
    scene::writeFile(file, "123456");
    std::filesystem::last_write_time(file, time);
    EXPECT_NE(fingerprintOf(file), before) << "another size";
    scene::writeFile(file, "54321");
    std::filesystem::last_write_time(file, time + std::chrono::microseconds(1));
    EXPECT_NE(fingerprintOf(file), before) << "another time";
    std::filesystem::remove(file);
    EXPECT_NE(fingerprintOf(file), before) << "gone";
}

TEST_F(Stages, NamesNeedNotBeUtf8) {
    const std::filesystem::path latin = scratch_ / "caf\xe9.png", other = scratch_ / "caf\xe8.png";
    EXPECT_NE(keyOf(fingerprintOf(latin)), keyOf(fingerprintOf(other)));
}

TEST_F(Stages, AResultIsMadeOnce) {
    int made = 0;
    const auto make = [&](const std::filesystem::path& part) {
        ++made;
        scene::writeFile(part / "result", "whole");
    };
    std::filesystem::path first;
    {
        StageStore store(folder());
        first = store.find("photo", keyOf({1}), make);
        EXPECT_EQ(scene::bytesOfFile(first / "result"), "whole");
        EXPECT_EQ(store.find("photo", keyOf({1}), make), first);
        EXPECT_EQ(made, 1);
        EXPECT_NE(store.find("photo", keyOf({2}), make), first) << "another key";
        EXPECT_NE(store.find("scan", keyOf({1}), make), first) << "another stage";
        EXPECT_EQ(made, 3);
    }
    StageStore later(folder());
    EXPECT_EQ(later.find("photo", keyOf({1}), make), first);
    EXPECT_EQ(made, 3) << "what a build left is there for the next";
}

TEST_F(Stages, WhatIsHalfWrittenIsMadeAgain) {
    StageStore store(folder());
    const std::string key = keyOf({1});
    EXPECT_THROW(store.find("photo", key,
                            [](const std::filesystem::path& part) {
                                scene::writeFile(part / "half", "ha");
                                throw std::runtime_error("the disk is full");
                            }),
                 std::runtime_error);
    // As a build leaves it that was killed: the temporary folder with something in it.
    const std::filesystem::path part = folder() / ("photo-" + key + ".part");
    std::filesystem::create_directories(part);
    scene::writeFile(part / "rubbish", "ru");
    const std::filesystem::path made = store.find(
        "photo", key, [](const std::filesystem::path& fresh) { scene::writeFile(fresh / "result", "whole"); });
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(made))
        names.insert(entry.path().filename().string());
    EXPECT_EQ(names, std::set<std::string>{"result"});
    EXPECT_FALSE(std::filesystem::exists(part));
}

TEST_F(Stages, WhatAKilledBuildLeftUnderAnyKeyIsRemoved) {
    const std::filesystem::path photo = folder() / ("photo-" + keyOf({1}) + ".part"),
                                tiles = folder() / ("tiles-" + keyOf({2}));
    const std::vector<std::filesystem::path> left{photo / "image.tiff", tiles / "a.bin.part"},
        kept{tiles / "b.bin", folder() / "notes-of-mine.part" / "a", folder() / "mine.part"};
    const auto write = [&](const std::vector<std::filesystem::path>& files) {
        for (const std::filesystem::path& file : files)
            std::filesystem::create_directories(file.parent_path()), scene::writeFile(file, "x");
    };
    write({left[0]});
    EXPECT_FALSE(StageStore(folder()).hasOlder());
    EXPECT_FALSE(std::filesystem::exists(photo));
    write(left), write(kept);
    {
        const RefusedLock refused(ENOLCK);
        StageStore store(folder());
        EXPECT_TRUE(std::filesystem::exists(left[0])) << "it may be of a build that goes on";
    }
    EXPECT_TRUE(StageStore(folder()).hasOlder());
    EXPECT_FALSE(std::filesystem::exists(photo));
    EXPECT_FALSE(std::filesystem::exists(left[1]));
    for (const std::filesystem::path& file : kept)
        EXPECT_TRUE(std::filesystem::exists(file)) << file;
}

TEST_F(Stages, ASecondProcessIsRefused) {
    const auto opened = [&] { return failureOf<Failure>([&] { StageStore store(folder()); }); };
    {
        const StageStore store(folder());
        EXPECT_NE(opened().find("another build"), std::string::npos) << opened();
        constexpr int kRefused = 3, kLetIn = 4;
        const pid_t child = fork();
        if (child == 0) _exit(opened().find("another build") != std::string::npos ? kRefused : kLetIn);
        int status = 0;
        ASSERT_EQ(waitpid(child, &status, 0), child);
        ASSERT_TRUE(WIFEXITED(status));
        EXPECT_EQ(WEXITSTATUS(status), kRefused);
        EXPECT_NE(opened(), "") << "a child that ended must not take the lock with it";
    }
    EXPECT_EQ(opened(), "") << "it is free when the build is over";
}

TEST_F(Stages, OnlyALockOfAnotherIsAnotherBuild) {
    const auto openedWhere = [&](int error) {
        const RefusedLock refused(error);
        return failureOf<Failure>([&] { StageStore store(folder()); });
    };
    EXPECT_NE(openedWhere(EWOULDBLOCK).find("another build"), std::string::npos);
    for (const int error : {ENOLCK, ENOSYS, EOPNOTSUPP})
        EXPECT_EQ(openedWhere(error), "") << std::strerror(error) << ": one goes on without";
    const std::string said = openedWhere(EIO);
    EXPECT_NE(said.find((folder() / "lock").string() + ": cannot be locked (" + std::strerror(EIO) + "); check"),
              std::string::npos)
        << said;
}

TEST(Photographs, AreReadAsManyAtATimeAsHalfTheMemoryHolds) {
    std::vector<scene::PhotoSource> photos(3);
    for (scene::PhotoSource& photo : photos)
        photo.camera.width = 400, photo.camera.height = 300;
    photos[1].camera.width = 800;
    constexpr std::uint64_t kOne = std::uint64_t{800} * 300 * 32; // the largest
    const std::size_t threads = photosTogether(photos, std::uint64_t{1} << 50);
    EXPECT_EQ(threads, photosTogether({}, std::uint64_t{1} << 50));
    EXPECT_EQ(photosTogether(photos, 0), 1u);
    EXPECT_EQ(photosTogether(photos, 4 * kOne - 1), 1u);
    EXPECT_EQ(photosTogether(photos, 4 * kOne), std::min<std::size_t>(2, threads));
    EXPECT_EQ(photosTogether(photos, 8 * kOne), std::min<std::size_t>(4, threads));
}

TEST(ScansOfABuild, ThatNoMemoryHoldsAreRefusedBeforeTheyAreRead) {
    std::vector<scene::ScanSource> scans(2);
    scans[1].name = "hall", scans[1].path = "site.e57";
    const auto saidOf = [&](std::int64_t points, std::uint64_t memoryBytes) {
        scans[1].pointCount = points;
        return failureOf<Failure>([&] { checkScanSizes(scans, memoryBytes); });
    };
    constexpr std::uint64_t kGiB = std::uint64_t{1} << 30;
    EXPECT_EQ(saidOf(1'000'000'000, std::uint64_t{48'000'000'000}), "");
    EXPECT_EQ(saidOf(-1, kGiB), "");
    EXPECT_EQ(saidOf(1'500'000'000, 64 * kGiB),
              "site.e57: scan 'hall' has 1500000000 points, and of one scan no more than 1431655765 can be read with "
              "this computer's memory of 64 GiB; export each setup by itself, or thinned");
    EXPECT_EQ(saidOf((std::int64_t{1} << 31) - 1, 1024 * kGiB), "");
    EXPECT_NE(saidOf(std::int64_t{1} << 31, 1024 * kGiB).find("no more than 2147483647 can"), std::string::npos);
    EXPECT_NE(saidOf(std::numeric_limits<std::int64_t>::max(), 1024 * kGiB), "");
}

TEST_F(Stages, WhatCannotBeWrittenLeavesNothing) {
    const std::filesystem::path nowhere = scratch_ / "nowhere" / "file";
    EXPECT_NE(failureOf<Failure>([&] { writeWhole(nowhere, std::string("text")); }).find(nowhere.string()),
              std::string::npos);
    const std::filesystem::path taken = scratch_ / "taken";
    std::filesystem::create_directories(taken / "folder");
    EXPECT_NE(failureOf<Failure>([&] { writeWhole(taken, std::string("text")); }), "") << "a folder is in the way";
    EXPECT_EQ(scratch_.fileCount(), 1u) << "and nothing temporary stays beside it";
    scene::writeFile(scratch_ / "file", "x");
    EXPECT_NE(failureOf<Failure>([&] { StageStore store(scratch_ / "file"); }), "");
}

TEST_F(Stages, ADamagedResultIsNamed) {
    const std::filesystem::path path = scratch_ / "points.json";
    writeWhole(path, json{{"points", 7}}.dump());
    EXPECT_EQ(readJson(path).at("points"), 7);
    for (const char* text : {"", "{", "{\"points\": 1e999}", "\xff"}) {
        scene::writeFile(path, text);
        EXPECT_EQ(failureOf<Failure>([&] { readJson(path); }).find(path.string()), 0u) << text;
    }
    std::filesystem::remove(path);
    EXPECT_EQ(failureOf<Failure>([&] { readJson(path); }).find(path.string()), 0u);
}

} // namespace
} // namespace app
