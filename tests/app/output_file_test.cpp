// What results may take the place of.

#include "app/output_file.h"
#include "app/stage_store.h"
#include "scene/errors.h"

#include "tests/scene/scratch_folder.h"

#include <array>
#include <fstream>
#include <string>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace app {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

bool isPlan(const json& of) {
    return of.is_object() && of.value("revisit", json()) == "plan";
}

std::string refusalOfFile(const fs::path& file, const std::vector<fs::path>& inputs = {}) {
    return scene::failureOf<scene::Failure>([&] { checkReplaceableFile(file, inputs, isPlan); });
}

TEST(OutputFile, TakesThePlaceOfItsOwnKindAlone) {
    const scene::ScratchFolder scratch;
    EXPECT_EQ(refusalOfFile(scratch / "new.json"), "");
    scene::writeFile(scratch / "plan.json", R"({"revisit": "plan"})");
    EXPECT_EQ(refusalOfFile(scratch / "plan.json"), "");
    scene::writeFile(scratch / "empty.json", "");
    EXPECT_EQ(refusalOfFile(scratch / "empty.json"), "") << "as mktemp leaves one";
    for (const char* other : {R"({"revisit": "scene"})", "[1]", "\xff\xd8\xff\xe0 a photograph"}) {
        scene::writeFile(scratch / "other", other);
        EXPECT_THAT(refusalOfFile(scratch / "other"), HasSubstr("nothing that this command writes")) << other;
    }
    EXPECT_THAT(refusalOfFile(scratch.path()), HasSubstr("is a folder"));
    fs::create_symlink(scratch / "plan.json", scratch / "link.json");
    EXPECT_EQ(refusalOfFile(scratch / "link.json"), "");
    EXPECT_THAT(refusalOfFile(scratch / "link.json", {scratch / "plan.json"}), HasSubstr("this command reads it"));
    fs::create_symlink(scratch / "nowhere", scratch / "dangling.json");
    EXPECT_THAT(refusalOfFile(scratch / "dangling.json"), HasSubstr("is a link to what does not exist"));
    EXPECT_EQ(refusalOfFile("/dev/null"), "");
}

TEST(OutputFile, LinksStayLinksAndWhatIsNoFileIsWrittenTo) {
    const scene::ScratchFolder scratch;
    scene::writeFile(scratch / "real", "before");
    fs::create_symlink("real", scratch / "link");
    writeWhole(scratch / "link", std::string("after"));
    EXPECT_TRUE(fs::is_symlink(scratch / "link"));
    EXPECT_EQ(scene::bytesOfFile(scratch / "real"), "after");
    fs::create_symlink("new", scratch / "ahead");
    writeWhole(scratch / "ahead", std::string("there now"));
    EXPECT_TRUE(fs::is_symlink(scratch / "ahead"));
    EXPECT_EQ(scene::bytesOfFile(scratch / "new"), "there now");

    const fs::path pipe = scratch / "pipe";
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    const int reader = open(pipe.c_str(), O_RDWR | O_NONBLOCK); // neither end waits for the other
    ASSERT_GE(reader, 0);
    writeWhole(pipe, std::string("through it"));
    std::array<char, 32> read{};
    EXPECT_EQ(::read(reader, read.data(), read.size()), 10);
    close(reader);
    EXPECT_STREQ(read.data(), "through it");
    EXPECT_TRUE(fs::is_fifo(pipe));
    writeWhole("/dev/null", std::string("nothing"));
    EXPECT_TRUE(fs::is_character_file("/dev/null"));
    EXPECT_THAT(scene::failureOf<scene::Failure>([] { writeWhole("/dev/full", std::string("no room")); }),
                HasSubstr("cannot be written to"));
}

TEST(OutputFile, AReportAndWhatStandsBesideItAreReplacedByRunsOfTheirKind) {
    const scene::ScratchFolder scratch;
    const auto refusal = [&] {
        return scene::failureOf<scene::Failure>([&] {
            checkReplaceableReport(scratch.path(), isDrawnReport);
            checkReplaceableBeside(scratch.path(), isDrawnReport, std::array<std::string, 1>{"cameras.json"});
        });
    };
    EXPECT_EQ(refusal(), "");
    scene::writeFile(scratch / "other.json", "{}");
    EXPECT_EQ(refusal(), "");
    scene::writeFile(scratch / "cameras.json", "{}");
    EXPECT_THAT(refusal(), HasSubstr("holds cameras.json"));
    scene::writeFile(scratch / "report.json", R"({"of": "another hand"})");
    EXPECT_THAT(refusal(), HasSubstr("holds report.json"));
    scene::writeFile(scratch / "report.json", R"({"samples_drawn": {}, "frames": 3})");
    EXPECT_EQ(refusal(), "");
}

} // namespace
} // namespace app
