// The runtime is killed in the middle of a walk, again and again: the program lives, finds it again when it is back,
// and the walker stands where the walker stood.

#include "tests/app/comparison.h"
#include "tests/app/sample_scene.h"
#include "tests/app/walker.h"
#include "tests/xr/monado.h"
#include "tests/xr/remote_head.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include <algorithm>
#include <cstdio>

namespace xr {

namespace {

namespace fs = std::filesystem;

constexpr int kPictureEvery = 20, kRepetitions = 20, kSettled = 5;
constexpr double kMemoryAgain = 1.02;

/// Without controllers: the walker would be shown them.
const RemoteState kSomewhere{.stageFromHead = {{0, 0.19866933f, 0, 0.98006658f}, {0.3f, 1.5f, -0.4f}},
                             .left = {.active = false},
                             .right = {.active = false}};

int newestKept(const fs::path& folder) {
    int newest = -1;
    std::error_code absent;
    for (const auto& entry : fs::directory_iterator(folder, absent)) {
        int frame = 0;
        if (std::sscanf(entry.path().filename().c_str(), "frame-%d-right.png", &frame) == 1)
            newest = std::max(newest, frame);
    }
    return newest;
}

std::string nameOf(int frame, const char* eye) {
    char name[64];
    std::snprintf(name, sizeof name, "frame-%06d-%s.png", frame, eye);
    return name;
}

TEST(RuntimeDies, TwentyTimesAndTheWalkerIsBackWhereTheWalkerWas) {
    if (!isMonadoThere()) GTEST_SKIP() << "Monado is missing";
    const app::SampleScene room("room", 6, "160x120");
    const scene::ScratchFolder scratch;
    const fs::path out = scratch / "out", frames = scratch / "frames";
    Monado monado(Variant::service, {.hertz = 200, .width = 96, .height = 72});
    monado.start();
    app::Walker walker(
        monado.around(app::givingMemoryBack({REVISIT_PROGRAM, "walk", room.scene(), "--out", out.string(),
                                             "--picture-every", std::to_string(kPictureEvery)})),
        scratch.path());
    std::vector<int> kept; ///< a frame of each repetition, drawn when the head stood where it was sent
    app::Holdings settled, last;
    for (int repetition = 0; repetition <= kRepetitions; ++repetition) {
        ASSERT_TRUE(walker.waitUntil([&] { return walker.timesSaid("walking: ") > repetition; })) << walker.said();
        {
            RemoteHead head(monado.port());
            head.send(kSomewhere);
        }
        // The picture after the next was begun after that.
        const int before = newestKept(out);
        ASSERT_TRUE(walker.waitUntil([&] { return newestKept(out) >= std::max(before, 0) + 2 * kPictureEvery; }))
            << walker.said();
        kept.push_back(newestKept(out));
        last = walker.holdings();
        if (repetition <= kSettled)
            settled = {std::max(settled.memoryBytes, last.memoryBytes),
                       repetition == 0 ? last.files : std::min(settled.files, last.files),
                       std::max(settled.threads, last.threads)};
        std::printf("after %d: %.1f MiB, %zu files, %zu threads\n", repetition,
                    static_cast<double>(last.memoryBytes) / (1 << 20), last.files, last.threads);
        if (repetition == kRepetitions) break;
        monado.kill();
        ASSERT_TRUE(walker.waitUntil([&] { return walker.timesSaid("the headset is gone") > repetition; }))
            << walker.said();
        monado.start();
    }
    // A picture that is being written is a file, too.
    EXPECT_TRUE(walker.waitUntil([&] { return walker.holdings().files <= settled.files; })) << last.files;
    EXPECT_LE(last.threads, settled.threads);
    walker.interrupt();
    const app::Outcome ended = walker.waitForEnd();
    EXPECT_EQ(ended.status, 0) << ended.output;
    EXPECT_LE(static_cast<double>(last.memoryBytes), kMemoryAgain * static_cast<double>(settled.memoryBytes));

    const app::Outcome drawn = app::run({REVISIT_PROGRAM, "render", room.scene(), "--out", frames.string(), "--cameras",
                                         (out / "cameras.json").string(), "--eyes", "1"},
                                        scratch.path());
    ASSERT_EQ(drawn.status, 0) << drawn.output;
    for (const char* eye : {"left", "right"})
        for (const int frame : kept) {
            const std::string name = nameOf(frame, eye);
            EXPECT_EQ(scene::bytesOfFile(out / name), scene::bytesOfFile(out / nameOf(kept[0], eye)))
                << name << ": another place";
            EXPECT_EQ(scene::bytesOfFile(out / name), scene::bytesOfFile(frames / name)) << name;
        }
}

} // namespace

} // namespace xr
