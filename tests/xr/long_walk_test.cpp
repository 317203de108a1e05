// Walks that go on and on hold no more at the end than at the beginning; and neither Vulkan's nor OpenXR's validation
// layer has a word to say.

#include "tests/app/comparison.h"
#include "tests/app/sample_scene.h"
#include "tests/app/walker.h"
#include "tests/repetitions.h"
#include "tests/xr/monado.h"
#include "tests/xr/remote_head.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

namespace xr {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double kMemoryGrowth = 1.001; ///< once all that the path shows has been drawn

/// About the place where a walk begins, for so long.
void writePath(const fs::path& path, double seconds) {
    json poses = json::array();
    for (double t = 0; t <= seconds; t += 0.05) {
        const double yaw = std::sin(t);
        poses.push_back({{"t", t},
                         {"position", {0.5 * std::sin(0.7 * t), 1.5 + 0.1 * std::sin(t), 0.4 * std::sin(0.3 * t)}},
                         {"orientation", {0, std::sin(yaw / 2), 0, std::cos(yaw / 2)}}});
    }
    scene::writeFile(path, json{{"space", "walk"}, {"poses", poses}}.dump());
}

TEST(LongWalk, ManyFramesTakeNoMoreThanTheFirstFewThousand) {
    const int many = tests::areLong() ? 20000 : 7000;
    const app::SampleScene room("room", 4, "40x30");
    const scene::ScratchFolder scratch;
    const fs::path path = scratch / "path.json", out = scratch / "out";
    writePath(path, 30);
    // Frames as small as these are drawn on one thread in half the time: waking others costs more than they do.
    app::Walker walker(app::givingMemoryBack({"/usr/bin/env", "LP_NUM_THREADS=0", REVISIT_PROGRAM, "walk", room.scene(),
                                              "--headless", "--path", path.string(), "--rate", "1000", "--size",
                                              "32x24", "--out", out.string(), "--picture-every", "1000"}),
                       scratch.path());
    const auto isKept = [&](const char* name) { return [&out, name] { return fs::exists(out / name); }; };
    ASSERT_TRUE(walker.waitUntil(isKept("frame-005000-right.png"))) << walker.said();
    const app::Holdings early = walker.holdings();
    ASSERT_TRUE(walker.waitUntil(isKept(many == 20000 ? "frame-020000-right.png" : "frame-007000-right.png")))
        << walker.said();
    const app::Holdings late = walker.holdings();
    walker.interrupt();
    const app::Outcome ended = walker.waitForEnd();
    EXPECT_EQ(ended.status, 0) << ended.output;
    std::printf("%d frames: %.2f MiB after 5,000, %.2f MiB at the end\n", many,
                static_cast<double>(early.memoryBytes) / (1 << 20), static_cast<double>(late.memoryBytes) / (1 << 20));
    ASSERT_GT(early.memoryBytes, 0u);
    EXPECT_LE(static_cast<double>(late.memoryBytes), kMemoryGrowth * static_cast<double>(early.memoryBytes));
    EXPECT_LE(late.files, early.files + 1) << "but for a picture that is being written";
    EXPECT_EQ(late.threads, early.threads);

    const json report = app::readJson(out / "report.json");
    EXPECT_GT(report.at("frames"), many);
    EXPECT_GT(report.at("frame_ms").at("p99"), 0);
}

/// The settings of Vulkan's validation layer: all it knows, into a file.
class VulkanEar {
  public:
    explicit VulkanEar(const fs::path& folder) : folder_(folder) {
        scene::writeFile(folder / "vk_layer_settings.txt",
                         "khronos_validation.debug_action = VK_DBG_LAYER_ACTION_LOG_MSG\n"
                         "khronos_validation.report_flags = error,warn,info\n"
                         "khronos_validation.enables = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT\n"
                         "khronos_validation.log_filename = " +
                             (folder / "vulkan.txt").string() + "\n");
    }

    std::vector<std::string> around(const std::vector<std::string>& command) const {
        std::vector<std::string> words{"/usr/bin/env", "VK_INSTANCE_LAYERS=VK_LAYER_KHRONOS_validation",
                                       "VK_LAYER_SETTINGS_PATH=" + folder_.string()};
        words.insert(words.end(), command.begin(), command.end());
        return words;
    }

    /// That it listened at all stands there as information.
    void expectSilence() const {
        const std::string text = scene::bytesOfFile(folder_ / "vulkan.txt");
        EXPECT_NE(text.find("Validation Information"), std::string::npos) << "the layer was not there:\n" << text;
        EXPECT_EQ(text.find("Validation Error"), std::string::npos) << text;
        EXPECT_EQ(text.find("Validation Warning"), std::string::npos) << text;
    }

  private:
    fs::path folder_;
};

TEST(ValidationLayers, AreSilentWithoutADisplay) {
    const app::SampleScene room("room", 6, "160x120");
    const scene::ScratchFolder scratch;
    writePath(scratch / "path.json", 1);
    const VulkanEar ear(scratch.path());
    const app::Outcome walked = app::run(
        ear.around({REVISIT_PROGRAM, "walk", room.scene(), "--headless", "--path", (scratch / "path.json").string(),
                    "--size", "96x72", "--out", (scratch / "out").string(), "--picture-every", "30"}),
        scratch.path());
    EXPECT_EQ(walked.status, 0) << walked.output;
    ear.expectSilence();
}

TEST(ValidationLayers, AreSilentInAHeadsetThatComesBack) {
    if (!isMonadoThere()) GTEST_SKIP() << "Monado is missing";
    const app::SampleScene room("room", 6, "160x120");
    const scene::ScratchFolder scratch;
    const VulkanEar ear(scratch.path());
    Monado monado(Variant::service, {.hertz = 100, .width = 96, .height = 72, .validation = true});
    monado.start();
    const fs::path out = scratch / "out";
    app::Walker walker(monado.around(ear.around({REVISIT_PROGRAM, "walk", room.scene(), "--out", out.string(),
                                                 "--picture-every", "20", "--frames", "300"})),
                       scratch.path());
    ASSERT_TRUE(walker.waitUntil([&] { return fs::exists(out / "frame-000040-right.png"); })) << walker.said();
    monado.restart();
    ASSERT_TRUE(walker.waitUntil([&] { return walker.timesSaid("walking: ") == 2; })) << walker.said();
    const app::Outcome walked = walker.waitForEnd();
    EXPECT_EQ(walked.status, 0) << walked.output;
    EXPECT_EQ(app::readJson(out / "report.json").at("frames"), 300);
    ear.expectSilence();
    EXPECT_EQ(monado.validationMessages(), "");
}

} // namespace

} // namespace xr
