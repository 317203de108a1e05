// Work is dealt out otherwise on graphics cards: a pixel an invocation, large pieces by many workgroups, no looks at
// what is hidden. Pictures must be the same to the byte, as one driver computes them.

#include "render/shaders/shared/hole_words.h"
#include "render/shaders/shared/large_part.h"
#include "tests/render/studio.h"

#include <array>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

namespace render {
namespace {

class CardTest : public RenderTest {
  protected:
    /// The tests' device, as if it were a card.
    static const Device& card() {
        static const std::unique_ptr<Device> device = [] {
            testDevice(); // which makes the layers listen
            const char* before = std::getenv("REVISIT_TUNING");
            const std::string kept = before != nullptr ? before : "";
            setenv("REVISIT_TUNING", "card", 1);
            auto made = std::make_unique<Device>();
            if (before != nullptr)
                setenv("REVISIT_TUNING", kept.c_str(), 1);
            else
                unsetenv("REVISIT_TUNING");
            return made;
        }();
        return *device;
    }
    void SetUp() override {
        if (!testDevice().isProcessor()) GTEST_SKIP() << "draws as a card in any case";
    }
    void TearDown() override {
        RenderTest::TearDown();
        for (const std::string& message : card().validationMessages())
            ADD_FAILURE() << message;
    }

    /// Every way, from every place.
    static void expectSamePictures(const CutScene& scene, std::span<const scene::View> views,
                                   const scene::Coverage* coverage = nullptr) {
        Studio processor(scene, coverage), onCard(scene, coverage, card());
        for (const Way& way : ways()) {
            Quality quality = way.quality;
            quality.leavesOutHidden = false; // gaps that are filled anyway would differ
            for (std::size_t i = 0; i < views.size(); ++i)
                EXPECT_TRUE(isSame(processor.draw(views[i], quality), onCard.draw(views[i], quality)))
                    << way.name << ", view " << i;
        }
    }
};

TEST_F(CardTest, IsNoProcessor) {
    EXPECT_FALSE(card().isProcessor());
}

TEST_F(CardTest, ARoomIsDrawnAsByAProcessor) {
    // Neither side of whole words nor of whole parts, and rows wider than one workgroup fills the holes of.
    const scene::Camera eye = cameraOf(300, 90, 1.8);
    scene::Coverage coverage;
    coverage.cornerInWorld = glm::dvec3(-8);
    coverage.edgeMetres = 16;
    coverage.nodes.resize(1);
    coverage.nodes[0].unseen = scene::coverageMask(scene::coverageBit(2, 1, 2));
    const std::vector<scene::View> views{{eye, poseAt({0, 0, 0}, 0.2, 0)}, {eye, poseAt({0.8, 0.3, -1.1}, 2.1, 0.3)}};
    expectSamePictures(roomAllAround(), views, &coverage);
}

TEST_F(CardTest, WhatCoversThePictureIsDrawnAsByAProcessor) {
    // Before a wall: facing it, along it and with part of it behind the eye.
    const scene::Camera eye = cameraOf(150, 90, 1.4);
    const CutScene wall = cutInLevels({takePlane(cameraOf(120, 120, 1.5), {0, 0, 1}, 2)});
    std::vector<scene::View> views;
    for (const double distance : {0.05, 0.004, 1e-4})
        for (const double yaw : {0.0, 0.9, 1.5})
            views.push_back({eye, poseAt({0.0021, 0.0013, 2 - distance}, yaw, 0.1)});
    expectSamePictures(wall, views);
}

TEST_F(CardTest, WhatIsTooMuchForTheListIsDrawnAllTheSame) {
    // Before so many walls, so near that one square of each covers the picture.
    const scene::Camera eye = cameraOf(64, 48, 1.4);
    constexpr int kWalls = 300;
    const auto words = static_cast<uint>(pinholesAt(eye.width, eye.height, eye.height));
    const std::size_t room = (words - kLargePartsHead) * sizeof(std::uint32_t) / sizeof(LargePart);
    ASSERT_GT(kWalls * partsOf({eye.width, eye.height}), room);
    std::vector<scene::DepthImage> images;
    for (int i = 0; i < kWalls; ++i)
        images.push_back(takePlane(cameraOf(16, 16, 1.5), {0, 0, 1}, 2 - 1e-5 * i)); // the nearest comes last
    const scene::View view{eye, poseAt({0, 0, 1.99}, 0.1, 0)};
    expectSamePictures(cutInLevels(std::move(images)), std::array{view});
}

} // namespace
} // namespace render
