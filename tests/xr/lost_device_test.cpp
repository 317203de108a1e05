// A headset whose device is lost: its session ends with it, and another begins where the walker was.

#include "tests/app/comparison.h"
#include "tests/app/program.h"
#include "tests/app/sample_scene.h"
#include "tests/xr/fake.h"

#include <gtest/gtest.h>

namespace xr {

namespace {

int timesSaid(const std::string& text, const std::string& words) {
    int times = 0;
    for (std::size_t at = text.find(words); at != std::string::npos; at = text.find(words, at + 1))
        ++times;
    return times;
}

class LostDevice : public testing::Test {
  protected:
    /// submits: see tests/app/faulty_layer.cpp.
    app::Outcome walkLosing(const std::string& submits) const {
        std::vector<std::string> command =
            fake_.around("", {REVISIT_PROGRAM, "walk", room_.scene(), "--frames", "30", "--out", out(), "--record",
                              (scratch_ / "record.json").string()});
        const std::vector<std::string> faults{"/usr/bin/env", "VK_LAYER_PATH=" REVISIT_FAULTY_LAYER,
                                              "VK_INSTANCE_LAYERS=VK_LAYER_REVISIT_faulty",
                                              "REVISIT_FAULT_LOSE=" + submits};
        command.insert(command.begin(), faults.begin(), faults.end());
        return app::run(command, scratch_.path());
    }
    std::string out() const { return (scratch_ / "out").string(); }

    app::SampleScene room_{"room", 2, "64x48"};
    scene::ScratchFolder scratch_;
    Fake fake_;
};

TEST_F(LostDevice, AnotherSessionBeginsAndTheWalkGoesOn) {
    const app::Outcome walked = walkLosing("21");
    ASSERT_EQ(walked.status, 0) << walked.output;
    EXPECT_EQ(timesSaid(walked.output, "the device was lost, and is made anew"), 1) << walked.output;
    EXPECT_EQ(timesSaid(walked.output, "walking: Fake, Eyes"), 2) << walked.output;
    EXPECT_EQ(app::readJson(out() + "/report.json").at("frames"), 30);
    // In the runtime's room the head does no more than rise, by a millimetre a frame: so it must in the walk.
    const nlohmann::json poses = app::readJson(scratch_ / "record.json").at("poses");
    ASSERT_GE(poses.size(), 30u);
    for (const nlohmann::json& pose : poses) {
        EXPECT_EQ(pose.at("orientation"), poses[0].at("orientation"));
        for (const std::size_t axis : {0u, 2u})
            EXPECT_EQ(pose.at("position").at(axis), poses[0].at("position").at(axis));
        EXPECT_NEAR(pose.at("position").at(1).get<double>(), poses[0].at("position").at(1).get<double>(), 0.05);
    }
}

TEST_F(LostDevice, LostAgainAtOnceItIsTheEnd) {
    const app::Outcome walked = walkLosing("21,31");
    EXPECT_EQ(walked.status, 1) << walked.output;
    EXPECT_EQ(timesSaid(walked.output, "the device was lost again"), 1) << walked.output;
    EXPECT_EQ(walked.output.substr(walked.output.size() - 1), "\n");
}

} // namespace

} // namespace xr
