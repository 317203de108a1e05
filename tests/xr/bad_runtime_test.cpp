// Runtimes that cannot be walked in, and paths that cannot be walked: one line that says what, where and what to do.

#include "tests/app/program.h"
#include "tests/app/sample_scene.h"
#include "tests/xr/fake.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace xr {

namespace {

class BadRuntime : public testing::Test {
  protected:
    void expectOneLine(const app::Outcome& outcome, const std::string& begins, const std::string& remedy) const {
        EXPECT_EQ(outcome.status, 1) << outcome.output;
        EXPECT_EQ(std::count(outcome.output.begin(), outcome.output.end(), '\n'), 1) << outcome.output;
        EXPECT_EQ(outcome.output.find("revisit: " + begins), 0u) << outcome.output;
        EXPECT_NE(outcome.output.find("; " + remedy), std::string::npos) << outcome.output;
    }

    app::SampleScene room_{"room", 2, "64x48"};
    scene::ScratchFolder scratch_;
    Fake fake_;
};

TEST_F(BadRuntime, WhatIsMissingIsSaidInOneLine) {
    struct Case {
        const char *told, *begins, *remedy;
    };
    for (const Case& c :
         {Case{"no-vulkan", "OpenXR runtime: the runtime has no Vulkan", "update the runtime"},
          {"no-headset", "Fake: no headset is connected", "start the headset's software"},
          {"views=1", "Fake, Eyes: the headset has no two views", "choose a stereo headset"},
          {"views=4", "Fake, Eyes: the headset has no two views", "choose a stereo headset"},
          {"no-srgb", "Fake, Eyes: the runtime takes no pictures of the format R8G8B8A8_SRGB", "update the runtime"},
          {"lose=xrCreateInstance:instance", "OpenXR runtime: xrCreateInstance failed",
           "start the headset's software"}}) {
        SCOPED_TRACE(c.told);
        expectOneLine(app::run(fake_.around(c.told, {REVISIT_PROGRAM, "walk", room_.scene()}), scratch_.path()),
                      c.begins, c.remedy);
    }
}

TEST_F(BadRuntime, NoRuntimeIsSaidInOneLine) {
    scene::writeFile(scratch_ / "empty.json", "");
    scene::writeFile(scratch_ / "gone.json",
                     R"({"file_format_version": "1.0.0", "runtime": {"library_path": "/nowhere/libnothing.so"}})");
    for (const char* manifest : {"nowhere.json", "empty.json", "gone.json"}) {
        SCOPED_TRACE(manifest);
        std::vector<std::string> command = fake_.around("", {REVISIT_PROGRAM, "walk", room_.scene()});
        command.insert(command.end() - 3, "XR_RUNTIME_JSON=" + (scratch_ / manifest).string());
        expectOneLine(app::run(command, scratch_.path()), "OpenXR loader: no OpenXR runtime answers",
                      "start the headset's software");
    }
}

TEST_F(BadRuntime, WhatRefusesNothingIsWalkedIn) {
    const app::Outcome walked = app::run(fake_.around("", {REVISIT_PROGRAM, "walk", room_.scene(), "--frames", "20",
                                                           "--rate", "72", "--out", (scratch_ / "out").string()}),
                                         scratch_.path());
    EXPECT_EQ(walked.status, 0) << walked.output;
    EXPECT_NE(walked.output.find("walking: Fake, Eyes"), std::string::npos) << walked.output;
    EXPECT_NE(walked.output.find("the headset keeps its own rate: it refuses 72 Hz"), std::string::npos)
        << walked.output;
}

TEST_F(BadRuntime, PathsWhoseTimeRunsBackwardsAreRefused) {
    const std::string pose = R"("position": [0, 1.6, 0], "orientation": [0, 0, 0, 1])";
    scene::writeFile(scratch_ / "back.json", R"({"space": "walk", "poses": [{"t": 0, )" + pose + R"(}, {"t": 2, )" +
                                                 pose + R"(}, {"t": 1, )" + pose + "}]}");
    const app::Outcome walked =
        app::run({REVISIT_PROGRAM, "walk", room_.scene(), "--headless", "--path", (scratch_ / "back.json").string()},
                 scratch_.path());
    expectOneLine(walked, (scratch_ / "back.json").string(), "");
}

} // namespace

} // namespace xr
