// The disk fills up at any point of a build or of drawing: one line that says so, nothing half-written under the name,
// and with more room it goes on as if nothing had happened. The small disk is one in memory, mounted in a namespace of
// its own.

#include "tests/app/made_sample.h"
#include "tests/app/program.h"
#include "tests/scene/scratch_folder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <numeric>

namespace app {

namespace {

constexpr double kShares[] = {0.02, 0.1, 0.25, 0.4, 0.55, 0.7, 0.8, 0.9, 0.97}; ///< of the room that is needed

/// sh -c SCRIPT with $1, $2, ... in a namespace where it may mount.
Outcome runInNamespace(const std::string& script, std::vector<std::string> arguments,
                       const scene::ScratchFolder& scratch) {
    std::vector<std::string> command{
        "/usr/bin/unshare", "--user", "--map-root-user", "--mount", "/bin/sh", "-c", script, "sh"};
    command.insert(command.end(), arguments.begin(), arguments.end());
    return run(command, scratch.path());
}

bool canMount(const scene::ScratchFolder& scratch) {
    std::filesystem::create_directories(scratch / "disk");
    return runInNamespace("mount -t tmpfs -o size=1m none \"$1\"", {(scratch / "disk").string()}, scratch).status == 0;
}

std::uintmax_t bytesIn(const std::filesystem::path& folder) {
    const auto files = filesOf(folder);
    return std::accumulate(files.begin(), files.end(), std::uintmax_t{0},
                           [](std::uintmax_t sum, const auto& file) { return sum + file.second.size(); });
}

/// All lines but the last say how far the program was; the last says what to do.
void expectOneFailure(const std::string& output, const std::string& where) {
    const std::string text = output.substr(0, output.find_last_not_of('\n') + 1);
    const std::size_t last = text.rfind('\n') + 1;
    EXPECT_EQ(text.find("revisit: " + where), last) << output;
    EXPECT_NE(text.find("; check that the disk has room", last), std::string::npos) << output;
    for (std::size_t at = 0; at < last; at = text.find('\n', at) + 1) {
        const std::string line = text.substr(at, text.find('\n', at) - at);
        EXPECT_TRUE(line.ends_with(" s")) << "no step of the program: " << line;
    }
}

class FullDisk : public testing::Test {
  protected:
    void SetUp() override {
        if (!canMount(scratch_)) GTEST_SKIP() << "because no file system can be mounted in a user namespace here";
        const Outcome made =
            makeSample({capture(), "--scene", "room", "--images", "6", "--size", "160x120"}, scratch_.path());
        ASSERT_EQ(made.status, 0) << made.output;
        const Outcome built =
            run({kRevisit, "build", capture(), "-o", whole(), "--hold-out", "every:3:1"}, scratch_.path());
        ASSERT_EQ(built.status, 0) << built.output;
    }
    std::string capture() const { return (scratch_ / "capture").string(); }
    std::string whole() const { return (scratch_ / "whole.revisit").string(); }
    std::string disk() const { return (scratch_ / "disk").string(); }

    scene::ScratchFolder scratch_;
};

TEST_F(FullDisk, ABuildSaysSoAndGoesOnWithMoreRoom) {
    const auto needed = static_cast<double>(bytesIn(whole()) + bytesIn(whole() + ".build"));
    const auto wanted = filesOf(whole());
    const std::string listing = (scratch_ / "listing.txt").string(), after = (scratch_ / "after").string();
    for (const double share : kShares) {
        const std::string size = std::to_string(static_cast<std::int64_t>(share * needed));
        std::filesystem::remove_all(after);
        const Outcome outcome = runInNamespace(R"(
            mount -t tmpfs -o size="$1" none "$2" || exit 99
            "$3" build "$4" -o "$2/small.revisit" --hold-out every:3:1; status=$?
            ls -A "$2" > "$5"
            mount -o remount,size=1g "$2" || exit 98
            "$3" build "$4" -o "$2/small.revisit" --hold-out every:3:1 2> /dev/null || exit 97
            cp -r "$2/small.revisit" "$6" && exit $status)",
                                               {size, disk(), kRevisit, capture(), listing, after}, scratch_);
        EXPECT_EQ(outcome.status, 1) << "with room for " << share << "\n" << outcome.output;
        expectOneFailure(outcome.output, disk() + "/small.revisit");
        EXPECT_EQ(scene::bytesOfFile(listing), "small.revisit.build\n") << "with room for " << share;
        EXPECT_TRUE(filesOf(after) == wanted)
            << "with room for " << share << ": another scene than without a full disk";
        std::printf("%3.0f %% of %.0f bytes: %s", 100 * share, needed,
                    outcome.output.substr(std::min(outcome.output.find("revisit: "), outcome.output.size())).c_str());
    }
}

TEST_F(FullDisk, ABuildNamesWhatOlderOnesLeft) {
    const Outcome outcome = runInNamespace(R"(
        mount -t tmpfs -o size=1g none "$1" || exit 99
        "$2" build "$3" -o "$1/small.revisit" 2> /dev/null || exit 98
        mount -o remount,size="$(df -k "$1" | awk 'NR == 2 { print $3 }')k" "$1" || exit 97
        "$2" build "$3" -o "$1/small.revisit" --no-cull)",
                                           {disk(), kRevisit, capture()}, scratch_);
    EXPECT_EQ(outcome.status, 1) << outcome.output;
    expectOneFailure(outcome.output, disk() + "/small.revisit");
    EXPECT_NE(
        outcome.output.find(" (results of earlier builds in " + disk() + "/small.revisit.build may be removed)\n"),
        std::string::npos)
        << outcome.output;
}

TEST_F(FullDisk, ASceneIsNotPutInPlaceOfTheDisk) {
    for (const char* mount : {"mount -t tmpfs none \"$1\"", "mount --bind \"$1\" \"$1\""}) {
        const Outcome outcome = runInNamespace(std::string(mount) + R"( || exit 99; exec "$2" build "$3" -o "$1")",
                                               {disk(), kRevisit, capture()}, scratch_);
        EXPECT_EQ(outcome.status, 1) << mount << "\n" << outcome.output;
        EXPECT_NE(outcome.output.find(disk() + ": is where a disk is mounted"), std::string::npos) << outcome.output;
        EXPECT_EQ(std::count(outcome.output.begin(), outcome.output.end(), '\n'), 1) << "at once: " << outcome.output;
        EXPECT_FALSE(std::filesystem::exists(disk() + ".build"));
    }
}

TEST_F(FullDisk, DrawingSaysSo) {
    const std::string frames = (scratch_ / "frames").string();
    const Outcome drawn = run({kRevisit, "render", whole(), "--out", frames, "--aux"}, scratch_.path());
    ASSERT_EQ(drawn.status, 0) << drawn.output;
    const auto needed = static_cast<double>(bytesIn(frames));
    for (const double share : kShares) {
        const std::string size = std::to_string(static_cast<std::int64_t>(share * needed));
        const Outcome outcome = runInNamespace(R"(
            mount -t tmpfs -o size="$1" none "$2" || exit 99
            "$3" render "$4" --out "$2/frames" --aux)",
                                               {size, disk(), kRevisit, whole()}, scratch_);
        EXPECT_EQ(outcome.status, 1) << "with room for " << share << "\n" << outcome.output;
        expectOneFailure(outcome.output, disk() + "/frames");
        std::printf("%3.0f %% of %.0f bytes: %s", 100 * share, needed, outcome.output.c_str());
    }
}

} // namespace

} // namespace app
