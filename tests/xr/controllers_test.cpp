// Controllers through a real runtime: what the test's hands do, and where the walker stands after it.

#include "app/walk_stage.h"
#include "input/locomotion.h"
#include "scene/scene_file.h"
#include "tests/app/made_sample.h"
#include "tests/app/program.h"
#include "tests/scene/scratch_folder.h"
#include "tests/xr/monado.h"
#include "tests/xr/remote_head.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <numbers>

#include <glm/geometric.hpp>

namespace xr {

namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kMillimetre = 1e-3, kHundredthOfADegree = 0.01 * kDegree;
constexpr int kRight = 1;

scene::Pose poseAt(const glm::dvec3& place, double heading, double tilt) {
    return scene::poseFromQuaternion(place, 0, std::sin(heading / 2), 0, std::cos(heading / 2)) *
           scene::poseFromQuaternion({0, 0, 0}, std::sin(tilt / 2), 0, 0, std::cos(tilt / 2));
}

/// A wearer with two controllers in a session of this process, frame by frame.
class Controllers : public testing::Test {
  protected:
    void SetUp() override {
        if (!isMonadoThere()) GTEST_SKIP() << "Monado is missing; ./dev test provides it";
        const auto path = [&](const char* name) { return (scratch_ / name).string(); };
        const app::Outcome made = app::makeSample(
            {path("capture"), "--scene", "room", "--images", "4", "--size", "160x120", "--samples", "1"},
            scratch_.path());
        ASSERT_EQ(made.status, 0) << made.output;
        const app::Outcome built =
            app::run({REVISIT_PROGRAM, "build", path("capture"), "-o", path("a.revisit")}, scratch_.path());
        ASSERT_EQ(built.status, 0) << built.output;
        for (const std::string& setting : monado_.environment()) {
            const std::size_t equals = setting.find('=');
            setenv(setting.substr(0, equals).c_str(), setting.substr(equals + 1).c_str(), 1);
        }
        for (const char* elsewhere : {"DISPLAY", "WAYLAND_DISPLAY"})
            unsetenv(elsewhere);

        scene_ = scene::openScene(path("a.revisit"));
        stage_.emplace(app::WalkStage::inHeadset(app::DrawnScene(scene_), std::make_unique<Runtime>()));
        head_.emplace(monado_.port());
        state_.stageFromHead = remotePose(poseAt({0.1, 1.6, 0.2}, 0.3, -0.1));
        head_->send(state_);
        // A session begins without focus, and controllers say nothing then.
        for (int i = 0; i < 500 && stage_->actions()->controller(kRight).empty(); ++i)
            frame();
        ASSERT_EQ(stage_->actions()->controller(kRight), "Index");
        surroundings_.hit = [](const glm::dvec3& from, const glm::dvec3& d) -> std::optional<input::Surface> {
            if (d.y >= 0) return std::nullopt;
            return input::Surface{from - (from.y / d.y) * d, {0, 1, 0}};
        };
    }

    /// One frame of the session; draws nothing, since nobody looks.
    void frame() {
        Frame frame;
        do
            frame = stage_->source().begin();
        while (frame.kind == Frame::Kind::skip);
        ASSERT_EQ(frame.kind, Frame::Kind::draw);
        wants_ = {};
        stage_->actions()->read(stage_->headset()->displayTime(), wants_);
        wants_.trackingFromHead = frame.trackingFromHead;
        wants_.seconds = 1.0 / 90;
        walker_ = input::step(walker_, wants_, settings_, surroundings_);
        render::Renderer& renderer = stage_->rendererFor(stage_->source());
        std::array<render::EyeOutput, kEyes> outputs;
        for (std::size_t eye = 0; eye < kEyes; ++eye)
            outputs[eye].image = frame.images[eye].image, outputs[eye].layer = frame.images[eye].layer;
        renderer.draw(frame.eyes, {}, outputs);
        stage_->source().end(frame);
    }

    /// The hands as they are in state_, seen by the walker.
    void say() {
        head_->send(state_);
        // Head and hands are predicted for the next frame from what was sent before it begins.
        frame();
        frame();
    }

    glm::dvec3 headNow() const { return walker_.rig.toWalk(wants_.trackingFromHead.translation); }
    double headingNow() const { return input::headingOf(walker_.rig.toWalk(wants_.trackingFromHead).rotation); }

