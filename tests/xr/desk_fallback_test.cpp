// With a window on the desk: the headset goes away, the walk goes on at the desk and leads the walker elsewhere, the
// headset comes back, and the walker goes on from there.

#include "tests/app/comparison.h"
#include "tests/app/sample_scene.h"
#include "tests/app/screen.h"
#include "tests/app/walker.h"
#include "tests/xr/monado.h"
#include "tests/xr/remote_head.h"

#include <gtest/gtest.h>

#include <cmath>

namespace xr {

namespace {

namespace fs = std::filesystem;

/// Where the head is, and how far it was carried since the frame before; metres.
struct Step {
    double seconds = 0, x = 0, z = 0, leap = 0;
};

std::vector<Step> stepsOf(const fs::path& record) {
    std::vector<Step> steps;
    const nlohmann::json path = app::readJson(record);
    for (const auto& pose : path.at("poses")) {
        Step step{pose.at("t"), pose.at("position").at(0), pose.at("position").at(2), 0};
        if (!steps.empty()) step.leap = std::hypot(step.x - steps.back().x, step.z - steps.back().z);
        steps.push_back(step);
    }
    return steps;
}

TEST(DeskFallback, TheWalkGoesOnAtTheDeskAndFromThereInTheHeadset) {
    if (!isMonadoThere() || !app::canHaveScreen()) GTEST_SKIP() << "Monado or a screen is missing";
    const app::SampleScene room("room", 6, "160x120");
    const scene::ScratchFolder scratch;
    const fs::path record = scratch / "path.json";
    app::Screen screen;
    Monado monado(Variant::service, {.hertz = 60, .width = 96, .height = 72});
    monado.start();
    app::Walker walker(monado.around(screen.around(scratch.path().string(), {REVISIT_PROGRAM, "walk", room.scene(),
                                                                             "--record", record.string()})),
                       scratch.path());
    ASSERT_TRUE(screen.focus("Revisit")) << walker.said();
    ASSERT_TRUE(walker.waitUntil([&] { return walker.timesSaid("walking: Monado") == 1; })) << walker.said();
    const auto keep = [&] {
        const int before = walker.timesSaid("kept revisit-");
        return walker.waitUntil([&] {
            screen.act({"key", "F12"});
            return walker.timesSaid("kept revisit-") > before;
        });
    };
    ASSERT_TRUE(keep()) << "the mirror shows something";
    {
        RemoteHead head(monado.port());
        head.send({});
        EXPECT_TRUE(walker.waitUntil([&] { return walker.timesSaid("right hand: Index") == 1; })) << walker.said();
    }
    monado.kill();
    ASSERT_TRUE(walker.waitUntil([&] { return walker.timesSaid("walking: the desk") == 1; })) << walker.said();
    ASSERT_TRUE(keep());
    const auto place = [&] { return app::placeOfLastPicture(walker.said()); };
    const glm::dvec3 atDesk = place();
    screen.act({"keydown", "w"});
    // However long frames take here.
    ASSERT_TRUE(walker.waitUntil([&] { return keep() && glm::distance(place(), atDesk) > 0.5; })) << walker.said();
    screen.act({"keyup", "w"});
    ASSERT_TRUE(keep());
    monado.start();
    ASSERT_TRUE(walker.waitUntil([&] { return walker.timesSaid("walking: Monado") == 2; })) << walker.said();
    ASSERT_TRUE(keep());
    screen.act({"key", "Escape"});
    const app::Outcome ended = walker.waitForEnd();
    ASSERT_EQ(ended.status, 0) << ended.output;

    const std::vector<Step> steps = stepsOf(record);
    // What was recorded on the way is one path, which render and walk will take.
    for (std::size_t i = 1; i < steps.size(); ++i)
        EXPECT_GE(steps[i].seconds, steps[i - 1].seconds);
    double walked = 0;
    for (const Step& step : steps) {
        walked += step.leap;
        // No frame carries anybody farther than a tenth of a second's walk.
        EXPECT_LT(step.leap, 0.2) << "at " << step.x << ", " << step.z;
    }
    EXPECT_GT(walked, 0.3) << "the key led on at the desk";
    EXPECT_GT(std::hypot(steps.back().x - steps.front().x, steps.back().z - steps.front().z), 0.3)
        << "and the headset did not bring the walker back";
}

} // namespace

} // namespace xr
