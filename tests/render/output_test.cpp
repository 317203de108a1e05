// What a display is given of an eye: processors copy it, cards draw it, in either coding of its bytes.

#include "render/images.h"
#include "render/output.h"
#include "render/shaders/shared/srgb.h"
#include "scene/srgb.h"
#include "tests/render/test_device.h"
#include "tests/render/test_scenes.h"

#include <algorithm>
#include <array>
#include <string>
#include <tuple>
#include <vector>

namespace render {
namespace {

constexpr int kWidth = 160, kHeight = 120;

scene::View viewAt(double yaw) {
    return {cameraOf(kWidth, kHeight, 1.2), poseAt({0.4, 0.1, -0.7}, yaw, 0.1)};
}

/// Somebody else's images of one eye.
struct Given {
    DeviceImage colour, depth;
    EyeOutput output;

    Given(const Device& device, VkFormat format) {
        constexpr VkImageUsageFlags kCopied = VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
        colour = makeImage(device, kWidth, kHeight, format, kCopied | VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT,
                           VK_IMAGE_ASPECT_COLOR_BIT);
        depth = makeImage(device, kWidth, kHeight, VK_FORMAT_D32_SFLOAT,
                          kCopied | VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT, VK_IMAGE_ASPECT_DEPTH_BIT);
        output = {.image = colour.image, .format = format, .depth = depth.image, .nearMetres = 0.01f};
    }
};

/// What an image holds, and by how much it is larger than the picture.
void expectGiven(const Device& device, const EyeOutput& output, const EyeImage& own) {
    const int width = own.colour.width(), height = own.colour.height();
    const int right = std::min(width + 1, kWidth), bottom = std::min(height + 1, kHeight);
    const auto colours = readOutputAndClasses(device, output, right, bottom);
    scene::Image<float> depths(right, bottom);
    if (output.depth != VK_NULL_HANDLE) depths = readDepthOutput(device, output, right, bottom);
    for (int y = 0; y < bottom; ++y)
        for (int x = 0; x < right; ++x) {
            const int ownX = std::min(x, width - 1), ownY = std::min(y, height - 1);
            const auto [r, g, b] = own.colour(ownX, ownY);
            ASSERT_EQ(colours(x, y), (scene::Rgba8{r, g, b, own.pixelClass(ownX, ownY)})) << x << ", " << y;
            const float z = own.depthMetres(ownX, ownY);
            if (output.depth != VK_NULL_HANDLE) {
                ASSERT_NEAR(depths(x, y), z > 0 ? 0.01f / z : 0, 1e-6) << x << ", " << y;
            }
        }
}

class OutputTest : public RenderTest {
  protected:
    /// On a processor and on what is taken for a card.
    template <class Expect>
    void onBoth(Expect expect) {
        ASSERT_FALSE(cardDevice().isProcessor());
        for (const Device* device : {&testDevice(), &cardDevice()}) {
            SCOPED_TRACE(device->isProcessor() ? "copied" : "drawn");
            expect(*device, GpuScene(*device, room_.blocks()));
        }
    }
    CutScene room_ = roomFromWithin(160);
};

TEST_F(OutputTest, IsThePictureAndTheEdgeOfASmallOneGoesOnByAPixel) {
    onBoth([](const Device& device, const GpuScene& scene) {
        for (const VkFormat format : {VK_FORMAT_R8G8B8A8_SRGB, VK_FORMAT_R8G8B8A8_UNORM}) {
            Given given(device, format);
            Renderer renderer(device, scene, kWidth, kHeight, 1);
            renderer.letDisplayEnlarge(true);
            for (const auto& [scale, width, height] :
                 {std::tuple{0.37, 59, 44}, {1.0, kWidth, kHeight}, {0.999, kWidth, kHeight}}) {
                Quality quality{.warp = Warp::points};
                quality.resolutionScale = scale;
                renderer.draw(std::array{viewAt(0.4)}, quality, std::array{given.output});
                const EyeImage own = renderer.readBack()[0];
                ASSERT_EQ(own.colour.width(), width);
                ASSERT_EQ(own.colour.height(), height);
                expectGiven(device, given.output, own);
            }
            // Another kind of image, between two frames: without depth.
            given.output.depth = VK_NULL_HANDLE;
            renderer.draw(std::array{viewAt(0.4)}, {}, std::array{given.output});
            expectGiven(device, given.output, renderer.readBack()[0]);
        }
    });
}

TEST_F(OutputTest, OfFramesThatFollowOneAnotherIsEachItsOwnForEachEye) {
    onBoth([](const Device& device, const GpuScene& scene) {
        constexpr std::size_t kImages = 3, kFrames = 7;
        std::vector<std::array<Given, 2>> chain;
        for (std::size_t i = 0; i < kImages; ++i)
            chain.push_back({Given(device, VK_FORMAT_R8G8B8A8_SRGB), Given(device, VK_FORMAT_R8G8B8A8_SRGB)});
        for (const bool isOnePass : {false, true}) {
            Quality quality{.warp = Warp::points};
            quality.isOnePass = isOnePass;
            const auto eyesOf = [](std::size_t frame) {
                const double yaw = 0.4 + 0.05 * static_cast<double>(frame);
                return std::array{viewAt(yaw), viewAt(yaw + 0.02)};
            };
            Renderer renderer(device, scene, kWidth, kHeight, 2), alone(device, scene, kWidth, kHeight, 2);
            for (std::size_t frame = 0; frame < kFrames; ++frame) { // nobody waits in between
                const auto& [left, right] = chain[frame % kImages];
                if (frame % 2 == 1) renderer.keepNext();
                renderer.draw(eyesOf(frame), quality, std::array{left.output, right.output});
            }
            renderer.finish();
            for (std::size_t frame = kFrames - kImages; frame < kFrames; ++frame) {
                alone.draw(eyesOf(frame), quality);
                const std::vector<EyeImage> own = alone.readBack();
                ASSERT_NE(own[0].colour, own[1].colour);
                for (std::size_t eye = 0; eye < 2; ++eye) {
                    SCOPED_TRACE("frame " + std::to_string(frame) + ", eye " + std::to_string(eye));
                    expectGiven(device, chain[frame % kImages][eye].output, own[eye]);
                }
            }
        }
    });
}

TEST(Srgb, ChannelsAreThoseOfPictures) {
    for (int i = 0; i <= 1000; ++i)
        EXPECT_NEAR(encodedChannel(static_cast<float>(i) / 1000), scene::srgbFromLinear(i / 1000.0), 1e-5) << i;
    EXPECT_EQ(encodedChannel(-1), 0.0f);
    EXPECT_NEAR(encodedChannel(7), 1, 1e-6);
    // So near to what the byte stands for that no image takes it for another one: a hundredth of its step.
    for (int i = 0; i <= 255; ++i) {
        const auto decoded = static_cast<double>(decodedChannel(static_cast<float>(i) / 255));
        EXPECT_NEAR(decoded, scene::linearFromSrgb(i / 255.0), 1e-6) << i;
        EXPECT_NEAR(255 * scene::srgbFromLinear(decoded), i, 0.01);
    }
}

} // namespace
} // namespace render
