#include "app/walk_record.h"

#include "input/path.h"
#include "tests/scene/scratch_folder.h"

#include <gtest/gtest.h>

namespace app {

namespace {

scene::Pose headAt(double x) {
    return {glm::dmat3(1), {x, 1.6, 0}};
}

TEST(WalkRecord, AWalkThatChangesFromDeskToHeadsetAndBackIsOnePath) {
    const scene::ScratchFolder scratch;
    WalkOptions options;
    options.record = scratch / "path.json";
    WalkRecord record(options);
    // The desk's clock, a headset's that starts anew, the desk's again, which has gone on.
    const double seconds[] = {0, 0.3, 17.1, 0, 0.1, 5.7, 29.9, 30};
    for (int i = 0; i < 8; ++i)
        record.addPose(seconds[i], headAt(i), {{0, 0, static_cast<double>(i)}, 0.1, 2});
    record.write({});

    const input::RecordedPath path = input::readPath(options.record);
    ASSERT_EQ(path.keys.size(), 8u);
    for (std::size_t i = 1; i < 8; ++i)
        EXPECT_GE(path.keys[i].seconds, path.keys[i - 1].seconds) << i;
    EXPECT_EQ(path.keys[2].seconds, 17.1) << "one clock is taken as it is";
    EXPECT_EQ(path.keys[3].seconds, 17.1) << "a jump in place";
    EXPECT_NEAR(path.keys[5].seconds, 17.1 + 5.7, 1e-12) << "and no other";
    for (std::size_t i = 0; i < 8; ++i) {
        EXPECT_EQ(path.keys[i].spaceFromHead.translation.x, static_cast<double>(i));
        ASSERT_TRUE(path.keys[i].rig);
        EXPECT_EQ(path.keys[i].rig->origin.z, static_cast<double>(i));
    }
}

TEST(WalkRecord, TimesNeverRunBackByARounding) {
    const scene::ScratchFolder scratch;
    WalkOptions options;
    options.record = scratch / "path.json";
    WalkRecord record(options);
    for (int i = 0; i < 3000; ++i) {
        const double last = 0.1 * i + 1e6 / 3;
        record.addPose(last, headAt(0), {});
        record.addPose(1.0 / (3 + i), headAt(1), {});
    }
    record.write({});
    EXPECT_EQ(input::readPath(options.record).keys.size(), 6000u) << "or it is refused";
}

TEST(WalkRecord, NobodyAskedNothingIsWritten) {
    const scene::ScratchFolder scratch;
    WalkOptions options;
    WalkRecord record(options);
    record.addPose(0, headAt(0), {});
    record.write({});
    options.record = scratch / "path.json";
    WalkRecord(options).write({});
    EXPECT_EQ(scratch.fileCount(), 0u) << "a path has at least one pose";
}

} // namespace

} // namespace app