    scene::ScratchFolder scratch_;
    Monado monado_{Variant::inproc, {.hertz = 200, .width = 64, .height = 48, .validation = false}};
    scene::Scene scene_;
    std::optional<app::WalkStage> stage_;
    std::optional<RemoteHead> head_;
    RemoteState state_;
    input::Wants wants_;
    input::Locomotion walker_;
    input::LocomotionSettings settings_;
    input::Surroundings surroundings_;
};

TEST_F(Controllers, TheHandsAreWhereTheyWerePut) {
    const scene::Pose grip = poseAt({0.3, 1.1, -0.2}, 0.4, -0.6);
    state_.right.stageFromGrip = remotePose(grip);
    say();
    EXPECT_TRUE(wants_.hands[kRight].isTracked);
    EXPECT_LT(glm::distance(wants_.hands[kRight].trackingFromGrip.translation, grip.translation), kMillimetre);
    EXPECT_LT(glm::distance(wants_.trackingFromHead.translation, glm::dvec3(0.1, 1.6, 0.2)), kMillimetre);
    EXPECT_NEAR(input::headingOf(wants_.trackingFromHead.rotation), 0.3, kHundredthOfADegree);
    state_.right.active = false;
    say();
    EXPECT_FALSE(wants_.hands[kRight].isTracked);
}

TEST_F(Controllers, TeleportGoesWhereTheHandPointed) {
    state_.right.stageFromGrip = remotePose(poseAt({0.3, 1.1, -0.2}, 0.4, -0.6));
    state_.right.a = true;
    say();
    ASSERT_TRUE(walker_.target && walker_.target->isAllowed());
    const scene::Pose aim = wants_.hands[kRight].trackingFromAim;
    const glm::dvec3 direction = -aim.rotation[2];
    const glm::dvec3 expected = aim.translation - (aim.translation.y / direction.y) * direction;
    const double heading = headingNow();
    state_.right.a = false;
    say();
    EXPECT_LT(glm::distance(headNow(), expected + glm::dvec3(0, 1.6, 0)), kMillimetre);
    EXPECT_NEAR(headingNow(), heading, kHundredthOfADegree);
    EXPECT_GT(glm::distance(headNow(), glm::dvec3(0.1, 1.6, 0.2)), 0.5) << "it went somewhere";
}

TEST_F(Controllers, TheStickSnapsByThirtyDegrees) {
    const glm::dvec3 place = headNow();
    const double heading = headingNow();
    for (const float stick : {1.0f, 0.0f, 1.0f, 0.0f}) {
        state_.right.stick = {stick, 0};
        say();
    }
    EXPECT_NEAR(headingNow(), heading - 60 * kDegree, kHundredthOfADegree);
    EXPECT_LT(glm::distance(headNow(), place), kMillimetre);
}

TEST_F(Controllers, RecentreBringsTheWearerBackToTheRigsPlace) {
    walker_.rig = {{2, 0, -3}, 0.8, 1};
    state_.stageFromHead = remotePose(poseAt({-0.7, 1.5, 0.9}, -1.2, 0.2));
    say();
    state_.right.stickClick = true;
    say();
    state_.right.stickClick = false;
    say();
    EXPECT_LT(glm::distance(headNow(), glm::dvec3(2, 1.5, -3)), kMillimetre);
    EXPECT_NEAR(headingNow(), 0.8, kHundredthOfADegree);
}

TEST_F(Controllers, AGrabbedWorldHangsOnTheHand) {
    const glm::dvec3 from{0.3, 1.1, -0.2}, to{-0.1, 1.4, -0.5};
    state_.left.stageFromGrip = remotePose(poseAt(from, 0.2, 0));
    say();
    state_.left.squeeze = 1;
    say();
    ASSERT_TRUE(wants_.hands[0].grabs);
    state_.left.stageFromGrip = remotePose(poseAt(to, 1.0, 0.4));
    say();
    EXPECT_LT(glm::distance(walker_.rig.origin, from - to), kMillimetre);
    EXPECT_NEAR(walker_.rig.yaw, 0, kHundredthOfADegree);
    state_.left.squeeze = 0;
    say();
    EXPECT_LT(glm::distance(walker_.rig.origin, from - to), kMillimetre) << "and stays when it is let go";
}

} // namespace

} // namespace xr
