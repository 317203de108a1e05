// The headset by itself, in Monado, against what its head was told.

#include "tests/render/tuning.h"
#include "tests/xr/headset_rig.h"
#include "tests/xr/remote_head.h"

#include <gtest/gtest.h>

#include <cmath>

namespace xr {

namespace {

/// Where heads may be: upright, turned, and on its way to the floor.
std::vector<RemotePose> somePoses() {
    std::vector<RemotePose> poses;
    for (const auto& [angle, x, y, z] :
         {std::array{0.f, 0.f, 1.6f, 0.f}, {0.6f, 0.3f, 1.2f, -0.7f}, {-2.f, -1.f, 0.4f, 2.f}})
        poses.push_back({{0, std::sin(angle / 2), 0, std::cos(angle / 2)}, {x, y, z}});
    return poses;
}

scene::Pose poseOf(const RemotePose& pose) {
    const auto& [q, p] = pose;
    return scene::poseFromQuaternion({p[0], p[1], p[2]}, q[0], q[1], q[2], q[3]);
}

double distanceOf(const scene::Pose& a, const scene::Pose& b) {
    double worst = glm::length(a.translation - b.translation);
    for (int column = 0; column < 3; ++column)
        worst = std::max(worst, glm::length(a.rotation[column] - b.rotation[column]));
    return worst;
}

/// The headset in either kind of Monado.
class HeadsetIn : public testing::TestWithParam<Variant> {
  protected:
    void SetUp() override {
        if (!isMonadoThere()) GTEST_SKIP() << "Monado is missing";
        monado_.emplace(GetParam(), MonadoOptions{.hertz = 200, .width = 96, .height = 64, .validation = true});
        if (GetParam() == Variant::service) monado_->start();
        enter(*monado_);
    }

    static void expectSilence(const HeadsetRig& rig) {
        for (const std::string& message : rig.device().validationMessages())
            ADD_FAILURE() << message;
    }

    std::optional<Monado> monado_;
};

TEST_P(HeadsetIn, TheHeadIsWhereItWasSent) {
    HeadsetRig rig;
    RemoteHead head(monado_->port());
    for (const RemotePose& pose : somePoses()) {
        head.send({.stageFromHead = pose});
        const std::optional<Frame> frame = rig.nextDrawn();
        ASSERT_TRUE(frame);
        rig.headset().end(*frame);
        EXPECT_TRUE(frame->isTracked);
        EXPECT_LE(distanceOf(frame->trackingFromHead, poseOf(pose)), 1e-6);
        const glm::dvec3 apart = frame->eyes[1].worldFromEye.translation - frame->eyes[0].worldFromEye.translation;
        EXPECT_LE(glm::length(apart - 0.063 * frame->trackingFromHead.rotation[0]), 1e-6) << "63 mm to the right";
    }
    expectSilence(rig);
}

TEST_P(HeadsetIn, IsGivenColourAndDepth) {
    for (const bool isCard : {false, true}) { // which draws what a processor copies
        SCOPED_TRACE(isCard ? "drawn" : "copied");
        const render::Tuning tuning(isCard ? "card" : "");
        HeadsetRig rig;
        EXPECT_NE(rig.device().isProcessor(), isCard);
        EXPECT_TRUE(rig.headset().takesDepth());
        for (const double scale : {1.0, 0.5, 0.35, 1.0}) {
            std::optional<Frame> frame = rig.nextDrawn();
            ASSERT_TRUE(frame);
            rig.drawAndCheck(*frame, scale);
            rig.headset().end(*frame);
        }
        expectSilence(rig);
    }
    EXPECT_EQ(monado_->validationMessages(), "");
}

TEST_P(HeadsetIn, SaysWhatNoLensShowsAndTakesTheNearestRate) {
    HeadsetRig rig;
    EXPECT_EQ(rig.headset().askForRate(90), 200) << "the only one it has";
    const std::optional<Frame> frame = rig.nextDrawn();
    ASSERT_TRUE(frame);
    rig.headset().end(*frame);
    for (std::size_t eye = 0; eye < kEyes; ++eye) {
        EXPECT_GT(rig.headset().hiddenShareOf(eye), 0.01);
        EXPECT_LT(rig.headset().hiddenShareOf(eye), 0.5);
    }
}

INSTANTIATE_TEST_SUITE_P(Monado, HeadsetIn, testing::Values(Variant::inproc, Variant::service),
                         [](const auto& variant) {
                             return variant.param == Variant::inproc ? "InProcess" : "Service";
                         });

} // namespace

} // namespace xr
