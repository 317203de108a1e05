#include "app/walk_record.h"

#include "input/path.h"
#include "tests/scene/scratch_folder.h"

#include <gtest/gtest.h>

#include <cmath>

namespace app {

namespace {

scene::Pose headAt(double x) {
    return {glm::dmat3(1), {x, 1.6, 0}};
}

TEST(WalkRecord, ComesBackWithTheRig) {
    const scene::ScratchFolder scratch;
    WalkOptions options;
    options.record = scratch / "path.json";
    WalkRecord record(options);
    for (int i = 0; i < 8; ++i)
        record.addPose(1.0 / 3 + 0.1 * i, headAt(i), {{0, 0, static_cast<double>(i)}, 0.1, 2});
    record.write({});
    const input::RecordedPath path = input::readPath(options.record);
    ASSERT_EQ(path.keys.size(), 8u);
    EXPECT_EQ(path.space, input::PathSpace::walk);
    for (int i = 0; i < 8; ++i) {
        const input::PathKey& key = path.keys[static_cast<std::size_t>(i)];
        EXPECT_EQ(key.seconds, 1.0 / 3 + 0.1 * i);
        EXPECT_EQ(key.spaceFromHead.translation.x, i);
        ASSERT_TRUE(key.rig);
        EXPECT_EQ(key.rig->origin.z, i);
        EXPECT_EQ(key.rig->yaw, 0.1);
        EXPECT_EQ(key.rig->scale, 2);
    }
}

TEST(WalkRecord, ATimeRoundedToBeforeTheLastLeavesAPathThatCanBeRead) {
    const scene::ScratchFolder scratch;
    WalkOptions options;
    options.record = scratch / "path.json";
    WalkRecord record(options);
    for (int i = 1; i < 100; ++i) {
        record.addPose(0.1 * i, headAt(0), {});
        record.addPose(std::nextafter(0.1 * i, 0.0), headAt(1), {});
    }
    record.write({});
    EXPECT_EQ(input::readPath(options.record).keys.size(), 198u) << "or it is refused";
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
