// A machine without a Vulkan driver: preparing works, drawing says what is missing.

#include "tests/app/made_sample.h"
#include "tests/app/program.h"
#include "tests/scene/scratch_folder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

namespace app {

namespace {

TEST(NoDevice, BuildWorksAndRenderSaysWhatToInstall) {
    const scene::ScratchFolder scratch;
    const std::string capture = (scratch / "capture").string(), scene = (scratch / "room.revisit").string(),
                      out = (scratch / "frames").string();
    const Outcome made = makeSample({capture, "--scene", "room", "--images", "4", "--size", "64x48"}, scratch.path());
    ASSERT_EQ(made.status, 0) << made.output;
    std::ofstream(scratch / "empty.json").close();
    // The loader says nothing of its own then; what the test wants is our line.
    for (const std::string driver : {"nowhere.json", "empty.json"}) {
        const std::string file = (scratch / driver).string();
        const std::vector<std::string> without{"/usr/bin/env", "VK_ICD_FILENAMES=" + file, "VK_DRIVER_FILES=" + file};
        const auto runWithout = [&](std::vector<std::string> command) {
            command.insert(command.begin(), without.begin(), without.end());
            return run(command, scratch.path());
        };
        const Outcome built = runWithout({kRevisit, "build", capture, "-o", scene, "--hold-out", "every:4:1"});
        EXPECT_EQ(built.status, 0) << built.output;
        const Outcome drawn = runWithout({kRevisit, "render", scene, "--out", out});
        EXPECT_EQ(drawn.status, 1) << drawn.output;
        EXPECT_EQ(std::count(drawn.output.begin(), drawn.output.end(), '\n'), 1) << "one line:\n" << drawn.output;
        EXPECT_EQ(drawn.output.find("revisit: Vulkan"), 0u) << drawn.output;
        EXPECT_NE(drawn.output.find("; install a Vulkan"), std::string::npos) << drawn.output;
        EXPECT_FALSE(std::filesystem::exists(out)) << "no folder for pictures that cannot be drawn";
        std::filesystem::remove_all(scene);
    }
    const Outcome drawn = run({kRevisit, "build", capture, "-o", scene, "--hold-out", "every:4:1"}, scratch.path());
    ASSERT_EQ(drawn.status, 0);
    EXPECT_EQ(run({kRevisit, "render", scene, "--out", out}, scratch.path()).status, 0) << "with a driver it draws";
}

} // namespace

} // namespace app
