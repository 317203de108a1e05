// The headset in a runtime that refuses, loses and forgets.

#include "render/post/rescale.h"
#include "tests/xr/fake.h"
#include "tests/xr/headset_rig.h"

#include "scene/errors.h"
#include "xr/check.h"

#include <gtest/gtest.h>

namespace xr {

namespace {

class FakeHeadset : public testing::Test {
  protected:
    void SetUp() override { fake_.enter(); }
    void TearDown() override { EXPECT_EQ(fake_.alive(), 0) << "objects of the runtime are left over"; }

    /// Until it is lost; false if it ends, throws, or goes on and on.
    static bool isLostSoon(Headset& headset) {
        for (int i = 0; i < 20; ++i) {
            const Frame frame = headset.begin();
            if (frame.kind == Frame::Kind::lost) return true;
            if (frame.kind == Frame::Kind::end) return false;
            if (frame.kind == Frame::Kind::draw) headset.end(frame);
        }
        return false;
    }

    static void draw(HeadsetRig& rig) {
        const std::optional<Frame> frame = rig.nextDrawn();
        ASSERT_TRUE(frame);
        rig.headset().end(*frame);
    }

    Fake fake_;
};

TEST_F(FakeHeadset, TakesASwapchainForEachEyeWhereLayersAreRefused) {
    for (const char* words : {"", "no-arrays"}) {
        Fake::tell(words);
        HeadsetRig rig;
        std::optional<Frame> frame = rig.nextDrawn();
        ASSERT_TRUE(frame);
        EXPECT_EQ(frame->images[0].image != frame->images[1].image, std::string(words) == "no-arrays");
        EXPECT_EQ(frame->images[1].layer, std::string(words) == "no-arrays" ? 0u : 1u);
        rig.drawAndCheck(*frame);
        rig.headset().end(*frame);
        for (const std::string& message : rig.device().validationMessages())
            ADD_FAILURE() << message;
    }
}

TEST_F(FakeHeadset, IsGivenNoDepthWhereNoneIsTaken) {
    Fake::tell("no-depth");
    HeadsetRig rig;
    EXPECT_FALSE(rig.headset().takesDepth());
    EXPECT_FALSE(rig.headset().askForRate(90)) << "there is no choice";
    std::optional<Frame> frame = rig.nextDrawn();
    ASSERT_TRUE(frame);
    rig.drawAndCheck(*frame);
    rig.headset().end(*frame);
    EXPECT_EQ(rig.headset().hiddenShareOf(0), 0);
}

TEST_F(FakeHeadset, IsToldHowMuchOfItsImagesWasDrawn) {
    HeadsetRig rig;
    for (const double scale : {1.0, 0.5, 0.37, 1.0}) {
        std::optional<Frame> frame = rig.nextDrawn();
        ASSERT_TRUE(frame);
        rig.drawAndCheck(*frame, scale);
        rig.headset().end(*frame);
        const XrRect2Di shown = fake_.shown();
        EXPECT_EQ(shown.offset.x, 0);
        EXPECT_EQ(shown.offset.y, 0);
        EXPECT_EQ(shown.extent.width, render::scaledSide(rig.headset().width(), scale));
        EXPECT_EQ(shown.extent.height, render::scaledSide(rig.headset().height(), scale));
    }
    // Who says nothing of it has drawn all.
    draw(rig);
    EXPECT_EQ(fake_.shown().extent.width, rig.headset().width());
    for (const std::string& message : rig.device().validationMessages())
        ADD_FAILURE() << message;
}

TEST_F(FakeHeadset, KeepsTheLastPlaceWhileTheHeadIsNotTracked) {
    HeadsetRig rig;
    Fake::tell("untracked");
    std::optional<Frame> frame = rig.nextDrawn();
    ASSERT_TRUE(frame);
    rig.headset().end(*frame);
    EXPECT_FALSE(frame->isTracked);
    EXPECT_EQ(frame->trackingFromHead.translation, glm::dvec3(0, static_cast<double>(1.6f), 0)) << "nothing is known";

    Fake::tell("");
    const std::optional<Frame> tracked = rig.nextDrawn();
    ASSERT_TRUE(tracked);
    rig.headset().end(*tracked);
    EXPECT_TRUE(tracked->isTracked);

    Fake::tell("untracked");
    frame = rig.nextDrawn();
    ASSERT_TRUE(frame);
    rig.headset().end(*frame);
    EXPECT_FALSE(frame->isTracked);
    EXPECT_EQ(frame->trackingFromHead.translation, tracked->trackingFromHead.translation);
    EXPECT_EQ(frame->eyes[1].worldFromEye.translation, tracked->eyes[1].worldFromEye.translation);

    Fake::tell("");
    frame = rig.nextDrawn();
    ASSERT_TRUE(frame);
    rig.headset().end(*frame);
    EXPECT_TRUE(frame->isTracked);
    EXPECT_GT(frame->trackingFromHead.translation.y, tracked->trackingFromHead.translation.y);
}

TEST_F(FakeHeadset, CountsTheRefreshesThatWentByWithoutAFrame) {
    Fake::tell("rate");
    HeadsetRig rig;
    for (const auto& [words, missed] : {std::pair{"late", 0}, {"", 0}, {"late", 2}, {"late", 2}, {"", 0}}) {
        Fake::tell(words);
        const std::optional<Frame> frame = rig.nextDrawn();
        ASSERT_TRUE(frame);
        rig.headset().end(*frame);
        EXPECT_EQ(frame->refreshesMissed, missed) << "nobody was late for the first frame";
    }
}

TEST_F(FakeHeadset, KnowsOfNoRefreshesWhereTheRuntimeSaysNoRate) {
    HeadsetRig rig;
    const std::optional<Frame> frame = rig.nextDrawn();
    ASSERT_TRUE(frame);
    rig.headset().end(*frame);
    EXPECT_FALSE(frame->refreshesMissed);
}

TEST_F(FakeHeadset, SaysOnceThatItWasRecentred) {
    HeadsetRig rig;
    draw(rig);
    Fake::tell("recentred");
    int times = 0;
    for (int i = 0; i < 5; ++i) {
        const std::optional<Frame> frame = rig.nextDrawn();
        ASSERT_TRUE(frame);
        rig.headset().end(*frame);
        if (frame->wasRecentred) ++times;
    }
    EXPECT_EQ(times, 1);
}

TEST_F(FakeHeadset, EndsWhenAskedTo) {
    HeadsetRig rig;
    draw(rig);
    EXPECT_TRUE(rig.headset().isRunning());
    rig.headset().requestExit();
    EXPECT_FALSE(rig.nextDrawn());
    EXPECT_EQ(rig.headset().begin().kind, Frame::Kind::skip);
}

class LostAt : public FakeHeadset, public testing::WithParamInterface<std::tuple<std::string, std::string>> {
  protected:
    std::string words() const { return "lose=" + std::get<0>(GetParam()) + ":" + std::get<1>(GetParam()); }
};

class LostWhileWalking : public LostAt {};

TEST_P(LostWhileWalking, IsLostAndStaysLost) {
    for (const bool isWorn : {true, false}) {
        Fake::tell("");
        HeadsetRig rig;
        if (isWorn) draw(rig);
        Fake::tell(words());
        if (isWorn && std::get<0>(GetParam()) == "xrBeginSession") continue; // it has begun
        if (std::get<0>(GetParam()) == "xrEndSession") {
            draw(rig);
            rig.headset().requestExit();
        }
        EXPECT_TRUE(isLostSoon(rig.headset()));
        EXPECT_EQ(rig.headset().begin().kind, Frame::Kind::lost);
        Fake::tell("");
        EXPECT_EQ(rig.headset().begin().kind, Frame::Kind::lost) << "what was lost does not come back";
        rig.headset().requestExit();
    }
}

const auto kBoth = testing::Values("session", "instance");
const auto nameOf = [](const auto& lost) { return std::get<0>(lost.param) + "_" + std::get<1>(lost.param); };

INSTANTIATE_TEST_SUITE_P(EveryCall, LostWhileWalking,
                         testing::Combine(testing::Values("xrPollEvent", "xrBeginSession", "xrWaitFrame",
                                                          "xrBeginFrame", "xrAcquireSwapchainImage",
                                                          "xrWaitSwapchainImage", "xrLocateViews", "xrLocateSpace",
                                                          "xrReleaseSwapchainImage", "xrEndFrame", "xrEndSession"),
                                          kBoth),
                         nameOf);

class LostWhileStarting : public LostAt {};

TEST_P(LostWhileStarting, IsOneExceptionAndLeavesNothing) {
    Fake::tell(words());
    EXPECT_THROW(HeadsetRig(), std::runtime_error); // Lost, or a Failure where there is no session yet
    Fake::tell("");
    HeadsetRig rig;
    draw(rig);
}

INSTANTIATE_TEST_SUITE_P(EveryCall, LostWhileStarting,
                         testing::Combine(testing::Values("xrCreateInstance", "xrCreateVulkanInstanceKHR",
                                                          "xrCreateSession", "xrEnumerateReferenceSpaces",
                                                          "xrCreateReferenceSpace", "xrEnumerateSwapchainFormats",
                                                          "xrCreateSwapchain", "xrEnumerateSwapchainImages"),
                                          kBoth),
                         nameOf);

} // namespace

} // namespace xr
